"""Ways over a known surface: shortest ways through known cells, and what ground that nobody knows could be."""

from __future__ import annotations

import heapq
import math

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.polygon import BoolArray


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
