"""What must hold in a mission file whose task is to map: a team that can start, speak and measure."""

from __future__ import annotations

import math

from vehicle_agent.mission.plan import MissionError, MissionPlan
from vehicle_agent.mission.tasks import MapTask
from vehicle_agent.mission.vehicles import SingleBeamSensor

MAX_LANDMARKS = 250_000


def check_map_team(plan: MissionPlan) -> None:
    """Refuse a team that cannot map, with a MissionError."""
    mission = plan.mission

    def fail(key: str, trouble: str) -> MissionError:
        return MissionError(f"{plan.source}: {key}: {trouble}")

    if plan.grid.cells > MAX_LANDMARKS:
        raise fail("area.cell_m", f"makes {plan.grid.cells} landmarks, one a cell; at most {MAX_LANDMARKS} can be told")
    names = plan.vehicle_names
    if isinstance(mission.task, MapTask) and (unknown := [n for n in mission.task.stays_down if n not in names]):
        raise fail("task.stays_down", f"names no vehicle with {unknown[0]!r}; there are {', '.join(names)}")
    for index, vehicle in enumerate(mission.vehicles):
        where = f"vehicles[{index}]"
        if vehicle.type != "underwater-vehicle":
            raise fail(
                f"{where}.type", f"a {vehicle.type} cannot map yet; make it an underwater-vehicle, or let it explore"
            )
        if not isinstance(vehicle.sensor, SingleBeamSensor):
            raise fail(f"{where}.sensor.kind", "landmarks are measured by 'single-beam' only; choose that")
        if vehicle.sensor.noise_fraction == 0.0:
            raise fail(
                f"{where}.sensor.noise_fraction",
                "must be larger than 0, or no estimate could say how good it is; 0.01 is a common echo sounder",
            )
        if vehicle.depth_m is None:
            raise fail(f"{where}.depth_m", "missing; tell how deep an underwater vehicle is to map")
        _check_voice(plan, index)
        for other, rival in enumerate(mission.vehicles[:index]):
            if rival.depth_m is not None and abs(rival.depth_m - vehicle.depth_m) < 1.0:
                raise fail(
                    f"{where}.depth_m",
                    f"is within 1 m of that of vehicles[{other}]; keep vehicles at depths of their own, "
                    "so that they need not make room for each other",
                )


def _check_voice(plan: MissionPlan, index: int) -> None:
    """Refuse a start from which nobody is heard."""
    mission = plan.mission
    range_m, starts = mission.radio.range_m, [vehicle.start_enu_m[:2] for vehicle in mission.vehicles]
    if range_m is None or len(starts) == 1:
        return
    nearest_m = min(math.dist(starts[index], start) for other, start in enumerate(starts) if other != index)
    if nearest_m > range_m:
        raise MissionError(
            f"{plan.source}: vehicles[{index}].start_enu_m: is {nearest_m:.0f} m from the nearest teammate, out of "
            f"everyone's radio range (radio.range_m is {range_m:g} m); start nearer to one of them"
        )


def is_map(plan: MissionPlan) -> bool:
    """Tell whether a mission's task is to map landmarks."""
    return isinstance(plan.mission.task, MapTask)
