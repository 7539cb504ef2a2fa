"""Sums over the patches that a grid is divided into, as compiled kernels."""

from __future__ import annotations

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.elevation import UNOBSERVED_STAMP_MS, StampArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray


@compiled
def sum_unseen(
    sums: IndexArray, first_stamp_ms: StampArray, area_cells: BoolArray, across: IndexArray, along: IndexArray
) -> None:
    """Sum up the unobserved cells of the area by patch.

    Parameters
    ----------
    sums : (P, 3) int64, number of cells, sum of their columns and sum of their rows by patch; written to.
    first_stamp_ms : (columns, rows) int64, as in an `ElevationMap`.
    area_cells : (columns, rows) bool.
    across, along : (columns,) and (rows,) int64; the sum of both is the number of a cell's patch.
    """
    sums[:] = 0
    columns, rows = area_cells.shape
    for column in range(columns):
        for row in range(rows):
            if area_cells[column, row] and first_stamp_ms[column, row] == UNOBSERVED_STAMP_MS:
                patch = across[column] + along[row]
                sums[patch, 0] += 1
                sums[patch, 1] += column
                sums[patch, 2] += row


@compiled
def take_off(
    sums: IndexArray, cell_indices: IndexArray, area_cells: BoolArray, across: IndexArray, along: IndexArray
) -> None:
    """Take cells that have become observed off the sums of `sum_unseen`.

    Parameters
    ----------
    cell_indices : (N,) int64, flat indices; those outside the area do not count.
    """
    rows = area_cells.shape[1]
    for index in cell_indices:
        column = index // rows
        row = index - column * rows
        if area_cells[column, row]:
            patch = across[column] + along[row]
            sums[patch, 0] -= 1
            sums[patch, 1] -= column
            sums[patch, 2] -= row
