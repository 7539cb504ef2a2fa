"""A vehicle's navigator in the small town of `town_missions`, with a street looked over."""

from __future__ import annotations

import numpy as np

from sim_bridge.world import World
from tests.fakes.town_missions import town_plan
from vehicle_agent.behaviour.outfit import outfit
from vehicle_agent.behaviour.town_navigator import TownNavigator
from vehicle_agent.behaviour.voxel_share import VoxelShare
from vehicle_agent.domain.frames import Point
from vehicle_agent.ports import SensorScan

OVER_THE_STREET: Point = (10.0, 4.5, 12.5)


def navigator_over_a_street() -> TownNavigator:
    """A vehicle that has looked around and knows where to look next."""
    plan = town_plan()
    shared, navigator = outfit(plan, 0, np.random.default_rng(0))
    assert isinstance(shared, VoxelShare)
    assert isinstance(navigator, TownNavigator)
    town = World.of(plan).town
    assert town is not None
    for stamp_ms, place in enumerate(((4.5, 4.5, 12.5), OVER_THE_STREET, (15.5, 4.5, 12.5))):
        shared.take_scan(SensorScan(town.scan(place, 10.0, stamp_ms + 1)))
    return navigator
