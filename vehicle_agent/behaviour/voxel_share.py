"""The team's voxel map as it is shared: scans become evidence, and what they decide about a voxel is told.

A voxel is told when a vehicle's own evidence first decides whether it is free, and again when the decision changes; the
counts in between are left out, so that what is told of a scan is little.
"""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.range_image import RangeImage
from vehicle_agent.domain.ray_fan import RayFan, down_looking_fan
from vehicle_agent.domain.voxel_evidence import VoxelEvidence
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.domain.voxels import OCCUPIED, VoxelMap, decided_states, newly_decided
from vehicle_agent.planning.voxel_picture import VoxelPicture
from vehicle_agent.ports import SensorScan
from vehicle_agent.wire.cells import MAX_STAMP_MS
from vehicle_agent.wire.voxel_blob import pack_voxels, unpack_voxels


class VoxelShare:
    """A `SharedMap` of voxels.

    Attributes
    ----------
    fan
        The rays of the own sensor.
    ceiling
        Highest layer in which the vehicle flies.
    last_scan_ms
        Stamp of the newest own scan.
    """

    def __init__(self, grid: VoxelGrid, own_index: int, range_m: float, ceiling: int) -> None:
        self.team_map = VoxelMap(grid)
        self.fan: RayFan = down_looking_fan(range_m / grid.voxel_m)
        self.ceiling = ceiling
        self.version = 0
        self.last_scan_ms = 0
        self._own_index = own_index
        self._range_m = range_m
        aims = self.fan.aims
        self._directions: FloatArray = aims / np.linalg.norm(aims, axis=1)[:, None]
        self._told = np.zeros(grid.voxels, dtype=np.uint8)
        self._waiting: list[VoxelEvidence] = []
        self._picture: VoxelPicture | None = None
        self._first_seen: dict[int, float] = {}

    @property
    def picture(self) -> VoxelPicture:
        """What the map showed at the newest own scan."""
        if self._picture is None:
            self._picture = VoxelPicture.of(self.team_map.states(), self.ceiling)
        return self._picture

    def take_scan(self, scan: SensorScan) -> tuple[int, bool]:
        image = scan.seen
        if not isinstance(image, RangeImage) or len(image) != len(self._directions):
            return 0, False
        if not (0 <= image.stamp_ms <= MAX_STAMP_MS and all(map(math.isfinite, image.sensor_enu_m))):
            return 0, False
        ends = np.array(image.sensor_enu_m) + self._directions * image.ranges_m[:, None].astype(np.float64)
        most_m = self._range_m + self.team_map.grid.voxel_m
        try:
            self.team_map.insert(self._own_index, image.sensor_enu_m, ends, most_m, image.stamp_ms, image.returned)
        except ValueError:
            return 0, False
        self.version += 1
        self.last_scan_ms = max(self.last_scan_ms, image.stamp_ms)
        self._picture = None
        self._first_seen.clear()
        return len(image), True

    def next_blob(self, most_bytes: int) -> bytes | None:
        if not self._waiting:
            news = newly_decided(self.team_map.take_untold(self._own_index), self._told)
            if len(news) == 0:
                return None
            self._waiting.append(news)
        evidence = self._waiting.pop()
        blob = pack_voxels(evidence)
        while len(blob) > most_bytes:
            count = max(1, int(0.9 * len(evidence) * most_bytes / len(blob)))
            self._waiting.append(evidence.chosen(slice(count, None)))
            evidence = evidence.chosen(slice(count))
            blob = pack_voxels(evidence)
        return blob

    def fold(self, contributor: int, blob: bytes) -> bool:
        told = unpack_voxels(blob, self.team_map.grid.voxels)
        if told is None:
            return False
        self.team_map.observe(contributor, told)
        if contributor == self._own_index and len(told):  # from the journal: it was told before
            self._told[told.voxel_indices] = decided_states(told)
        self.version += 1
        return True

    def known_fraction(self, area_cells: BoolArray) -> float:
        """Known surface as a share of it and of the frontiers, which are what is known to be left."""
        picture = self.picture
        surface = int(np.count_nonzero((picture.states == OCCUPIED) & area_cells[:, :, None]))
        frontier = int(np.count_nonzero(picture.frontier & area_cells[:, :, None]))
        return surface / max(1, surface + frontier)

    def first_seen(self, index: int, area_cells: BoolArray) -> float:
        if index not in self._first_seen:
            self._first_seen[index] = self.team_map.first_observer_share(index, area_cells)
        return self._first_seen[index]

    def highest_up_m(self) -> float:
        """What is above the ceiling is taken to be clear."""
        grid = self.team_map.grid
        return grid.bottom_m + (self.ceiling + 1) * grid.voxel_m
