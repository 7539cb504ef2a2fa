"""Frontiers that a vehicle could not mend: it lets them go instead of circling over them for ever."""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.polygon import BoolArray


class GivenUp:
    """Counts decisions for the same frontier that brought the vehicle no nearer, and excludes it in the end.

    Parameters
    ----------
    patience
        Decisions in a row for a frontier that brought the vehicle no nearer to it.
    waiting_patience
        Decisions in a row that found the way to it taken, about a second each.
    """

    def __init__(self, grid: Grid, patience: int = 4, waiting_patience: int = 30) -> None:
        self._grid = grid
        self._patience = patience
        self._waiting_patience = waiting_patience
        self._excluded: BoolArray = np.zeros(grid.shape, dtype=np.bool_)
        self._last_m: dict[int, float] = {}
        self._fruitless: dict[int, int] = {}
        self._waited: dict[int, int] = {}

    def without(self, frontier: BoolArray) -> BoolArray:
        """The frontier cells still worth going for: (columns, rows) bool."""
        kept: BoolArray = frontier & ~self._excluded
        return kept

    def chose(self, cell_index: int, distance_m: float) -> bool:
        """Note the frontier gone for now and how far it is; True when it has just been given up.

        Every frontier has its own count, so that two which are chosen in turn come to an end as well.
        """
        nearer = distance_m < self._last_m.get(cell_index, np.inf) - 0.25 * self._grid.cell_m
        self._last_m[cell_index] = distance_m
        self._waited.pop(cell_index, None)
        self._fruitless[cell_index] = 0 if nearer else self._fruitless.get(cell_index, 0) + 1
        return self._fruitless[cell_index] >= self._patience and self._exclude(cell_index)

    def waited(self, cell_index: int) -> bool:
        """Note that the way to the chosen frontier is taken; True when it has just been given up."""
        self._waited[cell_index] = self._waited.get(cell_index, 0) + 1
        return self._waited[cell_index] >= self._waiting_patience and self._exclude(cell_index)

    def _exclude(self, cell_index: int) -> bool:
        column, row = divmod(cell_index, self._grid.rows)
        self._excluded[max(0, column - 1) : column + 2, max(0, row - 1) : row + 2] = True
        self._last_m.pop(cell_index, None)
        self._fruitless.pop(cell_index, None)
        self._waited.pop(cell_index, None)
        return True
