"""What must hold between the values of a mission file, beyond each value's own bounds."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.polygon import distance_to_border_m, first_crossing, points_inside
from vehicle_agent.mission.map_checks import check_map_team
from vehicle_agent.mission.plan import MissionError, MissionPlan
from vehicle_agent.mission.tasks import CoverTask, ExploreTask, MapTask
from vehicle_agent.mission.terrain import GaussianTerrain, TownTerrain
from vehicle_agent.mission.vehicles import HalfSphereSensor, SingleBeamSensor, VehicleTable

MAX_CELLS = 4_000_000
MAX_VOXELS = 8_000_000
MAX_REACH_M = 100_000.0
"""Beyond this distance from the datum the local plane no longer stands for the ground."""
MIN_START_DISTANCE_M = 5.0
MAX_PORT = 65_535
RESERVED_NAMES = ("observer", "referee", "simulator", "station")
"""First words of the names under which everybody else speaks on Zenoh."""

Fail = Callable[[str, str], MissionError]
"""Makes the error from a key's path and what is wrong there."""


def check_fence(key: str, fence_en_m: FloatArray, cell_m: float, fail: Fail) -> None:
    """Refuse an area that is far away, not a simple polygon, or of too many cells: (V, 2) float64 ENU metres."""
    reach_m = float(np.hypot(fence_en_m[:, 0], fence_en_m[:, 1]).max())
    if reach_m > MAX_REACH_M:
        raise fail(
            key,
            f"reaches {reach_m / 1000:.0f} km from the datum; "
            f"choose a datum within {MAX_REACH_M / 1000:.0f} km of all corners",
        )
    corners = len(fence_en_m)
    for index in range(corners):
        before = (index - 1) % corners
        if np.hypot(*(fence_en_m[index] - fence_en_m[before])) < 1e-6:
            raise fail(key, f"corners {before} and {index} are the same point; remove one of them")
    if np.linalg.matrix_rank(fence_en_m - fence_en_m[0], tol=1e-6) < 2:
        raise fail(key, "encloses no ground; give corners that are not all on one line")
    if (crossing := first_crossing(fence_en_m)) is not None:
        first, second = crossing
        raise fail(
            key,
            f"the edge that begins at corner {first} meets the one that begins at corner {second}; "
            "give the corners in order around the area",
        )
    width_m, height_m = np.ptp(fence_en_m, axis=0).tolist()
    cells = math.ceil(width_m / cell_m) * math.ceil(height_m / cell_m)
    if cells > MAX_CELLS:
        # Twice the root leaves room for the rounding up of long and narrow areas.
        enough_m = max(2.0 * math.sqrt(width_m * height_m / MAX_CELLS), 2.0 * max(width_m, height_m) / MAX_CELLS)
        raise fail("area.cell_m", f"{cell_m:g} m makes {cells} cells; choose for instance {enough_m:.2g} m")


def check_terrain(plan: MissionPlan, fail: Fail) -> None:
    """Refuse terrain whose numbers contradict each other."""
    terrain = plan.mission.terrain
    if isinstance(terrain, GaussianTerrain | TownTerrain) and terrain.height_m[0] > terrain.height_m[1]:
        raise fail("terrain.height_m", "must be [lowest, highest] with lowest <= highest")
    if isinstance(terrain, TownTerrain) and not terrain.street_m[0] <= terrain.street_m[1] < terrain.block_m:
        raise fail("terrain.street_m", "must be [narrowest, widest], both smaller than block_m")
    _check_volume(plan, fail)


def _check_volume(plan: MissionPlan, fail: Fail) -> None:
    """Refuse a town without a volume to map, and a volume that is too thin or too large."""
    up_m, cell_m = plan.mission.area.up_m, plan.mission.area.cell_m
    if up_m is None:
        if isinstance(plan.mission.terrain, TownTerrain):
            raise fail("area.up_m", "missing; a town needs the lowest and highest up of its map, e.g. [-1.0, 30.0]")
        return
    low_m, high_m = up_m
    if abs(low_m + cell_m) > 1e-6 or high_m <= 0.0:
        raise fail("area.up_m", f"must be [{-cell_m:g}, highest]: one voxel of ground below 0, and all buildings above")
    voxels = plan.grid.cells * math.ceil((high_m - low_m) / cell_m)
    if voxels > MAX_VOXELS:
        raise fail("area.cell_m", f"{cell_m:g} m makes {voxels} voxels; choose {2.0 * cell_m:g} m or a smaller area")
    for index, vehicle in enumerate(plan.mission.vehicles):
        highest_m = high_m - 2.0 * cell_m
        if vehicle.max_above_terrain_m > highest_m:
            raise fail(
                f"vehicles[{index}].max_above_terrain_m",
                f"must be at most {highest_m:g} m, two voxels below the top of area.up_m",
            )


