"""Compiles the simulator's kernels once and keeps the result in the cache."""

from __future__ import annotations

import numpy as np

from sim_bridge.dynamics import Bodies
from sim_bridge.world import World
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.voxel_grid import VoxelGrid


def warm_up() -> None:
    """Call every kernel with the types it is used with."""
    world = World(Grid(0.0, 0.0, 1.0, 2, 2), np.zeros((2, 2)))
    Bodies(world, np.zeros((1, 2))).advance(0.05)
    world.distance_along_m((0.5, 0.5, 1.0), (0.0, 0.0, -1.0), 2.0)
    world.scan((0.5, 0.5, 1.0), 2.0, 0)


def warm_up_town() -> None:
    """The same for the kernels of towns."""
    from sim_bridge.town_world import Town

    Town(VoxelGrid(0.0, 0.0, -1.0, 1.0, 2, 2, 3), np.zeros((2, 2, 3), dtype=np.bool_)).scan((0.5, 0.5, 1.0), 1.0, 0)
