"""The part of the unseen ground that a plan of lanes is for: where there is much, what lies nearest to the team."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray


class Window(NamedTuple):
    """A rectangle of blocks with all that a plan is for.

    Attributes
    ----------
    columns, rows : of its blocks.
    unseen : (C, R) float64, how much of each of its blocks the plan has to show.
    is_all : whether that is all that is unseen.
    """

    columns: slice
    rows: slice
    unseen: FloatArray
    is_all: bool

    @property
    def corner(self) -> FloatArray:
        """Its first block: (2,) float64."""
        return np.array((self.columns.start, self.rows.start), dtype=np.float64)


def window_around(unseen: FloatArray, vehicles: FloatArray, most: float) -> Window:
    """Choose what a plan is for.

    Parameters
    ----------
    unseen : (C, R) float64, how much of each block is unseen.
    vehicles : (N, 2) float64, where vehicles are, in blocks, block centres at whole numbers.
    most : so much of the ground that lies nearest to any vehicle, and the rest of what is as near as the last of it.

    Returns
    -------
    All blocks where no more is unseen, else those from the first to the last that matter, and the vehicles' own.
    """
    columns, rows = unseen.shape
    if unseen.sum() <= most:
        return Window(slice(0, columns), slice(0, rows), unseen, True)
    near = np.zeros_like(unseen)
    _take_nearest(unseen, np.ascontiguousarray(vehicles), most, near)
    columns_near, rows_near = np.nonzero(near)
    across, along = _span(columns_near, vehicles[:, 0], columns), _span(rows_near, vehicles[:, 1], rows)
    return Window(across, along, np.ascontiguousarray(near[across, along]), False)


def _span(blocks: IndexArray, places: FloatArray, size: int) -> slice:
    """From the first to the last block or place along one axis of so many blocks."""
    both = np.concatenate((blocks, np.rint(places).astype(np.int64)))
    first, last = np.clip((both.min(), both.max()), 0, size - 1)
    return slice(int(first), int(last) + 1)


@compiled
def _take_nearest(unseen: FloatArray, vehicles: FloatArray, most: float, near: FloatArray) -> None:
    """Copy the blocks nearest to any vehicle, by rings one block wide, until so much is copied."""
    columns, rows = unseen.shape
    farthest = columns + rows
    rings = np.full(unseen.shape, farthest, dtype=np.int64)
    by_ring = np.zeros(farthest + 1)
    for column in range(columns):
        for row in range(rows):
            if unseen[column, row] <= 0.0:
                continue
            squared = math.inf
            for index in range(len(vehicles)):
                squared = min(squared, (column - vehicles[index, 0]) ** 2 + (row - vehicles[index, 1]) ** 2)
            rings[column, row] = min(int(math.sqrt(squared)), farthest)
            by_ring[rings[column, row]] += unseen[column, row]
    last, within = 0, by_ring[0]
    while within < most and last < farthest:
        last += 1
        within += by_ring[last]
    for column in range(columns):
        for row in range(rows):
            if rings[column, row] <= last:
                near[column, row] = unseen[column, row]
