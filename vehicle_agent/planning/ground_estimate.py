"""What the ground may look like everywhere: known cells as they are, others as the nearest known one."""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import distance_transform_edt

from vehicle_agent.domain.elevation import ElevationMap
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.polygon import BoolArray


class GroundEstimate:
    """One vehicle's estimate at one resolution.

    Parameters
    ----------
    grid
        Cells of the map.
    area_cells
        (columns, rows) bool, the cells that count.
    block
        Cells of the map along the edge of one cell of the estimate.

    Attributes
    ----------
    grid
        Cells of the estimate; they may reach over the map's border by less than a cell.
    elevation_m
        (columns, rows) float64, ENU z, known everywhere.
    weights
        (columns, rows) float64, cells of the map in the area that each cell stands for.
    """

    def __init__(self, grid: Grid, area_cells: BoolArray, block: int) -> None:
        self._block = block
        columns, rows = math.ceil(grid.columns / block), math.ceil(grid.rows / block)
        self.grid = Grid(grid.west_m, grid.south_m, grid.cell_m * block, columns, rows)
        self.weights: FloatArray = self._sums(area_cells)
        self.elevation_m: FloatArray = np.zeros((columns, rows))

    def take(self, team_map: ElevationMap) -> None:
        """Estimate anew from what the team knows; nothing known is level ground at height zero."""
        observed = team_map.observed
        counts = self._sums(observed)
        known = counts > 0
        if not known.any():
            return
        sums = self._sums(np.where(observed, 0.1 * team_map.elevation_dm, 0.0))
        means = np.divide(sums, counts, out=np.zeros_like(sums), where=known)
        if not known.all():
            nearest = distance_transform_edt(~known, return_distances=False, return_indices=True)
            means = means[tuple(nearest)]
        self.elevation_m = np.ascontiguousarray(means)

    def ground_m(self, points_enu_m: FloatArray) -> FloatArray:
        """Ground under points, ENU z: (N, 2 or 3) -> (N,); points outside get the nearest border cell's."""
        grid = self.grid
        columns = np.floor((points_enu_m[:, 0] - grid.west_m) / grid.cell_m).astype(np.int64)
        rows = np.floor((points_enu_m[:, 1] - grid.south_m) / grid.cell_m).astype(np.int64)
        heights: FloatArray = self.elevation_m[columns.clip(0, grid.columns - 1), rows.clip(0, grid.rows - 1)]
        return heights

    def _sums(self, values: FloatArray | BoolArray) -> FloatArray:
        if self._block == 1:
            return values.astype(np.float64)
        block = self._block
        columns, rows = self.grid.shape
        padded = np.zeros((columns * block, rows * block))
        padded[: values.shape[0], : values.shape[1]] = values
        sums: FloatArray = padded.reshape(columns, block, rows, block).sum(axis=(1, 3))
        return sums
