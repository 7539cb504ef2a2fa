"""Ways through known free voxels, with clearance."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray

UNREACHED = np.int32(2**31 - 1)
UNIT = 10
"""Distance units per voxel: 10, 14 and 17 for a step over a face, an edge and a corner."""
_BUCKETS = 18


def with_clearance(free: BoolArray) -> BoolArray:
    """Voxels that are free together with all their 26 neighbours; those at the border are not: (U, V, W) bool."""
    clear = free.copy()
    for axis in range(3):
        line = np.moveaxis(clear, axis, 0)
        before = line.copy()
        line[1:] &= before[:-1]
        line[:-1] &= before[1:]
        line[0] = line[-1] = False
    return clear


@compiled
def _neighbours(rows: int, layers: int) -> tuple[IndexArray, IndexArray]:
    """Differences of flat indices to the 26 neighbours, and how far they are in UNITs per voxel."""
    offsets, lengths = np.empty(26, dtype=np.int64), np.empty(26, dtype=np.int64)
    count = 0
    for a in range(-1, 2):
        for b in range(-1, 2):
            for c in range(-1, 2):
                moved = abs(a) + abs(b) + abs(c)
                if moved > 0:
                    offsets[count] = (a * rows + b) * layers + c
                    lengths[count] = UNIT if moved == 1 else 14 if moved == 2 else 17
                    count += 1
    return offsets, lengths


@compiled
def voxel_distances(
    passable: BoolArray, start: int, goals: BoolArray, further: int
) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """Shortest distances from one voxel through passable ones, 26-connected (Dijkstra with Dial's buckets).

    Steps may pass edges and corners: with `with_clearance` whatever lies beside them is free.

    Parameters
    ----------
    passable : (U, V, W) bool, C order; nothing at the border is, as `with_clearance` leaves it.
    start : flat index; need not be passable itself; from the border there is no way.
    goals : (U * V * W,) bool; once one is reached, the search goes on `further` units. Empty: everywhere.

    Returns
    -------
    distances : (U * V * W,) int32 in UNITs per voxel, UNREACHED where there is no way and beyond the search.
    parents : (U * V * W,) int32, flat index of the voxel before, -1 at the start and off the way.
    """
    columns, rows, layers = passable.shape
    u, v, w = start // layers // rows, start // layers % rows, start % layers
    distances = np.full(columns * rows * layers, UNREACHED, dtype=np.int32)
    parents = np.full(columns * rows * layers, -1, dtype=np.int32)
    heads = np.full(_BUCKETS, -1, dtype=np.int64)
    voxels, following = np.empty(4096, dtype=np.int64), np.empty(4096, dtype=np.int64)
    voxels[0], following[0], heads[0] = start, -1, 0
    distances[start] = 0
    if min(u, v, w) < 1 or u > columns - 2 or v > rows - 2 or w > layers - 2:
        return distances, parents
    entries, waiting, distance, limit = 1, 1, 0, int(UNREACHED)
    offsets, lengths = _neighbours(rows, layers)
    open_voxels = passable.reshape(-1)
    while waiting > 0 and distance <= limit:
        bucket = distance % _BUCKETS
        while heads[bucket] >= 0:
            entry = heads[bucket]
            heads[bucket] = following[entry]
            waiting -= 1
            flat = voxels[entry]
            if distances[flat] != distance:
                continue
            if len(goals) > 0 and goals[flat] and limit == UNREACHED:
                limit = distance + further
            for neighbour in range(26):
                other, reached = flat + offsets[neighbour], distance + lengths[neighbour]
                if reached >= distances[other] or not open_voxels[other]:
                    continue
                distances[other], parents[other] = reached, flat
                if entries == len(voxels):
                    voxels = np.concatenate((voxels, np.empty(entries, dtype=np.int64)))
                    following = np.concatenate((following, np.empty(entries, dtype=np.int64)))
                bucket_there = reached % _BUCKETS
                voxels[entries], following[entries] = other, heads[bucket_there]
                heads[bucket_there] = entries
                entries += 1
                waiting += 1
        distance += 1
    return distances, parents


def trace_voxels(parents: npt.NDArray[np.int32], goal: int) -> IndexArray:
    """Voxels from the start to a goal, both included, by the parents of `voxel_distances`: (N,) int64 flat indices."""
    way = [goal]
    while (flat := int(parents[way[-1]])) >= 0:
        way.append(flat)
    return np.array(way[::-1], dtype=np.int64)
