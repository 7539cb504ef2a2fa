"""Where to stop so that all unseen ground is seen: a greedy set cover by discs, as a compiled kernel."""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.elevation import UNOBSERVED_STAMP_MS, StampArray
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray


@compiled
def choose_stops(
    first_stamp_ms: StampArray, area_cells: BoolArray, across: IndexArray, along: IndexArray, sums: IndexArray,
    wanted: BoolArray, marks: IndexArray, mark: int, radius: float, remnant: float, beside: float,
) -> tuple[IndexArray, FloatArray, IndexArray]:  # fmt: skip
    """Choose stops by patch: the patch with most cells that no stop has seen yet comes next, at the middle of these.

    Work follows the number of stops and the cells in a disc, not the size of the map.

    Parameters
    ----------
    first_stamp_ms, area_cells, across, along : as for `sum_unseen`.
    sums : (P, 3) int64, as `sum_unseen` leaves them.
    wanted : (P,) bool, patches that may be stops; the cells of others are seen in passing or not at all.
    marks : (columns, rows) int64, scratch that no other value than `mark` tells anything in; written to.
    mark : a number not used with these marks before.
    radius : from a stop, cells within this distance are seen, in cells.
    remnant : fewer unseen cells are no stop of their own where another is near.
    beside : near is nearer than this, in cells.

    Returns
    -------
    numbers : (S,) int64, the patches with a stop, the fullest first.
    places : (S, 2) float64, columns and rows, cell centres at whole numbers.
    seen : (S,) int64, unseen cells that each adds to those before it.
    """
    columns, rows = area_cells.shape
    patches = len(sums)
    left = sums.copy()
    waiting = wanted.copy()
    numbers, seen = np.empty(patches, dtype=np.int64), np.empty(patches, dtype=np.int64)
    places = np.empty((patches, 2))
    stops = 0
    while True:
        fullest, most = -1, 0
        for patch in range(patches):
            if waiting[patch] and left[patch, 0] > most:
                fullest, most = patch, left[patch, 0]
        if fullest < 0:
            break
        waiting[fullest] = False
        u, v = left[fullest, 1] / most, left[fullest, 2] / most
        if most < remnant and _is_near(places[:stops], u, v, beside):
            continue
        added = 0
        for column in range(max(0, int(u - radius)), min(columns - 1, int(u + radius) + 1) + 1):
            for row in range(max(0, int(v - radius)), min(rows - 1, int(v + radius) + 1) + 1):
                if (column - u) ** 2 + (row - v) ** 2 > radius * radius or marks[column, row] == mark:
                    continue
                if area_cells[column, row] and first_stamp_ms[column, row] == UNOBSERVED_STAMP_MS:
                    marks[column, row] = mark
                    patch = across[column] + along[row]
                    left[patch, 0] -= 1
                    left[patch, 1] -= column
                    left[patch, 2] -= row
                    added += 1
        numbers[stops], places[stops, 0], places[stops, 1], seen[stops] = fullest, u, v, added
        stops += 1
    return numbers[:stops], places[:stops], seen[:stops]


@compiled
def _is_near(places: FloatArray, u: float, v: float, beside: float) -> bool:
    for place in range(len(places)):
        if (places[place, 0] - u) ** 2 + (places[place, 1] - v) ** 2 < beside * beside:
            return True
    return False
