"""What flying along straight lanes is expected to show of unseen ground, as compiled kernels.

The farther ground lies beside a way, the likelier terrain hides it; passes over the same ground are taken to be
independent. Chances are kept as whole numbers of `-log(1 - chance)`, so that adding and taking off a lane is exact.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray

_SEEN_BESIDE = (1.0, 1.0, 1.0, 0.998, 0.995, 0.984, 0.977, 0.959, 0.934, 0.903, 0.858, 0.807, 0.742, 0.638, 0.503,
                0.247, 0.039, 0.0)  # fmt: skip
"""Share of ground seen beside straight ways, by distance in 16ths of a sensing range, each in the middle of its 16th.

Measured over the exploration bench's random hills, flown 3 m above the ground with a range of 8 m.
"""
_PER_RANGE = 16
_FARTHER = 1.3
"""Level ground among hills is seen up to so many times as far as most."""
_UNIT = 0.05
_SURE = 5.0
"""The most that one look counts for: nothing is seen for certain."""
_PER_SQUARED_BLOCK = 8.0
_MOST_SUMMED = 4_000
"""More odds than that leave nothing unseen."""

OddsArray = npt.NDArray[np.int32]


class Sight(NamedTuple):
    """Chances of seeing, for blocks of ground of one size.

    Attributes
    ----------
    odds : (K,) int32, `-log(1 - chance)` in units by squared distance in eighths of squared blocks.
    missed : (S,) float64, chance that ground stays unseen, by the sum of odds.
    looked : (columns, rows) int32, odds of the nearest look that did not show what is unseen of a block: only nearer
        looks show it.
    reach : farther than so many blocks nothing is seen.
    stretch : (columns, rows) float64, by how much the squared distance of each block counts for more: of steep ground
        a vehicle low above it sees less.
    """

    odds: OddsArray
    missed: FloatArray
    looked: OddsArray
    reach: float
    stretch: FloatArray


def sight_of(range_blocks: float, shape: tuple[int, int]) -> Sight:
    """Chances for a sensor with a range in blocks, over so many columns and rows of blocks nobody looked at."""
    farthest = range_blocks * len(_SEEN_BESIDE) / _PER_RANGE
    distances = np.sqrt(np.arange(int(farthest**2 * _PER_SQUARED_BLOCK) + 1) / _PER_SQUARED_BLOCK) / range_blocks
    chances = np.interp(distances, (np.arange(len(_SEEN_BESIDE)) + 0.5) / _PER_RANGE, _SEEN_BESIDE)
    reach = _FARTHER * math.sqrt(len(distances) / _PER_SQUARED_BLOCK)
    odds = np.minimum(-np.log(np.maximum(1.0 - chances, 1e-9)), _SURE) / _UNIT
    missed = np.exp(-_UNIT * np.arange(_MOST_SUMMED))
    return Sight(np.round(odds).astype(np.int32), missed, np.zeros(shape, dtype=np.int32), reach, np.ones(shape))


@compiled
def chance_missed(missed: FloatArray, summed: int) -> float:
    """The chance that ground stays unseen under so many summed odds."""
    return float(missed[min(summed, len(missed) - 1)])


@compiled
def look_around(sight: Sight, places: FloatArray, most: int) -> None:
    """Note that vehicles looked around at places: (N, 2) float64 in blocks; `most` odds a look counts for at most."""
    odds, looked, radius = sight.odds, sight.looked, sight.reach
    for index in range(len(places)):
        u, v = places[index, 0], places[index, 1]
        for column in range(max(0, int(u - radius)), min(looked.shape[0] - 1, int(u + radius) + 1) + 1):
            for row in range(max(0, int(v - radius)), min(looked.shape[1] - 1, int(v + radius) + 1) + 1):
                squared = int(((column - u) ** 2 + (row - v) ** 2) * sight.stretch[column, row] * _PER_SQUARED_BLOCK)
                if squared < len(odds):
                    looked[column, row] = max(looked[column, row], min(most, odds[squared]))


@compiled
def sweep(
    sight: Sight, unseen: FloatArray, summed: OddsArray, a_u: float, a_v: float, b_u: float, b_v: float, sign: int
) -> float:
    """Add (`sign` 1) or take off (-1) a straight lane from what is summed; returns the change of what stays unseen.

    Parameters
    ----------
    unseen : (columns, rows) float64, what is unseen of each block now.
    summed : (columns, rows) int32, sums of odds over all lanes, kept where anything is unseen; written to.
    a_u, a_v, b_u, b_v : ends in blocks, block centres at whole numbers.
    """
    odds, missed, looked, radius, stretch = sight.odds, sight.missed, sight.looked, sight.reach, sight.stretch
    du, dv = b_u - a_u, b_v - a_v
    squared_length = du * du + dv * dv + 1e-12
    length, shrink = math.sqrt(squared_length), 1.0 / squared_length
    side_u, side_v = -dv / length * radius, du / length * radius
    change = 0.0
    columns, rows = unseen.shape
    for column in range(max(0, math.ceil(min(a_u, b_u) - radius)), min(columns - 1, int(max(a_u, b_u) + radius)) + 1):
        low, high = math.inf, -math.inf
        for u, v in ((a_u, a_v), (b_u, b_v)):
            if abs(column - u) <= radius:
                half = math.sqrt(radius * radius - (column - u) ** 2)
                low, high = min(low, v - half), max(high, v + half)
        if abs(du) > 1e-9:
            for side in (-1.0, 1.0):
                part = (column - a_u - side * side_u) / du
                if 0.0 <= part <= 1.0:
                    edge = a_v + side * side_v + part * dv
                    low, high = min(low, edge), max(high, edge)
        if low > high:
            continue
        along_0, across_0 = ((column - a_u) * du - a_v * dv) * shrink, (column - a_u) ** 2
        for row in range(max(0, math.ceil(low)), min(rows - 1, math.floor(high)) + 1):
            weight = unseen[column, row]
            if weight <= 0.0:
                continue
            part = along_0 + row * dv * shrink
            if part <= 0.0:
                squared = across_0 + (row - a_v) ** 2
            elif part >= 1.0:
                squared = (column - b_u) ** 2 + (row - b_v) ** 2
            else:
                squared = ((column - a_u) * dv - (row - a_v) * du) ** 2 * shrink
            eighths = int(squared * stretch[column, row] * _PER_SQUARED_BLOCK)
            if eighths >= len(odds):
                continue
            gained = odds[eighths] - looked[column, row]
            if gained <= 0:
                continue
            before = summed[column, row]
            after = before + sign * gained
            summed[column, row] = after
            change += weight * (chance_missed(missed, after) - chance_missed(missed, before))
    return change
