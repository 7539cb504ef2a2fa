"""How much of an area a team sees from where it stays: what a coverage mission is for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.mission.tasks import CoverTask


def covers(plan: MissionPlan) -> bool:
    """Whether the mission's task is to cover rather than to explore."""
    return isinstance(plan.mission.task, CoverTask)


def covered_fraction(plan: MissionPlan, surface: npt.NDArray[Any], places_enu_m: Mapping[str, Point]) -> float:
    """Share of the surface in sight of at least one vehicle (the team's sum of Renzaglia eq. 1, normalised).

    Of hills the area's cells count; of towns all faces of walls, roofs and ground over the area that touch air from
    beside or above.

    Parameters
    ----------
    surface : (columns, rows) float64, the true surface, ENU z; or of a town (columns, rows, layers) bool, what is
        solid.
    places_enu_m : where each vehicle was last at work, by name.
    """
    if (voxels := plan.voxel_grid) is not None:
        return _covered_faces(plan, voxels, surface, places_enu_m)
    from vehicle_agent.domain.sensing import view  # loads numba: only where something was covered

    seen = np.zeros(plan.grid.shape, dtype=np.bool_)
    for vehicle in plan.mission.vehicles:
        if vehicle.name in places_enu_m:
            seen |= view(plan.grid, surface, places_enu_m[vehicle.name], vehicle.sensor.range_m)
    return float(np.count_nonzero(seen & plan.area_cells)) / int(np.count_nonzero(plan.area_cells))


def _covered_faces(plan: MissionPlan, grid: VoxelGrid, solid: BoolArray, places_enu_m: Mapping[str, Point]) -> float:
    from vehicle_agent.domain.ray_fan import down_looking_fan
    from vehicle_agent.domain.voxel_faces import count_faces, open_faces, seen_faces

    faces = open_faces(solid) * plan.area_cells[:, :, None]
    seen = np.zeros_like(faces)
    for vehicle in plan.mission.vehicles:
        if vehicle.name in places_enu_m:
            place = grid.clamped(grid.voxel_of(places_enu_m[vehicle.name]))
            fan = down_looking_fan(vehicle.sensor.range_m / grid.voxel_m)
            seen |= seen_faces(solid, fan, np.array([place], dtype=np.int64))
    return count_faces(faces & seen) / max(1, count_faces(faces))
