"""What the coverage bench counts in every move, as compiled kernels: a team of twenty moves ten thousand times."""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray


@compiled
def count_watchers(watchers: IndexArray, view: IndexArray, change: int) -> None:
    """Add `change` to the watchers of every cell of a view: (cells,) and (N,) int64."""
    for cell in view:
        watchers[cell] += change


@compiled
def shares(watchers: IndexArray, view: IndexArray) -> FloatArray:
    """One over the number of watchers of each cell of a view: (N,) float64, J_C when summed (Renzaglia 2020, eq. 1)."""
    parts = np.empty(len(view))
    for index in range(len(view)):
        parts[index] = 1.0 / watchers[view[index]]
    return parts


@compiled
def unmarked(marks: BoolArray, cells: IndexArray) -> IndexArray:
    """Those of the cells, in their order, that bear no mark: (cells,) bool and (N,) -> (M,) int64."""
    found = np.empty(len(cells), dtype=np.int64)
    count = 0
    for cell in cells:
        if not marks[cell]:
            found[count] = cell
            count += 1
    return found[:count].copy()


@compiled
def nearest_m(places: FloatArray, index: int) -> float:
    """Distance of one of the places, (N, 3) ENU metres, from the nearest other; infinite where there is none."""
    nearest = math.inf
    for other in range(len(places)):
        if other != index:
            squared = 0.0
            for axis in range(3):
                squared += (places[other, axis] - places[index, axis]) ** 2
            nearest = min(nearest, squared)
    return math.sqrt(nearest)
