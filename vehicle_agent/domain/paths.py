"""Ways over a known surface: clearance of straight legs, shortest ways through known cells."""

from __future__ import annotations

import heapq
import math

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray, Point
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


@compiled
def travel_distances(
    passable: BoolArray, start_column: int, start_row: int, goal_column: int, goal_row: int
) -> tuple[FloatArray, npt.NDArray[np.int64]]:
    """Shortest distances, in cells, from one cell to all through passable cells (Dijkstra).

    Cells are 8-connected, but no diagonal cuts the corner of an impassable cell: no leg could follow it. Ways to cells
    that are further away than the goal need not be the shortest, or be found at all; a goal of -1, -1 is none.

    Returns
    -------
    distances : (columns, rows) float64, infinite where there is no way.
    parents : (columns, rows) int64, flat index of the previous cell on the way, -1 at the start and off the way.
    """
    columns, rows = passable.shape
    distances = np.full((columns, rows), np.inf)
    parents = np.full((columns, rows), -1, dtype=np.int64)
    distances[start_column, start_row] = 0.0
    heap = [(0.0, start_column * rows + start_row)]
    diagonal = math.sqrt(2.0)
    while heap:
        distance, flat = heapq.heappop(heap)
        column, row = flat // rows, flat % rows
        if distance > distances[column, row]:
            continue
        if column == goal_column and row == goal_row:
            break
        for dc in range(-1, 2):
            for dr in range(-1, 2):
                c, r = column + dc, row + dr
                if (dc == 0 and dr == 0) or c < 0 or r < 0 or c >= columns or r >= rows or not passable[c, r]:
                    continue
                if not (passable[c, row] and passable[column, r]):
                    continue
                further = distance + (diagonal if dc != 0 and dr != 0 else 1.0)
                if further < distances[c, r] - 1e-12:
                    distances[c, r] = further
                    parents[c, r] = flat
                    heapq.heappush(heap, (further, c * rows + r))
    return distances, parents


def trace_way(parents: npt.NDArray[np.int64], column: int, row: int) -> list[tuple[int, int]]:
    """Cells from the start to (column, row), both included, by the parents of `travel_distances`."""
    rows = parents.shape[1]
    way = [(column, row)]
    while (flat := int(parents[way[-1]])) >= 0:
        way.append(divmod(flat, rows))
    way.reverse()
    return way


@compiled
def nearest_known_cell(elevation: FloatArray, column: int, row: int) -> tuple[int, int]:
    """The known cell nearest to a cell, itself included, in ever wider squares around it; (-1, -1) where all is NaN."""
    columns, rows = elevation.shape
    best, best_column, best_row = math.inf, -1, -1
    widest = max(column, columns - 1 - column, row, rows - 1 - row)
    for ring in range(widest + 1):
        if ring * ring > best:
            break
        for c in range(max(0, column - ring), min(columns, column + ring + 1)):
            step = 1 if abs(c - column) == ring else max(1, 2 * ring)
            for r in range(row - ring, row + ring + 1, step):
                if r < 0 or r >= rows or math.isnan(elevation[c, r]):
                    continue
                away = (c - column) ** 2 + (r - row) ** 2
                if away < best or (away == best and (c, r) < (best_column, best_row)):
                    best, best_column, best_row = away, c, r
    return best_column, best_row


@compiled
def assumed_surface(elevation: FloatArray, allowed: BoolArray, cell_m: float, rings: int, slope: float) -> FloatArray:
    """Surface to stay clear of: what is known, and around it what the steepest ground could be.

    Unknown cells within `rings` cells of known ones are taken to rise by `slope` from their highest neighbour, so that
    a shadowed pocket can be crossed at a safe height; cells further away and cells not `allowed` are NaN.

    Parameters
    ----------
    elevation : (columns, rows) float64, ENU z in metres, NaN where unknown.
    allowed : (columns, rows) bool, where vehicles may be.
    slope : metres of rise per metre.

    Returns
    -------
    (columns, rows) float64.
    """
    columns, rows = elevation.shape
    surface = elevation.copy()
    for _ in range(rings):
        grown = surface.copy()
        for column in range(columns):
            for row in range(rows):
                if not math.isnan(surface[column, row]):
                    continue
                highest = -math.inf
                for c in range(max(0, column - 1), min(columns, column + 2)):
                    for r in range(max(0, row - 1), min(rows, row + 2)):
                        if not math.isnan(surface[c, r]):
                            highest = max(highest, surface[c, r])
                if highest > -math.inf:
                    grown[column, row] = highest + slope * cell_m
        surface = grown
    for column in range(columns):
        for row in range(rows):
            if not allowed[column, row]:
                surface[column, row] = math.nan
    return surface


def as_array(point: Point) -> FloatArray:
    """(3,) float64 of a point."""
    return np.array(point, dtype=np.float64)
