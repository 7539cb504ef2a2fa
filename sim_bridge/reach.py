"""Which cells of an area its vehicles can see at all: the honest denominator of a mission's coverage."""

from __future__ import annotations

import numpy as np

from sim_bridge.world import World
from vehicle_agent.domain.polygon import BoolArray, distance_to_border_m, points_inside
from vehicle_agent.domain.sensing import visible_surface
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.mission.vehicles import VehicleTable

HEIGHTS_TRIED = 4
"""Heights at which an admissible place is tried for cells that cannot be overflown."""


def reachable_cells(plan: MissionPlan, world: World) -> BoolArray:
    """Cells of the area that some vehicle can see from an admissible position: (columns, rows) bool.

    Admissible is a position inside the fence by its margin and within the vehicle's height band above the ground.
    A cell whose centre may be overflown is seen from straight above (the mission's check has made sure that the
    lowest height is within range). The others, along the fence, are tried from the admissible cell centres around
    them at `HEIGHTS_TRIED` heights; positions between those are not tried, so the answer errs on the side of fewer.
    """
    grid = plan.grid
    centres = grid.centres_of(np.arange(grid.cells, dtype=np.int64))
    margin_m = plan.mission.area.fence_margin_m
    inside = points_inside(centres, plan.fence_en_m)
    admissible = inside & (distance_to_border_m(centres, plan.fence_en_m) >= margin_m)
    reachable = admissible & plan.area_cells.ravel()
    remaining = plan.area_cells.ravel() & ~reachable
    for vehicle in _distinct_bodies(plan):
        if not remaining.any():
            break
        _look_sideways(world, vehicle, centres, admissible, remaining)
    return (plan.area_cells.ravel() & ~remaining).reshape(grid.shape)


def _distinct_bodies(plan: MissionPlan) -> list[VehicleTable]:
    """One vehicle of every kind that sees or flies differently."""
    kinds = {(v.sensor.range_m, v.min_above_terrain_m, v.max_above_terrain_m): v for v in plan.mission.vehicles}
    return list(kinds.values())


def _look_sideways(
    world: World, vehicle: VehicleTable, centres: np.ndarray, admissible: BoolArray, remaining: BoolArray
) -> None:
    """Strike from `remaining`, in place, what the vehicle sees from admissible cell centres."""
    grid, range_m = world.grid, vehicle.sensor.range_m
    heights = np.linspace(vehicle.min_above_terrain_m, min(vehicle.max_above_terrain_m, range_m), HEIGHTS_TRIED)
    places = np.flatnonzero(admissible)
    for cell in np.flatnonzero(remaining):
        if not remaining[cell] or len(places) == 0:
            continue
        distances = np.hypot(*(centres[places] - centres[cell]).T)
        order = np.argsort(distances, kind="stable")
        for place in places[order[: np.searchsorted(distances[order], range_m)]]:
            east_m, north_m = centres[place]
            ground_m = world.elevation_m.ravel()[place]
            for height_m in heights:
                seen = visible_surface(
                    grid, world.elevation_m, (float(east_m), float(north_m), float(ground_m + height_m)), range_m
                )
                remaining[seen] = False
            if not remaining[cell]:
                break
