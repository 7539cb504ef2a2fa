"""What a mission asks of an agent: the kind of map that its team makes, and who leads it through it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vehicle_agent.behaviour.elevation_share import ElevationShare
from vehicle_agent.behaviour.navigator import Navigator
from vehicle_agent.behaviour.shared_map import SharedMap
from vehicle_agent.domain.frames import Point
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.mission.tasks import CoverTask, MapTask
from vehicle_agent.planning.choose import make_task_planner
from vehicle_agent.planning.spread_first import spread_team

if TYPE_CHECKING:
    from vehicle_agent.behaviour.town_navigator import TownNavigator


def make_shared_map(plan: MissionPlan, index: int) -> SharedMap:
    """An empty map of the kind that a mission needs, for one vehicle."""
    voxels = plan.voxel_grid
    if isinstance(plan.mission.task, MapTask):
        from vehicle_agent.behaviour.landmark_share import LandmarkShare

        return LandmarkShare(plan, index)
    if voxels is None:
        return ElevationShare(plan.grid, index)
    from vehicle_agent.behaviour.voxel_share import VoxelShare  # its kernels load only where there is a town

    vehicle = plan.mission.vehicles[index]
    ceiling = voxels.voxel_of((0.0, 0.0, vehicle.max_above_terrain_m))[2]
    return VoxelShare(voxels, index, vehicle.sensor.range_m, ceiling)


def first_place(plan: MissionPlan, index: int) -> Point | None:
    """Where a vehicle begins to cover when something of the surface is known beforehand, else None."""
    mission = plan.mission
    if not isinstance(mission.task, CoverTask) or not mission.task.known_points_enu_m:
        return None
    spread = spread_team(
        np.array(mission.task.known_points_enu_m),
        plan.grid,
        plan.area_cells,
        np.array([vehicle.start_enu_m[:2] for vehicle in mission.vehicles]),
        mission.vehicles[index].min_above_terrain_m,
        np.random.default_rng(mission.seed),  # everybody's dice fall alike
    )
    return (float(spread[index, 0]), float(spread[index, 1]), float(spread[index, 2]))


def outfit(plan: MissionPlan, index: int, rng: np.random.Generator) -> tuple[SharedMap, Navigator | TownNavigator]:
    """A vehicle's map and navigator, which work on each other."""
    shared = make_shared_map(plan, index)
    if isinstance(shared, ElevationShare):
        mission, vehicle = plan.mission, plan.mission.vehicles[index]
        assert not isinstance(mission.task, MapTask)
        start_en_m = (vehicle.start_enu_m[0], vehicle.start_enu_m[1])
        planner = make_task_planner(
            mission.task,
            mission.stop.observed_fraction,
            plan.grid,
            vehicle.sensor.range_m,
            start_en_m,
            rng,
            first_place(plan, index),
        )
        return shared, Navigator(plan, index, planner, shared.team_map)
    from vehicle_agent.behaviour.town_navigator import TownNavigator
    from vehicle_agent.behaviour.voxel_share import VoxelShare

    assert isinstance(shared, VoxelShare)
    if isinstance(plan.mission.task, CoverTask):
        from vehicle_agent.behaviour.town_watch import TownWatch

        return shared, TownWatch(plan, index, shared, plan.mission.task, rng)
    return shared, TownNavigator(plan, index, shared)
