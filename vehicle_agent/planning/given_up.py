"""Frontiers that a vehicle could not mend: it lets them go instead of circling over them for ever."""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.polygon import BoolArray


class GivenUp:
    """Counts decisions for the same frontier that brought the vehicle no nearer, and excludes it in the end."""

    def __init__(self, grid: Grid, patience: int = 4) -> None:
        self._grid = grid
        self._patience = patience
        self._excluded: BoolArray = np.zeros(grid.shape, dtype=np.bool_)
        self._chosen: int | None = None
        self._nearest_m = np.inf
        self._fruitless = 0

    def without(self, frontier: BoolArray) -> BoolArray:
        """The frontier cells still worth going for: (columns, rows) bool."""
        kept: BoolArray = frontier & ~self._excluded
        return kept

    def chose(self, cell_index: int, distance_m: float) -> bool:
        """Note the frontier chosen now and how far it is; True when it has just been given up."""
        if cell_index != self._chosen:
            self._chosen, self._nearest_m, self._fruitless = cell_index, np.inf, 0
        if distance_m < self._nearest_m - 0.25 * self._grid.cell_m:
            self._nearest_m, self._fruitless = distance_m, 0
            return False
        self._fruitless += 1
        if self._fruitless < self._patience:
            return False
        column, row = divmod(cell_index, self._grid.rows)
        self._excluded[max(0, column - 1) : column + 2, max(0, row - 1) : row + 2] = True
        self._chosen = None
        return True
