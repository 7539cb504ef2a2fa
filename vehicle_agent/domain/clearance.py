"""How high straight legs run above a known surface, as compiled kernels."""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.polygon import BoolArray

_ON_LINE = 1e-6
"""A point this near to a line through cell centres, in cells, lies on it."""
_RIM = 1.5
"""A leg that begins on unknown ground goes at most so many cells over it, or at most so many beyond it."""
_FAR = 1e8
"""Cells from the grid beyond which no leg is looked at."""
_SLACK_M = 0.05
"""A leg may break a limit of height by so much: what it is planned on is no better."""


@compiled
def _square_around(elevation: FloatArray, u: float, v: float) -> tuple[int, int, int, int]:
    """Columns left and right of a point and rows below and above it, equal where it lies on one; left is -1 for none.

    There is none beyond the outermost cell centres and where one of the four cells is unknown.
    """
    columns, rows = elevation.shape
    left, right = math.floor(u + _ON_LINE), math.ceil(u - _ON_LINE)
    low, high = math.floor(v + _ON_LINE), math.ceil(v - _ON_LINE)
    if left < 0 or low < 0 or right >= columns or high >= rows:
        return -1, -1, -1, -1
    if math.isnan(elevation[left, low] + elevation[right, low] + elevation[left, high] + elevation[right, high]):
        return -1, -1, -1, -1
    return left, right, low, high


@compiled
def _height_in(elevation: FloatArray, square: tuple[int, int, int, int], u: float, v: float) -> float:
    """Bilinear height of a point in a square between cell centres."""
    left, right, low, high = square
    s, t = (u - left if right > left else 0.0), (v - low if high > low else 0.0)
    bottom = (1.0 - s) * elevation[left, low] + s * elevation[right, low]
    top = (1.0 - s) * elevation[left, high] + s * elevation[right, high]
    return float((1.0 - t) * bottom + t * top)


@compiled
def _lowest_of_parabola(first: float, middle: float, last: float) -> float:
    """Minimum on [0, 1] of the parabola with those values at 0, 1/2 and 1."""
    lowest = min(first, middle, last)
    bend = 2.0 * first - 4.0 * middle + 2.0 * last
    if bend > 0.0:
        where = (3.0 * first - 4.0 * middle + last) / (2.0 * bend)
        if 0.0 < where < 1.0:
            lowest = min(lowest, first - bend * where * where)
    return lowest


@compiled
def _lowest_in_square(
    elevation: FloatArray, square: tuple[int, int, int, int], first: FloatArray, last: FloatArray
) -> float:
    """Smallest height above the bilinear surface between two points (u, v, z) of one square."""
    middle = 0.5 * (first + last)
    return _lowest_of_parabola(
        first[2] - _height_in(elevation, square, first[0], first[1]),
        middle[2] - _height_in(elevation, square, middle[0], middle[1]),
        last[2] - _height_in(elevation, square, last[0], last[1]),
    )


@compiled
def _next_line(start: float, change: float, line: float) -> float:
    """Part of the way at which a leg meets a line, infinite when it never does."""
    return (line - start) / change if change != 0.0 else math.inf


@compiled
def _leg_clearance(elevation: FloatArray, start: FloatArray, end: FloatArray) -> float:
    """Clearance of one leg given as (u, v, z) in cells and metres, square after square between cell centres."""
    change = end - start
    length = math.hypot(change[0], change[1])
    step_u, step_v = (1.0 if change[0] > 0.0 else -1.0), (1.0 if change[1] > 0.0 else -1.0)
    line_u = math.floor(start[0]) + 1.0 if change[0] > 0.0 else math.ceil(start[0]) - 1.0
    line_v = math.floor(start[1]) + 1.0 if change[1] > 0.0 else math.ceil(start[1]) - 1.0
    next_u, next_v = _next_line(start[0], change[0], line_u), _next_line(start[1], change[1], line_v)
    clearance = math.inf
    known = _square_around(elevation, start[0], start[1])[0] >= 0
    before = 0.0
    while before < 1.0:
        after = min(next_u, next_v, 1.0)
        middle = start + 0.5 * (before + after) * change
        square = _square_around(elevation, middle[0], middle[1])
        if square[0] >= 0:
            if not known and min(before, 1.0 - before) * length > _RIM:
                return math.nan
            known = True
            clearance = min(
                clearance, _lowest_in_square(elevation, square, start + before * change, start + after * change)
            )
        elif known:
            return math.nan
        if next_u <= after:
            line_u += step_u
            next_u = _next_line(start[0], change[0], line_u)
        if next_v <= after:
            line_v += step_v
            next_v = _next_line(start[1], change[1], line_v)
        before = after
    square = _square_around(elevation, end[0], end[1])
    if square[0] < 0:
        return math.nan
    return float(min(clearance, end[2] - _height_in(elevation, square, end[0], end[1])))


