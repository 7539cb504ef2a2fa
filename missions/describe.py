"""Tells in words what a mission will do."""

from __future__ import annotations

import numpy as np

from missions.processes import is_simulated, simulated_names
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.mission.load import MissionPlan


def one_line(plan: MissionPlan) -> str:
    """Name, task, team, area and title of a mission on one line."""
    mission = plan.mission
    team = f"{len(mission.vehicles)} vehicle{'s' if len(mission.vehicles) != 1 else ''}"
    return f"{mission.name:<16} {task_word(plan):<8} {team:<11} {area_km2(plan):>7.2f} km2  {mission.title}"


def task_word(plan: MissionPlan) -> str:
    """The task's kind as the mission file calls it."""
    kind: str = type(plan.mission.task).__struct_config__.tag  # type: ignore[assignment]
    return kind


def area_km2(plan: MissionPlan) -> float:
    return float(np.count_nonzero(plan.area_cells)) * plan.grid.cell_m**2 / 1e6


def description(plan: MissionPlan, elevation_m: FloatArray | None, reachable: BoolArray | None) -> str:
    """What a mission will do, a line each for area, ground, task, vehicles, radio and ports.

    Parameters
    ----------
    elevation_m : (columns, rows) float64, ENU z of the true surface; None when no vehicle is simulated.
    reachable : bool, what of the surface can be seen at all, as of `missions.yardstick.observable`; None likewise.
    """
    mission, grid = plan.mission, plan.grid
    lines = [
        f"{mission.name}: {mission.title}" if mission.title else mission.name,
        f"  area      {grid.columns * grid.cell_m:g} m x {grid.rows * grid.cell_m:g} m, {area_km2(plan):.2f} km2 in "
        f"{np.count_nonzero(plan.area_cells)} cells of {grid.cell_m:g} m, "
        f"fence margin {mission.area.fence_margin_m:g} m",
        f"  datum     {mission.datum.latitude_deg:.6f}, {mission.datum.longitude_deg:.6f} deg, "
        f"{mission.datum.altitude_amsl_m:g} m above mean sea level",
    ]
    if (voxels := plan.voxel_grid) is not None:
        lines.append(
            f"  volume    {voxels.columns} x {voxels.rows} x {voxels.layers} voxels of {voxels.voxel_m:g} m, "
            f"up {voxels.bottom_m:g} m to {voxels.bottom_m + voxels.layers * voxels.voxel_m:g} m"
        )
    if elevation_m is not None:
        inside = elevation_m[plan.area_cells]
        lines.append(f"  ground    {inside.min():.0f} m to {inside.max():.0f} m above the datum")
    if reachable is not None:
        seen = np.count_nonzero(reachable)
        share = f"{100 * seen / np.count_nonzero(plan.area_cells):.2f} %" if reachable.ndim == 2 else f"{seen} voxels"
        lines.append(f"  reachable {share} of the surface can be seen by this team")
    lines.append(
        f"  task      {task_word(plan)}, planner {mission.task.planner}, steps of at most {mission.task.step_m:g} m, "
        f"seed {mission.seed}"
    )
    lines += [_vehicle_line(plan, index, elevation_m) for index in range(len(mission.vehicles))]
    lines.append(
        f"  ends      at {100 * mission.stop.observed_fraction:g} % observed, after {mission.stop.time_limit_s:g} s of "
        f"vehicle time, or for a vehicle at {100 * mission.stop.battery_reserve:g} % battery"
    )
    radio = mission.radio
    said = f"{radio.rate_bytes_s:g} B/s"
    if radio.packet_bytes is not None:
        said = f"{radio.packet_bytes} bytes every {radio.packet_period_s:g} s"
    lines.append(
        f"  radio     {said} per vehicle, Zenoh on {mission.radio.endpoint_host} "
        f"from TCP port {mission.radio.zenoh_port}"
    )
    if simulated_names(plan):
        lines.append(
            f"  simulated at {mission.simulation.speedup:g} x real time, MAVLink from TCP and UDP port "
            f"{mission.simulation.mavlink_port}"
        )
    return "\n".join(lines)


def _vehicle_line(plan: MissionPlan, index: int, elevation_m: FloatArray | None) -> str:
    vehicle = plan.mission.vehicles[index]
    east_m, north_m = vehicle.start_enu_m[:2]
    stands = ""
    if elevation_m is not None:
        stands = f" on {elevation_m[plan.grid.cell_of(east_m, north_m)]:.0f} m"
    body = "simulated" if is_simulated(plan, index) else f"at {vehicle.connection}"
    band = f"{vehicle.min_above_terrain_m:g} to {vehicle.max_above_terrain_m:g} m above ground"
    if vehicle.depth_m is not None:
        band = f"{vehicle.depth_m:g} m deep"
    return (
        f"  vehicle   {vehicle.name}: {vehicle.type} {plan.system_id(index)} ({body}) "
        f"from ({east_m:g}, {north_m:g}){stands}, {vehicle.speed_m_s:g} m/s, "
        f"{band}, "
        f"sees {vehicle.sensor.range_m:g} m"
    )
