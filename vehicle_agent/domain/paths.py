"""Ways over a known surface: clearance of straight legs, distance between legs, shortest ways through known cells."""

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
_FAR = 1e8
"""Cells from the grid beyond which no leg is looked at."""


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
def _leg_clearance(elevation: FloatArray, u0: float, v0: float, z0: float, u1: float, v1: float, z1: float) -> float:
    """Clearance of one leg, in cells and metres: from one line through cell centres to the next, square by square."""
    du, dv, dz = u1 - u0, v1 - v0, z1 - z0
    step_u, step_v = (1.0 if du > 0.0 else -1.0), (1.0 if dv > 0.0 else -1.0)
    line_u = math.floor(u0) + 1.0 if du > 0.0 else math.ceil(u0) - 1.0
    line_v = math.floor(v0) + 1.0 if dv > 0.0 else math.ceil(v0) - 1.0
    next_u = (line_u - u0) / du if du != 0.0 else math.inf
    next_v = (line_v - v0) / dv if dv != 0.0 else math.inf
    clearance = math.inf
    known = False
    before = 0.0
    while before < 1.0:
        after = min(next_u, next_v, 1.0)
        middle = 0.5 * (before + after)
        square = _square_around(elevation, u0 + middle * du, v0 + middle * dv)
        if square[0] >= 0:
            known = True
            lowest = _lowest_of_parabola(
                z0 + before * dz - _height_in(elevation, square, u0 + before * du, v0 + before * dv),
                z0 + middle * dz - _height_in(elevation, square, u0 + middle * du, v0 + middle * dv),
                z0 + after * dz - _height_in(elevation, square, u0 + after * du, v0 + after * dv),
            )
            clearance = min(clearance, lowest)
        elif known:
            return math.nan
        if next_u <= after:
            line_u += step_u
            next_u = (line_u - u0) / du
        if next_v <= after:
            line_v += step_v
            next_v = (line_v - v0) / dv
        before = after
    return clearance if known else math.nan


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
    (N,) float64 metres; NaN for a leg that crosses or ends on unknown or forbidden ground. A leg that begins there
    may leave it: only what follows counts.
    """
    clearances = np.empty(len(ends))
    u0, v0 = (start[0] - west) / cell - 0.5, (start[1] - south) / cell - 0.5
    for index in range(len(ends)):
        u1, v1 = (ends[index, 0] - west) / cell - 0.5, (ends[index, 1] - south) / cell - 0.5
        height = start[2] + ends[index, 2]
        if abs(u0) < _FAR and abs(v0) < _FAR and abs(u1) < _FAR and abs(v1) < _FAR and math.isfinite(height):
            clearances[index] = _leg_clearance(elevation, u0, v0, start[2], u1, v1, ends[index, 2])
        else:
            clearances[index] = math.nan
    return clearances


@compiled
def segment_distance_m(a0: FloatArray, a1: FloatArray, b0: FloatArray, b1: FloatArray) -> float:
    """Smallest distance between two segments in space, metres; each argument (3,) float64.

    The closest points lie in the interior of both lines or at an end of one: both are tried.
    """
    da, db, w = a1 - a0, b1 - b0, a0 - b0
    aa, bb, ab = np.dot(da, da), np.dot(db, db), np.dot(da, db)
    aw, bw = np.dot(da, w), np.dot(db, w)
    best = math.inf
    determinant = aa * bb - ab * ab
    if determinant > 1e-12 * max(aa * bb, 1e-300):
        s = (ab * bw - bb * aw) / determinant
        t = (aa * bw - ab * aw) / determinant
        if 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0:
            best = float(np.linalg.norm(w + s * da - t * db))
    for t in (0.0, 1.0):
        s = 0.0 if aa == 0.0 else min(max((t * ab - aw) / aa, 0.0), 1.0)
        best = min(best, float(np.linalg.norm(w + s * da - t * db)))
    for s in (0.0, 1.0):
        t = 0.0 if bb == 0.0 else min(max((s * ab + bw) / bb, 0.0), 1.0)
        best = min(best, float(np.linalg.norm(w + s * da - t * db)))
    return best


@compiled
def travel_distances(
    passable: BoolArray, start_column: int, start_row: int
) -> tuple[FloatArray, npt.NDArray[np.int64]]:
    """Shortest distances, in cells, from one cell to all through passable cells, 8-connected (Dijkstra).

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
        for dc in range(-1, 2):
            for dr in range(-1, 2):
                c, r = column + dc, row + dr
                if (dc == 0 and dr == 0) or c < 0 or r < 0 or c >= columns or r >= rows or not passable[c, r]:
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
