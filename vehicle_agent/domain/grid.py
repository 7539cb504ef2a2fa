"""A regular grid of square cells over the mission's area."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.frames import FloatArray

IndexArray = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Grid:
    """Cells indexed `[column, row]`: column along east, row along north; flat index `column * rows + row`.

    Attributes
    ----------
    west_m, south_m
        East and north of the grid's south-western corner, ENU metres.
    cell_m
        Edge of a cell, metres.
    columns, rows
        Number of cells along east and along north, so that arrays have shape `(columns, rows)`.
    """

    west_m: float
    south_m: float
    cell_m: float
    columns: int
    rows: int

    def __post_init__(self) -> None:
        if not (self.cell_m > 0 and math.isfinite(self.cell_m)):
            raise ValueError("cell_m must be a positive number of metres")
        if self.columns < 1 or self.rows < 1:
            raise ValueError("a grid needs at least one cell")

    @classmethod
    def over(cls, west_m: float, south_m: float, east_m: float, north_m: float, cell_m: float) -> Grid:
        """Return the smallest grid that covers the rectangle with whole cells from its south-western corner."""
        columns = max(1, math.ceil((east_m - west_m) / cell_m - 1e-9))
        rows = max(1, math.ceil((north_m - south_m) / cell_m - 1e-9))
        return cls(west_m, south_m, cell_m, columns, rows)

    @property
    def shape(self) -> tuple[int, int]:
        return (self.columns, self.rows)

    @property
    def cells(self) -> int:
        return self.columns * self.rows

    @property
    def east_m(self) -> float:
        return self.west_m + self.columns * self.cell_m

    @property
    def north_m(self) -> float:
        return self.south_m + self.rows * self.cell_m

    def cell_of(self, east_m: float, north_m: float) -> tuple[int, int]:
        """Column and row of the cell that holds the point; points outside give the nearest border cell."""
        column = math.floor((east_m - self.west_m) / self.cell_m)
        row = math.floor((north_m - self.south_m) / self.cell_m)
        return (min(max(column, 0), self.columns - 1), min(max(row, 0), self.rows - 1))

    def contains(self, east_m: float, north_m: float) -> bool:
        return self.west_m <= east_m <= self.east_m and self.south_m <= north_m <= self.north_m

    def centre_of(self, column: int, row: int) -> tuple[float, float]:
        """East and north of a cell's centre, ENU metres."""
        return (self.west_m + (column + 0.5) * self.cell_m, self.south_m + (row + 0.5) * self.cell_m)

    def centres_of(self, flat_indices: IndexArray) -> FloatArray:
        """Centres of cells by flat index: (N,) -> (N, 2) float64, east and north in ENU metres."""
        columns, rows = np.divmod(flat_indices, self.rows)
        return np.column_stack(
            (self.west_m + (columns + 0.5) * self.cell_m, self.south_m + (rows + 0.5) * self.cell_m)
        ).astype(np.float64)

    def centres_east_m(self) -> FloatArray:
        """(columns,) float64, east of every column's centres, ENU metres."""
        centres: FloatArray = self.west_m + (np.arange(self.columns, dtype=np.float64) + 0.5) * self.cell_m
        return centres

    def centres_north_m(self) -> FloatArray:
        """(rows,) float64, north of every row's centres, ENU metres."""
        centres: FloatArray = self.south_m + (np.arange(self.rows, dtype=np.float64) + 0.5) * self.cell_m
        return centres
