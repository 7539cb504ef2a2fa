"""What flying along straight lanes is expected to show of unseen ground, as compiled kernels.

Ground is seen from what lies nearest to it of a lane, at the height that the lane has there above the expected ground:
up a slope a vehicle sees farther in the map than down. The farther away, the likelier terrain hides it; passes over the
same ground are taken to be independent. Chances are kept as whole numbers of `-log(1 - chance)`, so that adding and
taking off a lane is exact.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.expected_ground import ExpectedGround, height_at, level_ground
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray

_SEEN_FROM = (1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.997, 0.992, 0.982, 0.965, 0.885, 0.64, 0.4, 0.14,
              0.05, 0.0)  # fmt: skip
"""Share of blocks of known ground seen from straight ways, by distance in space from what lies nearest of the way in
the map, in 16ths of a sensing range, each in the middle of its 16th.

The mean of what was measured over the exploration bench's hills, flown 3 m above the ground with a range of 8 m, and
over the Jacksboro ridge, 63 m above it with a range of 350 m; they differ by 0.15 at most.
"""
_SEEN_FROM_AFAR = (1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.999, 0.989, 0.973, 0.944, 0.899, 0.839, 0.754, 0.656, 0.486,
                   0.211, 0.011, 0.0, 0.0)  # fmt: skip
"""The same over the bench's hills, when nothing is known of them and distances are taken as if they were level."""
_PER_RANGE = 16
_FARTHEST = 1.05
"""Farther away in the map than so many sensing ranges nothing is seen."""
_ROWS = 9
"""Of odds, from ground whose slope is known to such whose slope is unknown."""
_UNIT = 0.05
_SURE = 5.0
"""The most that one look counts for: nothing is seen for certain."""
_CERTAIN = 46
"""Odds of a look that shows nine tenths: what it did not show, terrain hides, and hardly any look will show it."""
_PER_SQUARED_BLOCK = 8.0
_MOST_SUMMED = 4_000
"""More odds than that leave nothing unseen."""
_LONGEST = 400
"""Heights along a lane are looked up in so many places at most."""

OddsArray = npt.NDArray[np.int32]


class Sight(NamedTuple):
    """Chances of seeing, for blocks of ground of one size.

    Attributes
    ----------
    odds : (_ROWS, K) int32, `-log(1 - chance)` in units by squared distance in eighths of squared blocks.
    row : (columns, rows) int64, which row of the odds holds for a block: the less of its slope is known the higher.
    missed : (S,) float64, chance that ground stays unseen, by the sum of odds.
    looked : (columns, rows) int32, odds that a look must have to show what is unseen of a block, after looks that did
        not.
    reach : farther than so many blocks nothing is seen.
    above : height of vehicles above the ground, in blocks.
    ground : of these blocks.
    heights_along : (_LONGEST + 1,) float64, room for the heights along a lane.
    """

    odds: OddsArray
    row: IndexArray
    missed: FloatArray
    looked: OddsArray
    reach: float
    above: float
    ground: ExpectedGround
    heights_along: FloatArray

    def over(self, ground: ExpectedGround, looked: OddsArray) -> Sight:
        """The same chances over other ground."""
        row = np.rint((_ROWS - 1) * np.sqrt(ground.doubt)).astype(np.int64)
        return self._replace(row=row, looked=looked, ground=ground)


def sight_of(range_blocks: float, above_blocks: float, shape: tuple[int, int]) -> Sight:
    """Chances for a sensor with a range in blocks, over so many columns and rows of unknown blocks nobody looked at."""
    farthest = range_blocks * len(_SEEN_FROM) / _PER_RANGE
    distances = np.sqrt(np.arange(int(farthest**2 * _PER_SQUARED_BLOCK) + 1) / _PER_SQUARED_BLOCK) / range_blocks
    middles = (np.arange(len(_SEEN_FROM)) + 0.5) / _PER_RANGE
    known, afar = (np.interp(distances, middles, seen) for seen in (_SEEN_FROM, _SEEN_FROM_AFAR))
    chances = known + np.linspace(0.0, 1.0, _ROWS)[:, None] * (afar - known)
    odds = np.minimum(-np.log(np.maximum(1.0 - chances, 1e-9)), _SURE) / _UNIT
    missed = np.exp(-_UNIT * np.arange(_MOST_SUMMED))
    return Sight(
        np.round(odds).astype(np.int32), np.full(shape, _ROWS - 1), missed, np.zeros(shape, dtype=np.int32),
        _FARTHEST * range_blocks, above_blocks, level_ground(shape), np.zeros(_LONGEST + 1),
    )  # fmt: skip


@compiled
def chance_missed(missed: FloatArray, summed: int) -> float:
    """The chance that ground stays unseen under so many summed odds."""
    return float(missed[min(summed, len(missed) - 1)])


@compiled
def look_around(sight: Sight, places: FloatArray, most: int) -> None:
    """Note that vehicles looked around at places: (N, 2) float64 in blocks; `most` odds a look counts for at most."""
    odds, looked, radius, heights = sight.odds, sight.looked, sight.reach, sight.ground.heights
    for index in range(len(places)):
        u, v = places[index, 0], places[index, 1]
        up = height_at(heights, u, v) + sight.above
        for column in range(max(0, int(u - radius)), min(looked.shape[0] - 1, int(u + radius) + 1) + 1):
            for row in range(max(0, int(v - radius)), min(looked.shape[1] - 1, int(v + radius) + 1) + 1):
                squared = (column - u) ** 2 + (row - v) ** 2 + (heights[column, row] - up) ** 2
                eighths = int(squared * _PER_SQUARED_BLOCK)
                if eighths < odds.shape[1]:
                    shown = odds[sight.row[column, row], eighths]
                    looked[column, row] = max(looked[column, row], most if shown > _CERTAIN else min(most, shown))


@compiled
def _heights_along(sight: Sight, a_u: float, a_v: float, b_u: float, b_v: float, length: float) -> int:
    """Look up how high a lane is in places as far apart as blocks are; returns how many pieces lie between them."""
    pieces = min(len(sight.heights_along) - 1, max(1, int(length + 0.5)))
    for piece in range(pieces + 1):
        part = piece / pieces
        height = height_at(sight.ground.heights, a_u + part * (b_u - a_u), a_v + part * (b_v - a_v))
        sight.heights_along[piece] = height + sight.above
    return pieces


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
    odds, missed, looked, radius = sight.odds, sight.missed, sight.looked, sight.reach
    heights, along = sight.ground.heights, sight.heights_along
    du, dv = b_u - a_u, b_v - a_v
    squared_length = du * du + dv * dv + 1e-12
    length, shrink = math.sqrt(squared_length), 1.0 / squared_length
    pieces = _heights_along(sight, a_u, a_v, b_u, b_v, length)
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
                squared, up = across_0 + (row - a_v) ** 2, along[0]
            elif part >= 1.0:
                squared, up = (column - b_u) ** 2 + (row - b_v) ** 2, along[pieces]
            else:
                squared = ((column - a_u) * dv - (row - a_v) * du) ** 2 * shrink
                piece = int(part * pieces)
                up = along[piece] + (part * pieces - piece) * (along[piece + 1] - along[piece])
            eighths = int((squared + (up - heights[column, row]) ** 2) * _PER_SQUARED_BLOCK)
            if eighths >= odds.shape[1]:
                continue
            gained = odds[sight.row[column, row], eighths] - looked[column, row]
            if gained <= 0:
                continue
            before = summed[column, row]
            after = before + sign * gained
            summed[column, row] = after
            change += weight * (chance_missed(missed, after) - chance_missed(missed, before))
    return change