def check_team(plan: MissionPlan, fail: Fail) -> None:
    """Refuse a team of which two are alike in what must differ, or one that cannot start or see the ground."""
    seen: dict[tuple[str, object], int] = {}
    for index, vehicle in enumerate(plan.mission.vehicles):
        where = f"vehicles[{index}]"
        if vehicle.name.split("-")[0] in RESERVED_NAMES:
            raise fail(f"{where}.name", f"'{vehicle.name}' is kept for stations; choose another name")
        for key, value, mend in (
            ("name", vehicle.name, "give every vehicle its own name"),
            ("system_id", plan.system_id(index), "give every autopilot its own id"),
            ("connection", vehicle.connection, "give every autopilot its own connection"),
        ):
            if value is not None and (other := seen.setdefault((key, value), index)) != index:
                raise fail(f"{where}.{key}", f"'{value}' is also that of vehicles[{other}]; {mend}")
        if vehicle.autopilot == "px4" and vehicle.type != "multicopter":
            raise fail(f"{where}.autopilot", f"a {vehicle.type} cannot be simulated as px4; choose ardupilot")
        _check_heights(where, vehicle, fail)
        _check_start(plan, index, fail)
    for number, fault in enumerate(plan.mission.simulation.faults):
        if fault.vehicle not in plan.vehicle_names:
            raise fail(
                f"simulation.faults[{number}].vehicle",
                f"there is no vehicle '{fault.vehicle}'; the mission has {', '.join(plan.vehicle_names)}",
            )


def check_task(plan: MissionPlan) -> None:
    """Refuse a team that cannot do its task; the simulator serves such a team all the same."""
    if isinstance(plan.mission.task, CoverTask):
        _check_known_points(plan, plan.mission.task)
    if isinstance(plan.mission.task, MapTask):
        check_map_team(plan)
        return
    for index, vehicle in enumerate(plan.mission.vehicles):
        if vehicle.type != "multicopter":
            raise MissionError(
                f"{plan.source}: vehicles[{index}].type: a {vehicle.type} cannot explore yet; make it a multicopter, "
                "or serve the team with sim-bridge alone"
            )
        _check_sensor(plan, index)
    if plan.voxel_grid is not None:
        _check_town_task(plan)


def _check_town_task(plan: MissionPlan) -> None:
    """Refuse planners and keys that are for maps of elevations only."""
    task = plan.mission.task
    if isinstance(task, ExploreTask) and task.planner != "tours":
        raise MissionError(
            f"{plan.source}: task.planner: towns can be explored by planner 'tours' only; choose it, or leave out "
            "area.up_m"
        )
    if isinstance(task, CoverTask) and task.known_points_enu_m:
        raise MissionError(
            f"{plan.source}: task.known_points_enu_m: a few points say nothing of a town's buildings; leave them out, "
            "or set explore_first = true to look at the town before"
        )


def _check_known_points(plan: MissionPlan, task: CoverTask) -> None:
    """Refuse points that say nothing of the area."""
    points = np.array(task.known_points_enu_m, dtype=np.float64).reshape(-1, 3)
    inside = points_inside(points[:, :2], plan.fence_en_m) & np.isfinite(points).all(axis=1)
    if not inside.all():
        first = int(np.argmin(inside))
        east_m, north_m, _ = points[first]
        raise MissionError(
            f"{plan.source}: task.known_points_enu_m[{first}]: ({east_m:g}, {north_m:g}) lies outside the area; remove "
            "it or widen the area"
        )


