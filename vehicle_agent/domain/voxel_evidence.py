"""What one contributor knows of some voxels, and how far its counts go: all that telling of voxels needs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.elevation import StampArray
from vehicle_agent.domain.grid import IndexArray

ByteArray = npt.NDArray[np.uint8]

MAX_MISSES, MAX_HITS = 5, 4
"""Evidence of one contributor stops growing here: -2.0 and +3.4 in log odds."""
HIT_STEP = 8
"""A voxel's evidence is one byte: misses + 8 x hits."""


@dataclass(frozen=True, slots=True)
class VoxelEvidence:
    """What one contributor knows of some voxels: what a map delta carries.

    Attributes
    ----------
    voxel_indices
        (N,) int64, flat indices into the grid, strictly increasing.
    hits, misses
        (N,) uint8, scans that ended in and that crossed each voxel, counted so far, at most MAX_HITS and MAX_MISSES.
    stamps_ms
        (N,) int64, Unix time of the first hit if the contributor is among the first observers as far as it knows, else
        `UNOBSERVED_STAMP_MS`.
    """

    voxel_indices: IndexArray
    hits: ByteArray
    misses: ByteArray
    stamps_ms: StampArray

    def __len__(self) -> int:
        return len(self.voxel_indices)

    def chosen(self, which: npt.NDArray[np.bool_] | slice) -> VoxelEvidence:
        """Some of the voxels, by mask or slice."""
        return VoxelEvidence(self.voxel_indices[which], self.hits[which], self.misses[which], self.stamps_ms[which])


def is_occupied(hits: npt.NDArray[np.integer], misses: npt.NDArray[np.integer]) -> npt.NDArray[np.bool_]:
    """Whether summed counts make log odds positive: 0.85 a hit, -0.4 a miss."""
    occupied: npt.NDArray[np.bool_] = 17 * hits.astype(np.int16) > 8 * misses.astype(np.int16)
    return occupied
