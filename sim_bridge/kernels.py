"""Compiles the simulator's kernels once and keeps the result in the cache."""

from __future__ import annotations

import numpy as np

from sim_bridge.dynamics import Bodies
from sim_bridge.world import World
from vehicle_agent.domain.grid import Grid


def warm_up() -> None:
    """Call every kernel with the types it is used with."""
    world = World(Grid(0.0, 0.0, 1.0, 2, 2), np.zeros((2, 2)))
    Bodies(world, np.zeros((1, 2))).advance(0.05)
    world.distance_along_m((0.5, 0.5, 1.0), (0.0, 0.0, -1.0), 2.0)
    world.scan((0.5, 0.5, 1.0), 2.0, 0)
