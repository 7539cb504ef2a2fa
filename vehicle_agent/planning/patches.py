"""The unseen ground as a handful of patches, each about as wide as a sensor sweeps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid, IndexArray
from vehicle_agent.domain.polygon import BoolArray


@dataclass(frozen=True, slots=True)
class Patches:
    """Patches that still hold unseen cells.

    Attributes
    ----------
    numbers : (P,) int64, number of each patch in the division.
    centroids_en_m : (P, 2) float64, mean of its unseen cells, east and north in ENU metres.
    unseen : (P,) int64, unseen cells in it.
    """

    numbers: IndexArray
    centroids_en_m: FloatArray
    unseen: npt.NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.numbers)

    def only(self, chosen: BoolArray) -> Patches:
        """Those with `chosen` (P,) bool."""
        return Patches(self.numbers[chosen], self.centroids_en_m[chosen], self.unseen[chosen])


class PatchDivision:
    """Divides a grid into equal rectangles of at most a given width.

    Parameters
    ----------
    grid
        The cells.
    area_cells
        (columns, rows) bool, the cells that count.
    width_m
        Widest that a patch may be, metres; patches are wider where there would be more than `most` of them.
    """

    def __init__(self, grid: Grid, area_cells: BoolArray, width_m: float, most: int = 400) -> None:
        self.grid = grid
        columns, rows = np.nonzero(area_cells)
        self._first = (int(columns.min()), int(rows.min()))
        spans = (int(columns.max()) - self._first[0] + 1, int(rows.max()) - self._first[1] + 1)
        while True:
            cells_wide = max(1.0, width_m / grid.cell_m)
            self.shape = (max(1, int(np.ceil(spans[0] / cells_wide))), max(1, int(np.ceil(spans[1] / cells_wide))))
            if self.shape[0] * self.shape[1] <= most:
                break
            width_m *= 1.25
        self._spans = spans
        self.size_cells = (spans[0] / self.shape[0], spans[1] / self.shape[1])

    def number_of(self, column: int, row: int) -> int:
        """Number of the patch that holds a cell of the area's bounding box."""
        across = (column - self._first[0]) * self.shape[0] // self._spans[0]
        along = (row - self._first[1]) * self.shape[1] // self._spans[1]
        return across * self.shape[1] + along

    def cells_of(self, number: int) -> tuple[slice, slice]:
        """Columns and rows of a patch."""
        across, along = divmod(number, self.shape[1])
        return tuple(  # type: ignore[return-value]
            slice(
                first + -(-place * span // parts),
                first + -(-(place + 1) * span // parts),
            )
            for first, span, parts, place in zip(self._first, self._spans, self.shape, (across, along), strict=True)
        )

    def with_unseen(self, unseen: BoolArray) -> Patches:
        """Patches that hold cells of `unseen` (columns, rows), by number."""
        columns, rows = np.nonzero(unseen)
        across = (columns - self._first[0]) * self.shape[0] // self._spans[0]
        along = (rows - self._first[1]) * self.shape[1] // self._spans[1]
        of_cell = across * self.shape[1] + along
        parts = self.shape[0] * self.shape[1]
        counts = np.bincount(of_cell, minlength=parts)
        numbers = np.flatnonzero(counts)
        grid = self.grid
        sums = [np.bincount(of_cell, weights=axis, minlength=parts)[numbers] for axis in (columns, rows)]
        centroids = np.column_stack(
            (
                grid.west_m + (sums[0] / counts[numbers] + 0.5) * grid.cell_m,
                grid.south_m + (sums[1] / counts[numbers] + 0.5) * grid.cell_m,
            )
        )
        return Patches(numbers.astype(np.int64), centroids, counts[numbers].astype(np.int64))
