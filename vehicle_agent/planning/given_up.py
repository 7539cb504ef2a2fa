"""Frontiers that a vehicle could not mend: it lets them go instead of circling over them for ever."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.polygon import BoolArray


@dataclass(slots=True)
class _Effort:
    """What has been tried for one frontier."""

    nearest_m: float = math.inf
    last_m: float = math.inf
    fruitless: int = 0
    waited: int = 0


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
        self._efforts: dict[int, _Effort] = {}

    def without(self, frontier: BoolArray) -> BoolArray:
        """The frontier cells still worth going for: (columns, rows) bool."""
        kept: BoolArray = frontier & ~self._excluded
        return kept

    def chose(self, cell_index: int, distance_m: float) -> bool:
        """Note the frontier gone for now and how far it is; True when it has just been given up.

        Every frontier has its own count, and only a new nearest distance begins it anew, so that two which are chosen
        in turn come to an end as well.
        """
        effort = self._efforts.setdefault(cell_index, _Effort())
        step_m = 0.25 * self._grid.cell_m
        if distance_m < effort.nearest_m - step_m:
            effort.fruitless = 0
        elif distance_m >= effort.last_m - step_m:
            effort.fruitless += 1
        effort.nearest_m, effort.last_m = min(distance_m, effort.nearest_m), distance_m
        effort.waited = 0
        return effort.fruitless >= self._patience and self._exclude(cell_index)

    def waited(self, cell_index: int) -> bool:
        """Note that the way to the chosen frontier is taken; True when it has just been given up."""
        effort = self._efforts.setdefault(cell_index, _Effort())
        effort.waited += 1
        return effort.waited >= self._waiting_patience and self._exclude(cell_index)

    def _exclude(self, cell_index: int) -> bool:
        column, row = divmod(cell_index, self._grid.rows)
        self._excluded[max(0, column - 1) : column + 2, max(0, row - 1) : row + 2] = True
        del self._efforts[cell_index]
        return True
