"""Mends a team's ways over unseen ground so that all of it is seen and the longest way is short.

A way is a chain of straight lanes; what lanes show of the ground is expected by `lane_sight`. Simulated annealing
(Kirkpatrick et al. 1983): bends are moved, left out, put in, handed over, ways exchange their ends, and what is worse
is kept with a chance that falls.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.lane_sight import OddsArray, Sight, sweep


class Ways(NamedTuple):
    """Ways of N vehicles through at most M bends each, in blocks, block centres at whole numbers.

    Attributes
    ----------
    bends : (N, M, 2) float64, where each vehicle is, then its bends.
    counts : (N,) int64, how many of a row count, 1 at least.
    homes : (N, 2) float64, where each vehicle goes at last.
    """

    bends: FloatArray
    counts: IndexArray
    homes: FloatArray


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


class _Work(NamedTuple):
    """What trials share: what is to be seen, what is summed over all lanes, and two ways under trial."""

    sight: Sight
    unseen: FloatArray
    summed: OddsArray
    kept: OddsArray
    trial: FloatArray
    lengths: FloatArray


_LONGEST_FIRST = 0.4
"""Share of trials that change the longest way."""


@compiled
def _draw(rng: np.random.Generator, low: int, high: int) -> int:
    return int(rng.integers(low, high))


@compiled
def _apart(one: FloatArray, other: FloatArray) -> float:
    return math.sqrt((one[0] - other[0]) ** 2 + (one[1] - other[1]) ** 2)


@compiled
def _length(way: FloatArray, count: int, home: FloatArray, way_back: float) -> float:
    length = way_back * _apart(way[count - 1], home) if way_back > 0.0 else 0.0
    for bend in range(1, count):
        length += _apart(way[bend - 1], way[bend])
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
    work: _Work, way: FloatArray, count: int, first: int, last: int, begins_ahead: float, sign: int
) -> float:
    """Add or take off the lanes that end at bends `first` to `last`."""
    change = 0.0
    for bend in range(max(1, first), min(count - 1, last) + 1):
        u, v = way[bend - 1, 0], way[bend - 1, 1]
        if bend == 1:
            part = min(1.0, begins_ahead / max(_apart(way[0], way[1]), 1e-9))
            u, v = u + part * (way[1, 0] - u), v + part * (way[1, 1] - v)
        change += sweep(work.sight, work.unseen, work.summed, u, v, way[bend, 0], way[bend, 1], sign)
    return change


@compiled
def _exchange(
    work: _Work, before: FloatArray, count_before: int, after: FloatArray, count_after: int, begins_ahead: float
) -> float:
    """Put one way in place of another in what is summed, lanes that both have left alone."""
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
    change = _sweep_part(work, before, count_before, same, count_before - tail, begins_ahead, -1)
    return change + _sweep_part(work, after, count_after, same, count_after - tail, begins_ahead, 1)


@compiled
def _cheapest_gap(ways: Ways, vehicle: int, first: FloatArray, last: FloatArray) -> tuple[int, float]:
    """Before which bend of a way a piece from `first` to `last` costs least, and how much it adds."""
    best, least = 1, math.inf
    way, count = ways.bends[vehicle], ways.counts[vehicle]
    for bend in range(1, count + 1):
        added = _apart(way[bend - 1], first)
        if bend < count:
            added += _apart(last, way[bend]) - _apart(way[bend - 1], way[bend])
        if added < least:
            best, least = bend, added
    return best, least


@compiled
def _insert(way: FloatArray, count: int, bend: int, u: float, v: float, shape: tuple[int, int]) -> None:
    for place in range(count, bend, -1):
        way[place, 0], way[place, 1] = way[place - 1, 0], way[place - 1, 1]
    way[bend, 0] = min(max(u, 0.0), shape[0] - 1.0)
    way[bend, 1] = min(max(v, 0.0), shape[1] - 1.0)


@compiled
def _bend_anew(way: FloatArray, count: int, shape: tuple[int, int], rng: np.random.Generator) -> int:
    """Move a bend, leave one out, put one in, or turn a stretch round; returns the new number of bends."""
    kind = rng.random()
    if kind < 0.72 and count > 1:
        bend = _draw(rng, 1, count)
        far = 0.25 * 4.0 ** _draw(rng, 0, 3)
        way[bend, 0] = min(max(way[bend, 0] + far * rng.normal(), 0.0), shape[0] - 1.0)
        way[bend, 1] = min(max(way[bend, 1] + far * rng.normal(), 0.0), shape[1] - 1.0)
    elif kind < 0.88 and count > 2:
        bend = _draw(rng, 1, count)
        for place in range(bend, count - 1):
            way[place, 0], way[place, 1] = way[place + 1, 0], way[place + 1, 1]
        return count - 1
    elif kind < 0.92 or count < 4:
        if count >= len(way):
            return count
        bend = _draw(rng, 1, count + 1)
        u, v = way[bend - 1, 0], way[bend - 1, 1]
        if bend < count:
            u, v = 0.5 * (u + way[bend, 0]), 0.5 * (v + way[bend, 1])
        _insert(way, count, bend, u + 2.0 * rng.normal(), v + 2.0 * rng.normal(), shape)
        return count + 1
    else:
        first = _draw(rng, 1, count - 1)
        last = _draw(rng, first + 1, count)
        way[first : last + 1] = way[first : last + 1][::-1].copy()
    return count


@compiled
def _unseen_place(work: _Work, rng: np.random.Generator) -> tuple[int, int]:
    """A block that is likely to stay unseen; (-1, -1) when none was found at once."""
    columns, rows = work.unseen.shape
    for _ in range(40):
        column, row = _draw(rng, 0, columns), _draw(rng, 0, rows)
        if work.unseen[column, row] > 0.0 and rng.random() < work.sight.missed[work.summed[column, row]]:
            return column, row
    return -1, -1


@compiled
def _nearest_way(ways: Ways, lengths: FloatArray, place: FloatArray) -> tuple[int, int]:
    """Into which way, and before which bend, a place fits best; -1 when all are full."""
    longest = lengths.max()
    least, vehicle, before = math.inf, -1, 1
    for index in range(len(lengths)):
        if ways.counts[index] >= ways.bends.shape[1]:
            continue
        bend, added = _cheapest_gap(ways, index, place, place)
        cost = added + 4.0 * max(0.0, lengths[index] + added - longest)
        if cost < least:
            least, vehicle, before = cost, index, bend
    return vehicle, before


@compiled
def _hand_over(ways: Ways, giver: int, taker: int, trial: FloatArray, rng: np.random.Generator) -> tuple[int, int]:
    """Give up to three bends to another way, or let both exchange their ends; returns both new numbers of bends."""
    most = ways.bends.shape[1]
    mine, theirs = ways.bends[giver], ways.bends[taker]
    count, other = ways.counts[giver], ways.counts[taker]
    if rng.random() < 0.5:
        cut, there = _draw(rng, 1, count + 1), _draw(rng, 1, other + 1)
        if cut < count and rng.random() < 0.7:
            there, _ = _cheapest_gap(ways, taker, mine[cut], mine[cut])
        if cut + other - there > most or there + count - cut > most:
            return count, other
        trial[0, cut : cut + other - there] = theirs[there:other]
        trial[1, there : there + count - cut] = mine[cut:count]
        return cut + other - there, there + count - cut
    if count < 2:
        return count, other
    first = _draw(rng, 1, count)
    pieces = min(1 + _draw(rng, 0, 3), count - first)
    if other + pieces > most:
        return count, other
    piece = mine[first : first + pieces].copy()
    if rng.random() < 0.5:
        piece = piece[::-1].copy()
    before, _ = _cheapest_gap(ways, taker, piece[0], piece[pieces - 1])
    trial[0, first : count - pieces] = mine[first + pieces : count]
    trial[1, before + pieces : other + pieces] = theirs[before:other]
    trial[1, before : before + pieces] = piece
    return count - pieces, other + pieces


@compiled
def _propose(ways: Ways, work: _Work, rng: np.random.Generator) -> tuple[int, int, int, int]:
    """Write one or two changed ways into the trial: whose they are (-1 for none), and their numbers of bends."""
    vehicles = len(ways.counts)
    one = _draw(rng, 0, vehicles)
    if rng.random() < _LONGEST_FIRST:
        one = int(np.argmax(work.lengths))
    other, other_count = -1, 0
    kind = rng.random()
    if kind < 0.07:
        column, row = _unseen_place(work, rng)
        if column >= 0:
            place = np.array([column + rng.normal(), row + rng.normal()])
            one, bend = _nearest_way(ways, work.lengths, place)
            if one >= 0:
                work.trial[0] = ways.bends[one]
                _insert(work.trial[0], ways.counts[one], bend, place[0], place[1], work.unseen.shape)
                return one, ways.counts[one] + 1, other, other_count
        return -1, 0, other, other_count
    work.trial[0] = ways.bends[one]
    if kind < 0.82 or vehicles < 2:
        return one, _bend_anew(work.trial[0], ways.counts[one], work.unseen.shape, rng), other, other_count
    other = (one + _draw(rng, 1, vehicles)) % vehicles
    work.trial[1] = ways.bends[other]
    count, other_count = _hand_over(ways, one, other, work.trial, rng)
    return one, count, other, other_count


@compiled
def mend_lanes(
    ways: Ways,
    sight: Sight,
    unseen: FloatArray,
    costs: LaneCosts,
    trials: int,
    hot: float,
    cool: float,
    rng: np.random.Generator,
) -> FloatArray:
    """Try changes to a team's ways and keep the best found.

    Parameters
    ----------
    ways : written to.
    unseen : (columns, rows) float64, how much of each block is to be seen.
    trials : how many changes to try.
    hot, cool : worsening in blocks that is kept with a chance of 1/e at first and at last.
    rng : of what is tried.

    Returns
    -------
    (N,) float64, lengths of the ways in blocks, the weighed way home included.
    """
    vehicles, most = ways.bends.shape[0], ways.bends.shape[1]
    summed = np.zeros(unseen.shape, dtype=np.int32)
    work = _Work(sight, unseen, summed, summed.copy(), np.zeros((2, most, 2)), np.zeros(vehicles))
    lengths = work.lengths
    left = unseen.sum()
    for vehicle in range(vehicles):
        way, count = ways.bends[vehicle], ways.counts[vehicle]
        left += _sweep_part(work, way, count, 1, count, costs.begins_ahead, 1)
        lengths[vehicle] = _length(way, count, ways.homes[vehicle], costs.way_back)
    cost = _weight(lengths) + _worth(costs, left)
    least, best_bends, best_counts = cost, ways.bends.copy(), ways.counts.copy()
    for trial in range(trials):
        one, count, other, other_count = _propose(ways, work, rng)
        if one < 0:
            continue
        heat = hot * (cool / hot) ** (trial / trials)
        most = cost - heat * math.log(1.0 - rng.random())
        length_before, left_before = lengths[one], left
        other_before = lengths[other] if other >= 0 else 0.0
        lengths[one] = _length(work.trial[0], count, ways.homes[one], costs.way_back)
        if other >= 0:
            lengths[other] = _length(work.trial[1], other_count, ways.homes[other], costs.way_back)
        changed = _weight(lengths)
        if changed <= most:  # else no ground is worth it
            work.kept[:] = summed
            left += _exchange(work, ways.bends[one], ways.counts[one], work.trial[0], count, costs.begins_ahead)
            if other >= 0:
                left += _exchange(
                    work, ways.bends[other], ways.counts[other], work.trial[1], other_count, costs.begins_ahead
                )
            changed += _worth(costs, left)
            if changed > most:
                summed[:] = work.kept
        if changed <= most:
            cost = changed
            ways.bends[one], ways.counts[one] = work.trial[0], count
            if other >= 0:
                ways.bends[other], ways.counts[other] = work.trial[1], other_count
            if cost < least - 1e-9:
                least = cost
                best_bends[:], best_counts[:] = ways.bends, ways.counts
        else:
            lengths[one], left = length_before, left_before
            if other >= 0:
                lengths[other] = other_before
    ways.bends[:], ways.counts[:] = best_bends, best_counts
    for vehicle in range(vehicles):
        lengths[vehicle] = _length(ways.bends[vehicle], ways.counts[vehicle], ways.homes[vehicle], costs.way_back)
    return lengths
