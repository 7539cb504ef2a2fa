"""Changes to a team's ways that an annealing tries: bends moved, left out, put in, handed over; ends exchanged."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.lane_sight import OddsArray, Sight, chance_missed


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


class Expectation(NamedTuple):
    """What a team's ways are expected to leave unseen, and how long they are.

    Attributes
    ----------
    sight : chances of seeing.
    unseen : (columns, rows) float64, how much of each block is to be seen.
    open : (K,) int64, flat numbers of the blocks that hold anything unseen.
    summed : (columns, rows) int32, sums of odds over all lanes.
    lengths : (N,) float64, of all ways in blocks.
    """

    sight: Sight
    unseen: FloatArray
    open: IndexArray
    summed: OddsArray
    lengths: FloatArray


class Trial(NamedTuple):
    """One or two ways in place of others.

    Attributes
    ----------
    vehicles : (2,) int64, whose ways are changed; -1 for none.
    bends : (2, M, 2) float64, their bends as in `Ways`.
    counts : (2,) int64, how many count.
    """

    vehicles: IndexArray
    bends: FloatArray
    counts: IndexArray


_LONGEST_FIRST = 0.4
"""Share of trials that change the longest way."""
_DRAWS = 40
"""So often a block is drawn until one is likely to stay unseen."""


@compiled
def _draw(rng: np.random.Generator, low: int, high: int) -> int:
    return int(rng.integers(low, high))


@compiled
def apart(one: FloatArray, other: FloatArray) -> float:
    return math.sqrt((one[0] - other[0]) ** 2 + (one[1] - other[1]) ** 2)


@compiled
def _cheapest_gap(ways: Ways, vehicle: int, first: FloatArray, last: FloatArray) -> tuple[int, float]:
    """Before which bend of a way a piece from `first` to `last` costs least, and how much it adds."""
    best, least = 1, math.inf
    way, count = ways.bends[vehicle], ways.counts[vehicle]
    for bend in range(1, count + 1):
        added = apart(way[bend - 1], first)
        if bend < count:
            added += apart(last, way[bend]) - apart(way[bend - 1], way[bend])
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
def _unseen_place(expectation: Expectation, rng: np.random.Generator) -> tuple[int, int]:
    """A block that is likely to stay unseen; (-1, -1) when none was found at once."""
    rows = expectation.unseen.shape[1]
    for _ in range(_DRAWS if len(expectation.open) else 0):
        block = expectation.open[_draw(rng, 0, len(expectation.open))]
        column, row = block // rows, block % rows
        if rng.random() < chance_missed(expectation.sight.missed, expectation.summed[column, row]):
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
def _to_unseen(ways: Ways, expectation: Expectation, trial: Trial, rng: np.random.Generator) -> None:
    """Lead a way to ground that is likely to stay unseen."""
    trial.vehicles[0] = -1
    column, row = _unseen_place(expectation, rng)
    if column < 0:
        return
    place = np.array([column + rng.normal(), row + rng.normal()])
    one, bend = _nearest_way(ways, expectation.lengths, place)
    if one >= 0:
        trial.vehicles[0] = one
        trial.bends[0] = ways.bends[one]
        _insert(trial.bends[0], ways.counts[one], bend, place[0], place[1], expectation.unseen.shape)
        trial.counts[0] = ways.counts[one] + 1


@compiled
def propose(ways: Ways, expectation: Expectation, trial: Trial, rng: np.random.Generator) -> None:
    """Write one or two changed ways into the trial."""
    vehicles, shape = len(ways.counts), expectation.unseen.shape
    one = _draw(rng, 0, vehicles)
    if rng.random() < _LONGEST_FIRST:
        one = int(np.argmax(expectation.lengths))
    trial.vehicles[0], trial.vehicles[1] = one, -1
    kind = rng.random()
    if kind < 0.07:
        _to_unseen(ways, expectation, trial, rng)
        return
    trial.bends[0] = ways.bends[one]
    if kind < 0.82 or vehicles < 2:
        trial.counts[0] = _bend_anew(trial.bends[0], ways.counts[one], shape, rng)
        return
    other = (one + _draw(rng, 1, vehicles)) % vehicles
    trial.vehicles[1] = other
    trial.bends[1] = ways.bends[other]
    trial.counts[0], trial.counts[1] = _hand_over(ways, one, other, trial.bends, rng)