def _check_sensor(plan: MissionPlan, index: int) -> None:
    """Refuse a sensor that does not see what the map is made of."""
    vehicle = plan.mission.vehicles[index]
    if plan.voxel_grid is not None:
        if not isinstance(vehicle.sensor, HalfSphereSensor):
            raise MissionError(
                f"{plan.source}: vehicles[{index}].sensor.kind: a map of voxels is seen by 'half-sphere' only; choose "
                "that, or leave out area.up_m"
            )
        return
    if isinstance(vehicle.sensor, HalfSphereSensor):
        raise MissionError(
            f"{plan.source}: vehicles[{index}].sensor.kind: 'half-sphere' sees voxels; give area.up_m, or take 'range'"
        )
    if isinstance(vehicle.sensor, SingleBeamSensor):
        raise MissionError(
            f"{plan.source}: vehicles[{index}].sensor.kind: a single beam does not see enough to explore; "
            "choose 'range', or serve the team with sim-bridge alone"
        )


def _check_heights(where: str, vehicle: VehicleTable, fail: Fail) -> None:
    if vehicle.min_above_terrain_m >= vehicle.max_above_terrain_m:
        raise fail(f"{where}.max_above_terrain_m", "must be larger than min_above_terrain_m")
    if vehicle.min_above_terrain_m >= vehicle.sensor.range_m:
        raise fail(
            f"{where}.sensor.range_m",
            f"{vehicle.sensor.range_m:g} m does not reach the ground from min_above_terrain_m "
            f"({vehicle.min_above_terrain_m:g} m); fly lower or see further",
        )
    if isinstance(vehicle.sensor, SingleBeamSensor) and vehicle.sensor.min_range_m >= vehicle.sensor.range_m:
        raise fail(f"{where}.sensor.min_range_m", "must be smaller than range_m")


def _check_start(plan: MissionPlan, index: int, fail: Fail) -> None:
    where = f"vehicles[{index}].start_enu_m"
    start = np.array([plan.mission.vehicles[index].start_enu_m[:2]], dtype=np.float64)
    if not points_inside(start, plan.fence_en_m)[0]:
        raise fail(where, "lies outside the area; move the start inside or widen the area")
    margin_m = plan.mission.area.fence_margin_m
    to_border_m = float(distance_to_border_m(start, plan.fence_en_m)[0])
    if to_border_m < margin_m:
        raise fail(
            where,
            f"lies {to_border_m:.1f} m from the area's border, inside area.fence_margin_m ({margin_m:g} m); "
            "move the start inwards or make the margin smaller",
        )
    for other, rival in enumerate(plan.mission.vehicles[:index]):
        apart_m = math.dist(start[0], rival.start_enu_m[:2])
        if apart_m < MIN_START_DISTANCE_M:
            raise fail(
                where,
                f"is {apart_m:.1f} m from vehicles[{other}]'s start; "
                f"keep starts at least {MIN_START_DISTANCE_M:g} m apart",
            )


def check_ports(plan: MissionPlan, fail: Fail) -> None:
    """Refuse port ranges that overlap or run past the last port."""
    vehicles = plan.mission.vehicles
    simulated = [index for index, vehicle in enumerate(vehicles) if vehicle.connection is None]
    last_zenoh = plan.mission.radio.zenoh_port + len(vehicles)
    if last_zenoh > MAX_PORT:
        raise fail(
            "radio.zenoh_port",
            f"{len(vehicles)} vehicles need ports up to {last_zenoh}; choose at most {MAX_PORT - len(vehicles)}",
        )
    if not simulated:
        return
    last_mavlink = plan.mavlink_port(simulated[-1])
    if last_mavlink > MAX_PORT:
        highest = MAX_PORT - (last_mavlink - plan.mission.simulation.mavlink_port)
        raise fail(
            "simulation.mavlink_port",
            f"{len(vehicles)} vehicles need ports up to {last_mavlink}; choose at most {highest}",
        )
    for index in simulated:
        port = plan.mavlink_port(index)
        if plan.mission.radio.zenoh_port <= port <= last_zenoh:
            raise fail(
                "radio.zenoh_port",
                f"ports {plan.mission.radio.zenoh_port} to {last_zenoh} include MAVLink port {port} of "
                f"vehicles[{index}]; choose ports above {last_mavlink} or move simulation.mavlink_port",
            )
