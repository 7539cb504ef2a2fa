"""Sums over the patches that a grid is divided into, and which of them need a visit, as compiled kernels."""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray


@compiled
def add_cells(
    sums: IndexArray, cell_indices: IndexArray, area_cells: BoolArray, first: tuple[int, int], spans: tuple[int, int],
    parts: tuple[int, int], sign: int,
) -> None:  # fmt: skip
    """Add cells of the area to their patches' sums, or take them off.

    Parameters
    ----------
    sums : (P, 3) int64, number of cells, sum of their columns and sum of their rows by patch; written to.
    cell_indices : (N,) int64, flat indices; those outside the area do not count.
    area_cells : (columns, rows) bool.
    first, spans, parts : along columns and rows: the patches' first cell, their extent together, and their number.
    sign : 1 or -1.
    """
    rows = area_cells.shape[1]
    for index in cell_indices:
        column, row = index // rows, index % rows
        if not area_cells[column, row]:
            continue
        across, along = (column - first[0]) * parts[0] // spans[0], (row - first[1]) * parts[1] // spans[1]
        patch = across * parts[1] + along
        sums[patch, 0] += sign
        sums[patch, 1] += sign * column
        sums[patch, 2] += sign * row


@compiled
def stops_of(centroids: FloatArray, unseen: IndexArray, remnant: float, beside: float) -> BoolArray:
    """Which patches need a stop of their own, the fullest first.

    Parameters
    ----------
    centroids : (P, 2) float64, metres.
    unseen : (P,) int64, unseen cells of each.
    remnant : a patch with fewer is no stop when another stop is near.
    beside : near is nearer than this, metres.

    Returns
    -------
    (P,) bool.
    """
    stops = unseen >= remnant
    remnants = np.flatnonzero(~stops)
    for place in np.argsort(-unseen[remnants], kind="mergesort"):
        index = remnants[place]
        alone = True
        for other in range(len(unseen)):
            if stops[other] and math.hypot(
                centroids[other, 0] - centroids[index, 0], centroids[other, 1] - centroids[index, 1]
            ) < beside:  # fmt: skip
                alone = False
                break
        stops[index] = alone
    return stops
