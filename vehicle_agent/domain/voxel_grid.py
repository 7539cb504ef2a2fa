"""A regular grid of cubic voxels over the mission's volume."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.grid import IndexArray

MAX_VOXELS = 2**31 - 1


@dataclass(frozen=True, slots=True)
class VoxelGrid:
    """Voxels indexed `[column, row, layer]` along east, north, up; flat index `(column * rows + row) * layers + layer`.

    Attributes
    ----------
    west_m, south_m, bottom_m
        ENU of the lowest corner, metres.
    voxel_m
        Edge of a voxel, metres.
    columns, rows, layers
        Number of voxels along east, north and up.
    """

    west_m: float
    south_m: float
    bottom_m: float
    voxel_m: float
    columns: int
    rows: int
    layers: int

    def __post_init__(self) -> None:
        if not (self.voxel_m > 0 and math.isfinite(self.voxel_m)):
            raise ValueError("voxel_m must be a positive number of metres")
        if min(self.columns, self.rows, self.layers) < 1:
            raise ValueError("a voxel grid needs at least one voxel")
        if self.voxels > MAX_VOXELS:
            raise ValueError(f"a voxel grid holds at most {MAX_VOXELS} voxels; take larger voxels or a smaller volume")

    @property
    def shape(self) -> tuple[int, int, int]:
        return (self.columns, self.rows, self.layers)

    @property
    def voxels(self) -> int:
        return self.columns * self.rows * self.layers

    @property
    def corner_enu_m(self) -> FloatArray:
        """(3,) float64, the lowest corner."""
        return np.array([self.west_m, self.south_m, self.bottom_m])

    def voxel_of(self, point_enu_m: Point) -> tuple[int, int, int]:
        """Column, row and layer of the voxel around a point; a point outside gives an index outside."""
        east_m, north_m, up_m = point_enu_m
        return (
            math.floor((east_m - self.west_m) / self.voxel_m),
            math.floor((north_m - self.south_m) / self.voxel_m),
            math.floor((up_m - self.bottom_m) / self.voxel_m),
        )

    def contains(self, voxel: tuple[int, int, int]) -> bool:
        return all(0 <= index < size for index, size in zip(voxel, self.shape, strict=True))

    def clamped(self, voxel: tuple[int, int, int]) -> tuple[int, int, int]:
        """The nearest voxel inside the grid."""
        column, row, layer = (min(max(index, 0), size - 1) for index, size in zip(voxel, self.shape, strict=True))
        return (column, row, layer)

    def centre_of(self, voxel: tuple[int, int, int]) -> Point:
        """Centre of a voxel, ENU metres."""
        column, row, layer = voxel
        return (
            self.west_m + (column + 0.5) * self.voxel_m,
            self.south_m + (row + 0.5) * self.voxel_m,
            self.bottom_m + (layer + 0.5) * self.voxel_m,
        )

    def centres_of(self, flat_indices: IndexArray) -> FloatArray:
        """Centres of voxels by flat index: (N,) -> (N, 3) float64, ENU metres."""
        places = np.column_stack(np.unravel_index(flat_indices, self.shape))
        centres: FloatArray = self.corner_enu_m + (places + 0.5) * self.voxel_m
        return centres

    def flat_of(self, voxel: tuple[int, int, int]) -> int:
        """Flat index of a voxel inside the grid."""
        column, row, layer = voxel
        return (column * self.rows + row) * self.layers + layer
