"""Frontiers: observed cells beside unobserved ones, gathered into a few candidates with what each promises."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.elevation import ElevationMap
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid, IndexArray
from vehicle_agent.domain.polygon import BoolArray


def frontier_cells(observed: BoolArray, area_cells: BoolArray) -> BoolArray:
    """Observed cells of the area with an unobserved cell of the area among their eight neighbours."""
    unknown = area_cells & ~observed
    padded = np.pad(unknown, 1)
    columns, rows = observed.shape
    near = np.zeros_like(unknown)
    for dc in range(3):
        for dr in range(3):
            near |= padded[dc : dc + columns, dr : dr + rows]
    frontier: BoolArray = near & observed & area_cells
    return frontier


@dataclass(frozen=True, slots=True)
class FrontierCandidates:
    """Representative frontier cells.

    Attributes
    ----------
    cell_indices : (K,) int64, flat indices.
    points_en_m : (K, 2) float64, east and north of each in ENU metres.
    sizes : (K,) int64, frontier cells that each stands for.
    """

    cell_indices: IndexArray
    points_en_m: FloatArray
    sizes: npt.NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.cell_indices)


def candidate_frontiers(grid: Grid, frontier: BoolArray, block_cells: int) -> FrontierCandidates:
    """One candidate per square block of the grid that holds frontier cells: the cell nearest to their centroid.

    Parameters
    ----------
    frontier : (columns, rows) bool.
    block_cells : edge of a block in cells; 1 keeps every frontier cell.
    """
    indices = np.flatnonzero(frontier.ravel())
    points = grid.centres_of(indices)
    if len(indices) == 0 or block_cells <= 1:
        return FrontierCandidates(indices, points, np.ones(len(indices), dtype=np.int64))
    columns, rows = np.divmod(indices, grid.rows)
    blocks = (columns // block_cells) * (grid.rows // block_cells + 1) + rows // block_cells
    _, inverse, sizes = np.unique(blocks, return_inverse=True, return_counts=True)
    centroids = np.column_stack([np.bincount(inverse, points[:, axis]) / sizes for axis in (0, 1)])
    off_centre = np.hypot(*(points - centroids[inverse]).T)
    order = np.lexsort((off_centre, inverse))
    first = order[np.concatenate(([0], np.cumsum(sizes)[:-1]))]
    return FrontierCandidates(indices[first], points[first], sizes.astype(np.int64))


def unknown_around(unknown: BoolArray, grid: Grid, points_en_m: FloatArray, half_width_m: float) -> FloatArray:
    """Unknown cells in the square of the given half width around each point, by a summed-area table: (K,) float64."""
    table = np.zeros((grid.columns + 1, grid.rows + 1), dtype=np.int64)
    np.cumsum(np.cumsum(unknown, axis=0), axis=1, out=table[1:, 1:])
    u = (points_en_m[:, 0] - grid.west_m) / grid.cell_m
    v = (points_en_m[:, 1] - grid.south_m) / grid.cell_m
    half = half_width_m / grid.cell_m
    left = np.clip(np.round(u - half), 0, grid.columns).astype(np.int64)
    right = np.clip(np.round(u + half), 0, grid.columns).astype(np.int64)
    low = np.clip(np.round(v - half), 0, grid.rows).astype(np.int64)
    high = np.clip(np.round(v + half), 0, grid.rows).astype(np.int64)
    counts = table[right, high] - table[left, high] - table[right, low] + table[left, low]
    return counts.astype(np.float64)


def map_frontiers(team_map: ElevationMap, area_cells: BoolArray) -> BoolArray:
    """Frontier cells of a map: (columns, rows) bool."""
    return frontier_cells(team_map.observed, area_cells)
