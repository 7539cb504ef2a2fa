"""Ways over a known surface: clearance of straight legs, distance between legs, shortest ways through known cells."""

from __future__ import annotations

import heapq
import math

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.polygon import BoolArray


@compiled
def _highest_around(elevation: FloatArray, u: float, v: float) -> float:
    """Highest of the four cells around a point (NaN when one is unknown): no lower than the surface there."""
    columns, rows = elevation.shape
    left = min(max(math.floor(u), 0), columns - 1)
    low = min(max(math.floor(v), 0), rows - 1)
    right, high = min(max(math.ceil(u), 0), columns - 1), min(max(math.ceil(v), 0), rows - 1)
    highest = float(elevation[left, low])
    for value in (elevation[right, low], elevation[left, high], elevation[right, high]):
        if math.isnan(value) or math.isnan(highest):
            return math.nan
        highest = max(highest, value)
    return highest


@compiled
def leg_clearances(
    elevation: FloatArray, west: float, south: float, cell: float, start: FloatArray, ends: FloatArray
) -> FloatArray:
    """Smallest height above the surface along each straight leg from `start` to each of `ends`.

    Parameters
    ----------
    elevation : (columns, rows) float64, ENU z in metres, NaN where unknown or forbidden.
    west, south, cell : the grid, metres.
    start : (3,) float64; ends : (N, 3) float64, ENU metres.

    Returns
    -------
    (N,) float64 metres; NaN for a leg that crosses an unknown or forbidden cell.
    """
    clearances = np.empty(len(ends))
    u0, v0 = (start[0] - west) / cell - 0.5, (start[1] - south) / cell - 0.5
    for index in range(len(ends)):
        u1, v1 = (ends[index, 0] - west) / cell - 0.5, (ends[index, 1] - south) / cell - 0.5
        samples = math.ceil(2.0 * math.hypot(u1 - u0, v1 - v0)) + 1
        clearance = math.inf
        for sample in range(samples + 1):
            part = sample / samples
            ground = _highest_around(elevation, u0 + part * (u1 - u0), v0 + part * (v1 - v0))
            if math.isnan(ground):
                clearance = math.nan
                break
            clearance = min(clearance, start[2] + part * (ends[index, 2] - start[2]) - ground)
        clearances[index] = clearance
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
