"""A town from above: what a record of voxels says about the highest surface of each column."""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.elevation import UNOBSERVED_STAMP_MS, CellObservations
from vehicle_agent.domain.voxel_evidence import VoxelEvidence
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.wire.cells import unpack_cells
from vehicle_agent.wire.voxel_blob import unpack_voxels


def cells_told(plan: MissionPlan, blob: bytes) -> CellObservations | None:
    """Cells that a record tells, of whatever map it is a piece; None when it makes no sense. Never raises."""
    if (voxels := plan.voxel_grid) is None:
        return unpack_cells(blob, plan.grid.cells)
    told = unpack_voxels(blob, voxels.voxels)
    return None if told is None else tops_of(told, voxels)


def tops_of(told: VoxelEvidence, grid: VoxelGrid) -> CellObservations:
    """Highest surface told of each column, at the earliest time that any of it was hit."""
    hit = told.stamps_ms != UNOBSERVED_STAMP_MS
    columns, layers = np.divmod(told.voxel_indices[hit], grid.layers)
    cells, firsts = np.unique(columns, return_index=True)  # voxels of a column follow each other, the highest last
    if len(cells) == 0:
        return CellObservations(cells, np.empty(0, dtype=np.int32), np.empty(0, dtype=np.int64))
    lasts = np.append(firsts[1:], len(columns)) - 1
    tops_m = grid.bottom_m + (layers[lasts] + 1) * grid.voxel_m
    stamps_ms = np.minimum.reduceat(told.stamps_ms[hit], firsts)
    return CellObservations(cells.astype(np.int64), np.rint(10.0 * tops_m).astype(np.int32), stamps_ms)
