"""Compiles the kernels of missions in towns once and keeps the result in the cache."""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.elevation import UNOBSERVED_STAMP_MS
from vehicle_agent.domain.ray_fan import count_seen, down_looking_fan, first_with_view, unknown_met
from vehicle_agent.domain.tours import share_out
from vehicle_agent.domain.voxel_evidence import VoxelEvidence
from vehicle_agent.domain.voxel_faces import best_faces, seen_faces
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.domain.voxel_paths import voxel_distances
from vehicle_agent.domain.voxels import VoxelMap


def warm_up() -> None:
    """Call every kernel with the types it is used with."""
    voxels, fan = VoxelMap(VoxelGrid(0.0, 0.0, 0.0, 1.0, 4, 4, 4)), down_looking_fan(1.0)
    voxels.insert(0, (0.5, 0.5, 0.5), np.ones((1, 3)), 2.0, 0)
    one = np.ones(1, dtype=np.uint8)
    voxels.observe(1, VoxelEvidence(np.zeros(1, dtype=np.int64), one, one, np.array([UNOBSERVED_STAMP_MS])))
    states, spots = voxels.states(), np.ones((1, 3), dtype=np.int64)
    voxels.first_observer_share(0)
    voxel_distances(np.ones((4, 4, 4), dtype=np.bool_), 0, np.empty(0, dtype=np.bool_), 0)
    count_seen(states, fan.steps, fan.firsts, fan.ray_to, spots, spots, np.ones(1), 1.0)
    unknown_met(states, fan.steps, fan.firsts, spots, 1, 0.1)
    share_out(np.zeros((4, 4)), np.zeros(2), np.zeros(2), 1)
    crossings = fan.crossings
    first_with_view(
        states, fan.steps, fan.firsts, fan.reach, crossings.firsts, crossings.rays, crossings.steps, spots, spots
    )
    solid = np.ones((4, 4, 4), dtype=np.bool_)
    faces = seen_faces(solid, fan, spots)
    best_faces(solid, fan.steps, fan.firsts, spots, np.ones((4, 4), dtype=np.int64), faces, np.zeros(1))


if __name__ == "__main__":
    warm_up()
