"""A small mapping mission of two underwater vehicles, as tests change it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec

from vehicle_agent.mission.load import MissionPlan, plan_mission
from vehicle_agent.mission.model import (
    AreaTable,
    DatumTable,
    Mission,
    RadioTable,
    SafetyTable,
    SimulationTable,
    StopTable,
)
from vehicle_agent.mission.tasks import MapTask
from vehicle_agent.mission.terrain import GaussianTerrain
from vehicle_agent.mission.vehicles import SingleBeamSensor, VehicleTable

BEAM = SingleBeamSensor(range_m=40.0, noise_fraction=0.01, period_s=1.0)
FLOOR_M = -12.0


def diver(name: str, east_m: float, depth_m: float, **changes: Any) -> VehicleTable:
    """An underwater vehicle at the south of the area."""
    table = VehicleTable(
        name=name,
        type="underwater-vehicle",
        start_enu_m=(east_m, 5.0),
        speed_m_s=1.5,
        climb_m_s=0.5,
        depth_m=depth_m,
        sensor=BEAM,
        min_above_terrain_m=1.0,
        max_above_terrain_m=40.0,
    )
    return msgspec.structs.replace(table, **changes)


def map_mission(**changes: Any) -> Mission:
    """Two divers over 40 m x 40 m of humps, talking through modems."""
    mission = Mission(
        format=1,
        name="pond",
        seed=3,
        datum=DatumTable(latitude_deg=41.0, longitude_deg=-8.0, altitude_amsl_m=FLOOR_M),
        area=AreaTable(cell_m=2.5, rectangle_enu_m=(0.0, 0.0, 40.0, 40.0), fence_margin_m=1.0),
        terrain=GaussianTerrain(peaks=4, height_m=(1.0, 3.0), sigma_m=7.0),
        task=MapTask(step_m=20.0, accurate_sd_m=0.2),
        vehicles=(diver("alba", 10.0, 2.0), diver("brisa", 30.0, 3.5)),
        radio=RadioTable(packet_bytes=200, packet_period_s=10.0, range_m=300.0, loss=0.1, delay_s=0.5),
        safety=SafetyTable(separation_m=1.0, teammate_silence_s=90.0),
        simulation=SimulationTable(water_level_m=-FLOOR_M, gps_noise_m=0.3, speedup=20.0, ready_after_s=4.0),
        stop=StopTable(time_limit_s=240.0),
    )
    return msgspec.structs.replace(mission, **changes)


def map_plan(**changes: Any) -> MissionPlan:
    """The same, checked."""
    return plan_mission(map_mission(**changes), Path("pond.toml"))
