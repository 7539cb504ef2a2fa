"""What of a town can be observed at all: the surface that some place within reach sees, whoever flies there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim_bridge.town_world import Town
from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.ray_fan import RayFan, StepArray, down_looking_fan
from vehicle_agent.domain.voxel_paths import UNREACHED, voxel_distances, with_clearance
from vehicle_agent.mission.load import MissionPlan


@dataclass(frozen=True, slots=True)
class Observable:
    """Ground truth that no vehicle knows.

    Attributes
    ----------
    surface : (U, V, W) bool, solid voxels that a sensor at some reachable place meets with one of its rays.
    reachable : (U, V, W) bool, places that vehicles can fly to with clearance.
    """

    surface: BoolArray
    reachable: BoolArray


def observable_of(solid: BoolArray, ceiling: int, start: tuple[int, int, int], fan: RayFan) -> Observable:
    """Try every solid voxel that touches air against every reachable place, nearest first."""
    flyable = with_clearance(~solid)
    flyable[:, :, ceiling + 1 :] = False
    flat_start = int(np.ravel_multi_index(start, solid.shape))
    distances, _ = voxel_distances(flyable, flat_start, np.empty(0, dtype=np.bool_), 0)
    reachable = (distances != UNREACHED).reshape(solid.shape)
    surface = _meets_rays(solid) & solid
    candidates = np.argwhere(surface)
    seen = _seen_from_somewhere(
        solid, reachable, candidates, fan.steps, fan.firsts,
        fan.crossings.firsts, fan.crossings.rays, fan.crossings.steps, _displacements(fan),
    )  # fmt: skip
    result = np.zeros(solid.shape, dtype=np.bool_)
    result[tuple(candidates[seen].T)] = True
    return Observable(result, reachable)


def observable_surface(plan: MissionPlan, town: Town) -> BoolArray:
    """Surface voxels of the area that some vehicle of a mission can see from where it can get: (U, V, W) bool."""
    seen = np.zeros(town.grid.shape, dtype=np.bool_)
    kinds = {(v.sensor.range_m, v.max_above_terrain_m): v for v in plan.mission.vehicles}
    for vehicle in kinds.values():
        east_m, north_m = vehicle.start_enu_m[:2]
        start = town.grid.voxel_of((east_m, north_m, vehicle.max_above_terrain_m))
        seen |= observable_of(
            town.solid, start[2], start, down_looking_fan(vehicle.sensor.range_m / town.grid.voxel_m)
        ).surface
    surface: BoolArray = seen & plan.area_cells[:, :, None]
    return surface


def _meets_rays(solid: BoolArray) -> BoolArray:
    """Voxels that a ray could enter: with air beside them or on top; rays never rise."""
    air = ~solid
    touched = np.zeros(solid.shape, dtype=np.bool_)
    touched[:, :, :-1] |= air[:, :, 1:]
    for axis in range(2):
        here, there = np.moveaxis(touched, axis, 0), np.moveaxis(air, axis, 0)
        here[1:] |= there[:-1]
        here[:-1] |= there[1:]
    return touched


def _displacements(fan: RayFan) -> IndexArray:
    """Displacements that some ray passes, nearest first: (D, 4) int64, (du, dv, dw) and its place in the crossings."""
    side = 2 * fan.reach + 1
    present = np.flatnonzero(np.diff(fan.crossings.firsts))
    du, dv, dw = np.unravel_index(present, (side, side, fan.reach + 1))
    offsets = np.column_stack((du - fan.reach, dv - fan.reach, -dw, present)).astype(np.int64)
    ordered: IndexArray = offsets[np.argsort((offsets[:, :3] ** 2).sum(axis=1), kind="stable")]
    return ordered


@compiled
def _seen_from_somewhere(
    solid: BoolArray, reachable: BoolArray, candidates: IndexArray, steps: StepArray, firsts: IndexArray,
    table_first: IndexArray, table_rays: npt.NDArray[np.int32], table_steps: IndexArray, order: IndexArray,
) -> BoolArray:  # fmt: skip
    columns, rows, layers = solid.shape
    seen = np.zeros(len(candidates), dtype=np.bool_)
    for index in range(len(candidates)):
        for place in range(len(order)):
            u = candidates[index, 0] - order[place, 0]
            v = candidates[index, 1] - order[place, 1]
            w = candidates[index, 2] - order[place, 2]
            if u < 0 or v < 0 or w < 0 or u >= columns or v >= rows or w >= layers or not reachable[u, v, w]:
                continue
            code = order[place, 3]
            for entry in range(table_first[code], table_first[code + 1]):
                ray, target = table_rays[entry], table_steps[entry]
                clear = True
                for step in range(firsts[ray], target):
                    if solid[u + steps[step, 0], v + steps[step, 1], w + steps[step, 2]]:
                        clear = False
                        break
                if clear:
                    seen[index] = True
                    break
            if seen[index]:
                break
    return seen
