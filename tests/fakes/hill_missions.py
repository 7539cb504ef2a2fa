"""Small missions over random hills for lock-step runs."""

from __future__ import annotations

from typing import Any

import msgspec

from vehicle_agent.mission.load import MissionPlan, plan_mission
from vehicle_agent.mission.model import Mission


def hill_plan(
    seed: int = 1,
    vehicles: int = 3,
    planner: str = "tours",
    team: list[dict[str, Any]] | None = None,
    **changes: Any,
) -> MissionPlan:
    """36 ha of hills up to 80 m and copters that see 120 m; `changes` replaces whole tables."""
    content: dict[str, Any] = {
        "format": 1,
        "name": "hills",
        "seed": seed,
        "datum": {"latitude_deg": 45.0, "longitude_deg": 10.0},
        "area": {"cell_m": 10.0, "rectangle_enu_m": [0.0, 0.0, 600.0, 600.0], "fence_margin_m": 5.0},
        "terrain": {"kind": "gaussians", "peaks": 6, "height_m": [20.0, 80.0], "sigma_m": 80.0},
        "task": {"kind": "explore", "planner": planner, "step_m": 60.0},
        "vehicles": team
        or [
            {
                "name": f"copter-{number}",
                "start_enu_m": [60.0 + 40.0 * number, 60.0],
                "speed_m_s": 12.0,
                "sensor": {"kind": "range", "range_m": 120.0},
                "min_above_terrain_m": 30.0,
                "max_above_terrain_m": 90.0,
            }
            for number in range(vehicles)
        ],
        "stop": {"observed_fraction": 0.99, "time_limit_s": 600.0},
    }
    content.update(changes)
    return plan_mission(msgspec.convert(content, Mission))
