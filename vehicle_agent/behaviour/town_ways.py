"""Ways between buildings to a place that somebody names, and out of a teammate's way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.domain.voxel_paths import UNREACHED, trace_voxels, voxel_distances
from vehicle_agent.planning.voxel_picture import without_traffic


def way_to(passable: BoolArray, grid: VoxelGrid, start: int, place_en_m: tuple[float, float]) -> IndexArray:
    """Voxels to the nearest place that can be reached, as high as the vehicle flies over a point.

    Parameters
    ----------
    passable : (U, V, W) bool.
    start : flat index of the voxel where the vehicle is; not part of the way.
    """
    goal = np.array(grid.clamped(grid.voxel_of((*place_en_m, 0.0)))[:2])
    distances, parents = voxel_distances(passable, start, np.empty(0, dtype=np.bool_), 0)
    reached = np.flatnonzero(distances != UNREACHED)
    columns, rows, layers = np.unravel_index(reached, grid.shape)
    beside = np.hypot(columns - goal[0], rows - goal[1])
    best = np.lexsort((-layers, beside))[0]
    return trace_voxels(parents, int(reached[best]))[1:]


def way_aside(
    passable: BoolArray, grid: VoxelGrid, start: int, passages: Sequence[tuple[Point, Point]], keep_m: float
) -> IndexArray:
    """Voxels to the nearest place that keeps a distance from passages; empty when there is none.

    Parameters
    ----------
    passable, start
        See `way_to`.
    passages
        From where to where, ENU metres.
    """
    distances, parents = voxel_distances(passable, start, np.empty(0, dtype=np.bool_), 0)
    reached = (distances != UNREACHED).reshape(grid.shape)
    places = np.flatnonzero(without_traffic(reached, grid, passages, None, keep_m))
    if len(places) == 0:
        return np.empty(0, dtype=np.int64)
    return trace_voxels(parents, int(places[np.argmin(distances[places])]))[1:]