@compiled
def leg_clearances(
    elevation: FloatArray, west: float, south: float, cell: float, start: FloatArray, ends: FloatArray
) -> FloatArray:
    """Smallest height above the surface along each straight leg from `start` to each of `ends`.

    The surface is bilinear between cell centres; along a leg it is a parabola in each square between four of them.

    Parameters
    ----------
    elevation : (columns, rows) float64, ENU z in metres, NaN where unknown or forbidden.
    west, south, cell : the grid, metres.
    start : (3,) float64; ends : (N, 3) float64, ENU metres.

    Returns
    -------
    (N,) float64 metres; NaN for a leg that enters unknown or forbidden ground. A leg that begins there may leave it,
    from the rim to anywhere, from further in to the rim: only what follows counts.
    """
    clearances = np.empty(len(ends))
    first, last = np.empty(3), np.empty(3)
    first[0], first[1], first[2] = (start[0] - west) / cell - 0.5, (start[1] - south) / cell - 0.5, start[2]
    for index in range(len(ends)):
        last[0], last[1] = (ends[index, 0] - west) / cell - 0.5, (ends[index, 1] - south) / cell - 0.5
        last[2] = ends[index, 2]
        if np.abs(first).max() < _FAR and np.abs(last).max() < _FAR:
            clearances[index] = _leg_clearance(elevation, first, last)
        else:
            clearances[index] = math.nan
    return clearances


@compiled
def ground_heights(elevation: FloatArray, west: float, south: float, cell: float, points: FloatArray) -> FloatArray:
    """Surface height under each point, bilinear between cell centres: (N, 3) ENU metres -> (N,), NaN where unknown."""
    heights = np.full(len(points), math.nan)
    for index in range(len(points)):
        u, v = (points[index, 0] - west) / cell - 0.5, (points[index, 1] - south) / cell - 0.5
        if abs(u) < _FAR and abs(v) < _FAR:
            square = _square_around(elevation, u, v)
            if square[0] >= 0:
                heights[index] = _height_in(elevation, square, u, v)
    return heights


@compiled
def clear_legs(
    elevation: FloatArray,
    west: float,
    south: float,
    cell: float,
    start: FloatArray,
    ends: FloatArray,
    lowest: float,
    highest: float,
    ceiling: float,
    longest: float,
) -> BoolArray:
    """Tell which legs stay in their height band: arguments as for `leg_clearances`, heights in metres -> (N,) bool.

    Parameters
    ----------
    lowest : least height above the surface along a leg; a vehicle that is lower already may stay as low on its way.
    highest, ceiling : greatest height above the surface and greatest ENU z, at a leg's end.
    longest : greatest length of a leg in space.
    """
    here = leg_clearances(elevation, west, south, cell, start, start.reshape(1, 3))[0]
    least = lowest if math.isnan(here) else min(lowest, here)
    clearances = leg_clearances(elevation, west, south, cell, start, ends)
    grounds = ground_heights(elevation, west, south, cell, ends)
    clear = np.zeros(len(ends), dtype=np.bool_)
    for index in range(len(ends)):
        end = ends[index]
        above = end[2] - grounds[index]
        squared = (end[0] - start[0]) ** 2 + (end[1] - start[1]) ** 2 + (end[2] - start[2]) ** 2
        clear[index] = (
            clearances[index] >= least - _SLACK_M
            and lowest - _SLACK_M <= above <= highest + _SLACK_M
            and end[2] <= ceiling + _SLACK_M
            and math.sqrt(squared) <= longest + 1e-6
        )
    return clear
