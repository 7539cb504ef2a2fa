"""Small missions for tests of the simulator."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec

from vehicle_agent.mission.load import MissionPlan, plan_mission
from vehicle_agent.mission.model import Mission

GROUND_M = 50.0
"""Of the level terrain, ENU z: 350 m above the sea, datum at 300 m."""


def sim_plan(
    source: Path = Path("mission.toml"), vehicles: int = 1, team: list[dict[str, Any]] | None = None, **changes: Any
) -> MissionPlan:
    """A checked mission over one square kilometre of level ground; `changes` replaces whole tables."""
    content: dict[str, Any] = {
        "format": 1,
        "name": "sim-test",
        "seed": 3,
        "datum": {"latitude_deg": 36.57, "longitude_deg": -84.27, "altitude_amsl_m": 300.0},
        "area": {"cell_m": 20.0, "rectangle_enu_m": [0.0, 0.0, 1000.0, 1000.0]},
        "terrain": {"kind": "flat", "elevation_amsl_m": 300.0 + GROUND_M},
        "task": {"kind": "explore"},
        "vehicles": team
        or [
            {
                "name": f"copter-{number}",
                "start_enu_m": [200.0 + 40.0 * number, 200.0],
                "speed_m_s": 15.0,
                "sensor": {"kind": "range", "range_m": 200.0},
                "min_above_terrain_m": 30.0,
                "max_above_terrain_m": 150.0,
            }
            for number in range(vehicles)
        ],
        "simulation": {"ready_after_s": 5.0},
    }
    content.update(changes)
    return plan_mission(msgspec.convert(content, Mission), source)
