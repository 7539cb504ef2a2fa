"""The lowest leg towards a place that keeps clear of ground and teammates, as compiled kernels."""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.domain.clearance import clear_legs, ground_heights
from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.segments import come_too_near

_HEIGHTS = 17
"""Heights tried in the height band: closer together near the ground, where vehicles fly."""
_SHORTENINGS = (1.0, 0.5, 0.25, 0.125)


@compiled
def is_clear(
    start: FloatArray, end: FloatArray, surface: FloatArray, west: float, south: float, cell: float,
    lowest: float, highest: float, ceiling: float, longest: float, rivals: FloatArray, separation: float,
) -> bool:  # fmt: skip
    """Tell whether one leg may be flown: (3,) float64 each; the rest as for `lowest_clear_height`."""
    ends = end.reshape(1, 3)
    if not clear_legs(surface, west, south, cell, start, ends, lowest, highest, ceiling, longest)[0]:
        return False
    return len(rivals[0]) == 0 or not come_too_near(start, ends, rivals[0], rivals[1], separation)[0]


@compiled
def lowest_clear_height(
    start: FloatArray, place: FloatArray, above: float, surface: FloatArray, west: float, south: float, cell: float,
    lowest: float, highest: float, ceiling: float, longest: float, rivals: FloatArray, separation: float,
) -> float:  # fmt: skip
    """ENU z of the lowest clear end over a place, higher than `above`; NaN when there is none.

    Parameters
    ----------
    start : (3,) float64 ENU metres; place : (2,) float64, east and north.
    surface : (columns, rows) float64, ENU z in metres, NaN where unknown or forbidden.
    west, south, cell : the grid, metres.
    lowest, highest, ceiling, longest : as in `clear_legs`.
    rivals : (2, M, 3) float64, where teammates are and where their legs end.
    separation : to be kept from them, metres.
    """
    end = np.array([place[0], place[1], 0.0])
    ground = ground_heights(surface, west, south, cell, end.reshape(1, 3))[0]
    if not math.isnan(ground):
        for number in range(_HEIGHTS):
            share = (number / (_HEIGHTS - 1)) ** 2
            end[2] = ground + lowest + share * (highest - lowest)
            if end[2] > above and is_clear(
                start, end, surface, west, south, cell, lowest, highest, ceiling, longest, rivals, separation
            ):
                return float(end[2])
    return math.nan


@compiled
def lowest_clear_end(
    start: FloatArray, goal: FloatArray, reach: float, surface: FloatArray, west: float, south: float, cell: float,
    lowest: float, highest: float, ceiling: float, longest: float, rivals: FloatArray, separation: float,
) -> tuple[float, float, float]:  # fmt: skip
    """The lowest clear end over a goal within reach; where there is none, over half the way to it, and so on.

    Arguments as for `lowest_clear_height`; goal : (2,) float64; reach : greatest length over ground, metres. Returns
    ENU metres; NaN three times when there is none.
    """
    away = math.hypot(goal[0] - start[0], goal[1] - start[1])
    scale = min(1.0, reach / away) if away > 0.0 else 1.0
    for shortening in _SHORTENINGS:
        place = start[:2] + scale * shortening * (goal - start[:2])
        height = lowest_clear_height(
            start, place, -math.inf, surface, west, south, cell, lowest, highest, ceiling, longest, rivals, separation
        )
        if not math.isnan(height):
            return place[0], place[1], height
    return math.nan, math.nan, math.nan
