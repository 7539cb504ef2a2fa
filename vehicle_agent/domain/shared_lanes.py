"""Mends a team's ways over unseen ground so that all of it is seen and the longest way is short.

A way is a chain of straight lanes; what lanes show of the ground is expected by `lane_sight`. Simulated annealing
(Kirkpatrick et al. 1983): `lane_trials` changes the ways, and what is worse is kept with a chance that falls.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.expected_ground import ExpectedGround, flown_length
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.lane_sight import OddsArray, Sight, sweep
from vehicle_agent.domain.lane_trials import Expectation, Trial, Ways, apart, propose


class LaneCosts(NamedTuple):
    """What makes ways dear.

    Attributes
    ----------
    way_back : weight in [0, 1] of the way home.
    unseen : length that a unit of ground that stays unseen is worth, blocks.
    dearer : so many times that what stays unseen beyond `allowed` is worth more.
    allowed : as much ground may stay unseen.
    begins_ahead : so far ahead of a vehicle its first lane begins to show anything new, blocks: what lies around it
        and is unseen cannot be seen from there.
    """

    way_back: float
    unseen: float
    dearer: float
    allowed: float
    begins_ahead: float


class _Kept(NamedTuple):
    """What was before a trial.

    Attributes
    ----------
    summed : (columns, rows) int32, sums of odds, valid in the columns from the first to before the second of `columns`.
    columns : (2,) int64.
    lengths : (N,) float64.
    """

    summed: OddsArray
    columns: IndexArray
    lengths: FloatArray


@compiled
def _length(way: FloatArray, count: int, home: FloatArray, ground: ExpectedGround, way_back: float) -> float:
    length = way_back * apart(way[count - 1], home) if way_back > 0.0 else 0.0
    for bend in range(1, count):
        length += flown_length(ground, way[bend - 1], way[bend])
    return length


@compiled
def _weight(lengths: FloatArray) -> float:
    """The tenth-power mean of all lengths: near enough to the longest alone."""
    longest, total = 1e-6, 0.0
    for length in lengths:
        longest = max(longest, length)
    for length in lengths:
        fifth = (length / longest) ** 5
        total += fifth * fifth
    mean: float = longest * (total / len(lengths)) ** 0.1
    return mean


@compiled
def _worth(costs: LaneCosts, left: float) -> float:
    worth: float = costs.unseen * (left + costs.dearer * max(0.0, left - costs.allowed))
    return worth


@compiled
def _sweep_part(
    expectation: Expectation, way: FloatArray, count: int, first: int, last: int, begins_ahead: float, sign: int
) -> float:
    """Add or take off the lanes that end at bends `first` to `last`."""
    change = 0.0
    for bend in range(max(1, first), min(count - 1, last) + 1):
        u, v = way[bend - 1, 0], way[bend - 1, 1]
        if bend == 1:
            part = min(1.0, begins_ahead / max(apart(way[0], way[1]), 1e-9))
            u, v = u + part * (way[1, 0] - u), v + part * (way[1, 1] - v)
        change += sweep(
            expectation.sight, expectation.unseen, expectation.summed, u, v, way[bend, 0], way[bend, 1], sign
        )
    return change


@compiled
def _stretch(before: FloatArray, count_before: int, after: FloatArray, count_after: int) -> tuple[int, int]:
    """Where two ways differ: the first bend that they do not share, and how many last ones they share."""
    shorter = min(count_before, count_after)
    same = 1
    while same < shorter and before[same, 0] == after[same, 0] and before[same, 1] == after[same, 1]:
        same += 1
    tail = 0
    while (
        tail < shorter - same
        and before[count_before - 1 - tail, 0] == after[count_after - 1 - tail, 0]
        and before[count_before - 1 - tail, 1] == after[count_after - 1 - tail, 1]
    ):
        tail += 1
    return same, tail


@compiled
def _exchange(expectation: Expectation, ways: Ways, trial: Trial, place: int, begins_ahead: float) -> float:
    """Put a way under trial in place of the present one in what is summed, lanes that both have left alone."""
    vehicle = trial.vehicles[place]
    before, count_before = ways.bends[vehicle], ways.counts[vehicle]
    after, count_after = trial.bends[place], trial.counts[place]
    same, tail = _stretch(before, count_before, after, count_after)
    change = _sweep_part(expectation, before, count_before, same, count_before - tail, begins_ahead, -1)
    return change + _sweep_part(expectation, after, count_after, same, count_after - tail, begins_ahead, 1)


@compiled
def _keep(kept: _Kept, expectation: Expectation, ways: Ways, trial: Trial) -> None:
    """Keep what is summed where a trial can change it."""
    low, high = math.inf, -math.inf
    for place in range(2):
        vehicle = trial.vehicles[place]
        if vehicle < 0:
            continue
        before, after = ways.bends[vehicle], trial.bends[place]
        same, tail = _stretch(before, ways.counts[vehicle], after, trial.counts[place])
        for way, count in ((before, ways.counts[vehicle]), (after, trial.counts[place])):
            for bend in range(same - 1, min(count, count - tail + 1)):
                low, high = min(low, way[bend, 0]), max(high, way[bend, 0])
    reach, summed = expectation.sight.reach, expectation.summed
    first, end = max(0, int(low - reach)), min(len(summed), int(high + reach) + 1)
    kept.columns[0], kept.columns[1] = first, end
    kept.summed[first:end] = summed[first:end]


@compiled
def _cost(
    expectation: Expectation, ways: Ways, trial: Trial, kept: _Kept, costs: LaneCosts, left: float, most: float
) -> tuple[float, float]:
    """What the ways cost with those under trial, and what they leave: infinite where that is sure to be above `most`.

    Then all is as before; else what is summed and the lengths are those of the trial.
    """
    kept.lengths[:] = expectation.lengths
    for place in range(2):
        vehicle = trial.vehicles[place]
        if vehicle >= 0:
            way, count = trial.bends[place], trial.counts[place]
            expectation.lengths[vehicle] = _length(
                way, count, ways.homes[vehicle], expectation.sight.ground, costs.way_back
            )
    cost = _weight(expectation.lengths)
    if cost <= most:  # else no ground is worth it
        _keep(kept, expectation, ways, trial)
        for place in range(2):
            if trial.vehicles[place] >= 0:
                left += _exchange(expectation, ways, trial, place, costs.begins_ahead)
        cost += _worth(costs, left)
        if cost <= most:
            return cost, left
        first, end = kept.columns
        expectation.summed[first:end] = kept.summed[first:end]
    expectation.lengths[:] = kept.lengths
    return math.inf, left


@compiled
def _expected(ways: Ways, sight: Sight, unseen: FloatArray, costs: LaneCosts) -> tuple[Expectation, float]:
    """What the ways are expected to show, and how much they leave."""
    vehicles = len(ways.counts)
    summed = np.zeros(unseen.shape, dtype=np.int32)
    expectation = Expectation(sight, unseen, np.flatnonzero(unseen), summed, np.zeros(vehicles))
    left = unseen.sum()
    for vehicle in range(vehicles):
        way, count = ways.bends[vehicle], ways.counts[vehicle]
        left += _sweep_part(expectation, way, count, 1, count, costs.begins_ahead, 1)
        expectation.lengths[vehicle] = _length(way, count, ways.homes[vehicle], sight.ground, costs.way_back)
    return expectation, left


class Annealing(NamedTuple):
    """How far the mending of ways is.

    Attributes
    ----------
    trials : how many changes are to be tried in all.
    hot, cool : worsening in blocks that is kept with a chance of 1/e at first and at last.
    tried : (1,) int64, how many changes were tried.
    best_bends, best_counts : of the best ways found, as in `Ways`.
    least : (1,) float64, what they cost.
    """

    trials: int
    hot: float
    cool: float
    tried: IndexArray
    best_bends: FloatArray
    best_counts: IndexArray
    least: FloatArray


def annealing_of(ways: Ways, trials: int, hot: float, cool: float) -> Annealing:
    """The mending of these ways before anything was tried."""
    nothing_tried = np.zeros(1, dtype=np.int64)
    return Annealing(trials, hot, cool, nothing_tried, ways.bends.copy(), ways.counts.copy(), np.full(1, np.inf))


@compiled
def mend_lanes(
    ways: Ways,
    annealing: Annealing,
    sight: Sight,
    unseen: FloatArray,
    costs: LaneCosts,
    most: int,
    rng: np.random.Generator,
) -> bool:
    """Try changes to a team's ways, a part of them at a time; True when all were tried, and the ways are the best then.

    Parameters
    ----------
    ways : where the annealing has come to; written to.
    annealing : of these ways; written to.
    unseen : (columns, rows) float64, how much of each block is to be seen.
    most : how many changes to try now at most.
    rng : of what is tried.
    """
    expectation, left = _expected(ways, sight, unseen, costs)
    most_bends, vehicles = ways.bends.shape[1], len(ways.counts)
    trial = Trial(np.zeros(2, dtype=np.int64), np.zeros((2, most_bends, 2)), np.zeros(2, dtype=np.int64))
    kept = _Kept(expectation.summed.copy(), np.zeros(2, dtype=np.int64), np.zeros(vehicles))
    cost = _weight(expectation.lengths) + _worth(costs, left)
    first = annealing.tried[0]
    if first == 0:
        annealing.least[0] = cost
    annealing.tried[0] = min(annealing.trials, first + most)
    for number in range(first, annealing.tried[0]):
        propose(ways, expectation, trial, rng)
        if trial.vehicles[0] < 0:
            continue
        heat = annealing.hot * (annealing.cool / annealing.hot) ** (number / annealing.trials)
        worst = cost - heat * math.log(1.0 - rng.random())
        changed, left_now = _cost(expectation, ways, trial, kept, costs, left, worst)
        if changed > worst:
            continue
        cost, left = changed, left_now
        for place in range(2):
            vehicle = trial.vehicles[place]
            if vehicle >= 0:
                ways.bends[vehicle], ways.counts[vehicle] = trial.bends[place], trial.counts[place]
        if cost < annealing.least[0] - 1e-9:
            annealing.least[0] = cost
            annealing.best_bends[:], annealing.best_counts[:] = ways.bends, ways.counts
    if annealing.tried[0] < annealing.trials:
        return False
    ways.bends[:], ways.counts[:] = annealing.best_bends, annealing.best_counts
    return True
