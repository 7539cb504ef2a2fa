"""Patches of a town: boxes of voxels, stacked in columns, in which frontiers are counted and between which ways go.

Streets are narrow and walls high: two patches may be near each other and yet far to fly, or one above the other. So
ways are searched through the air that is known, though roughly: through boxes that hold any passable voxel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.voxel_paths import UNIT, UNREACHED, voxel_distances
from vehicle_agent.planning.voxel_picture import VoxelPicture

BOX = 4
"""Edge of the boxes through which ways between patches are searched."""
SEARCHED = 40.0
"""Ways are searched so far; a place that is not found counts as `DETOUR` times as far as the straight line, voxels."""
DETOUR = 1.2
COLUMNS_BESIDE = 2


@dataclass(frozen=True, slots=True)
class VoxelPatches:
    """How a grid of voxels is divided.

    Attributes
    ----------
    shape : voxels of the grid along east, north and up.
    edge, high : a patch's edge along east and north, and along up, in voxels.
    """

    shape: tuple[int, ...]
    edge: int
    high: int

    @property
    def counts(self) -> tuple[int, int, int]:
        """Patches along east, north and up; they are numbered in C order."""
        return (-(-self.shape[0] // self.edge), -(-self.shape[1] // self.edge), -(-self.shape[2] // self.high))

    def patch_of(self, voxels: IndexArray) -> IndexArray:
        """Numbers of the patches that voxels belong to: (N, 3) -> (N,) int64."""
        return self.column_of(voxels) * self.counts[2] + voxels[:, 2] // self.high

    def column_of(self, voxels: IndexArray) -> IndexArray:
        """Numbers of the columns that voxels belong to: (N, 3) -> (N,) int64."""
        return voxels[:, 0] // self.edge * self.counts[1] + voxels[:, 1] // self.edge

    def columns(self) -> IndexArray:
        """The column of each patch: (P,) int64."""
        across, along, up = self.counts
        return np.repeat(np.arange(across * along), up)

    def column_middles(self, layer: int) -> IndexArray:
        """The voxel in the middle of each column, at a layer: (C, 3) int64."""
        across, along = np.meshgrid(np.arange(self.counts[0]), np.arange(self.counts[1]), indexing="ij")
        middles = np.column_stack((across.ravel(), along.ravel())) * self.edge + self.edge // 2
        middles = np.minimum(middles, np.array(self.shape[:2]) - 1)
        return np.column_stack((middles, np.full(len(middles), layer)))

    def known_per_column(self, picture: VoxelPicture) -> IndexArray:
        """Known voxels up to the ceiling: (C,) int64."""
        known = np.count_nonzero(picture.states[:, :, : picture.ceiling + 1], axis=2)
        sums = np.add.reduceat(
            np.add.reduceat(known, np.arange(0, known.shape[0], self.edge), axis=0),
            np.arange(0, known.shape[1], self.edge),
            axis=1,
        )
        return np.asarray(sums, dtype=np.int64).ravel()

    def sums_around(self, per_column: IndexArray) -> IndexArray:
        """Sum over each column and those up to two away: (C,) -> (C,) int64."""
        padded = np.pad(per_column.reshape(self.counts[:2]), COLUMNS_BESIDE)
        side = 2 * COLUMNS_BESIDE + 1
        windows = np.lib.stride_tricks.sliding_window_view(padded, (side, side))
        sums: IndexArray = windows.sum(axis=(2, 3)).ravel()
        return sums


@dataclass(frozen=True, slots=True)
class FrontierWork:
    """What the frontiers leave to be looked at, by patch.

    Attributes
    ----------
    voxels : (N, 3) int64, the frontier; worth : (N,) float64, its chances of being surface.
    patches : (N,) int64, the patch of each.
    expected : (P,) float64, surface expected at each patch's frontier, in voxels.
    centres : (P, 3) int64, the voxel in the middle of that; the grid's corner where there is no frontier.
    """

    voxels: IndexArray
    worth: FloatArray
    patches: IndexArray
    expected: FloatArray
    centres: IndexArray

    @classmethod
    def of(cls, picture: VoxelPicture, division: VoxelPatches) -> FrontierWork:
        voxels = np.argwhere(picture.frontier)
        worth = picture.worth[tuple(voxels.T)].astype(np.float64)
        patches, count = division.patch_of(voxels), int(np.prod(division.counts))
        expected = np.bincount(patches, weights=worth, minlength=count).astype(np.float64)
        moments = [np.bincount(patches, weights=worth * voxels[:, axis], minlength=count) for axis in range(3)]
        centres = np.rint(np.column_stack(moments) / np.maximum(expected, 1e-9)[:, None]).astype(np.int64)
        return cls(voxels, worth, patches, expected, centres)


def ways_between(picture: VoxelPicture, places: IndexArray) -> FloatArray:
    """Roughly how far places are from each other through known air: (N, 3) int64 voxels -> (N, N) float64, voxels.

    A place that no air is known of is taken to be reached from above.
    """
    boxes = _open_boxes(picture)
    at = np.minimum(places, (*picture.states.shape[:2], picture.ceiling)) // BOX + 1
    for column, row, layer in at:
        above = layer + int(np.argmax(boxes[column, row, layer:]))
        boxes[column, row, layer:above] = True
    flat = np.ravel_multi_index(tuple(at.T), boxes.shape)
    straight: FloatArray = np.linalg.norm(places[:, None] - places[None], axis=2)
    ways = np.empty_like(straight)
    here: BoolArray = np.zeros(boxes.size, dtype=np.bool_)
    for index, start in enumerate(flat):
        here[start] = True
        distances, _ = voxel_distances(boxes, int(start), here, round(SEARCHED / BOX * UNIT))
        here[start] = False
        found = distances[flat]
        ways[index] = np.where(found == UNREACHED, DETOUR * straight[index], found * (BOX / UNIT))
    ways = np.maximum(ways, straight)
    return np.minimum(ways, ways.T)


def _open_boxes(picture: VoxelPicture) -> BoolArray:
    """Boxes of voxels that hold a passable one or lie at the ceiling, where all is clear; closed ones around them."""
    passable = np.pad(picture.passable, [(0, -size % BOX) for size in picture.passable.shape])
    across, along, up = (size // BOX for size in passable.shape)
    parts = passable.reshape(across, BOX, along, BOX, up, BOX)
    boxes: BoolArray = np.asarray(parts.any(axis=(1, 3, 5)), dtype=np.bool_)
    boxes[:, :, picture.ceiling // BOX] = True
    padded: BoolArray = np.pad(boxes, 1)
    return padded
