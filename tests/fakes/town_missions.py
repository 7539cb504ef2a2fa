"""Small missions in small towns."""

from __future__ import annotations

from typing import Any

import msgspec

from vehicle_agent.mission.load import MissionPlan, plan_mission
from vehicle_agent.mission.model import Mission


def town_content(vehicles: int = 2, **changes: Any) -> dict[str, Any]:
    """What a mission file would hold: a few houses on 40 m x 40 m; `changes` replaces whole tables."""
    content: dict[str, Any] = {
        "format": 1,
        "name": "hamlet",
        "seed": 2,
        "datum": {"latitude_deg": 45.0, "longitude_deg": 10.0},
        "area": {"cell_m": 1.0, "rectangle_enu_m": [0.0, 0.0, 40.0, 40.0], "fence_margin_m": 1.0, "up_m": [-1.0, 17.0]},
        "terrain": {
            "kind": "town",
            "block_m": 20.0,
            "street_m": [7.0, 9.0],
            "height_m": [6.0, 10.0],
            "overhang_share": 1.0,
            "passage_share": 1.0,
        },
        "task": {"kind": "explore", "planner": "tours", "step_m": 30.0},
        "vehicles": [
            {
                "name": f"copter-{number}",
                "start_enu_m": [4.0 + 6.0 * number, 4.0],
                "speed_m_s": 3.0,
                "climb_m_s": 2.0,
                "sensor": {"kind": "half-sphere", "range_m": 10.0},
                "min_above_terrain_m": 1.5,
                "max_above_terrain_m": 13.5,
            }
            for number in range(vehicles)
        ],
        "safety": {"separation_m": 2.5},
        "stop": {"time_limit_s": 600.0},
    }
    content.update(changes)
    return content


def town_mission(vehicles: int = 2, **changes: Any) -> Mission:
    return msgspec.convert(town_content(vehicles, **changes), Mission)


def town_plan(vehicles: int = 2, **changes: Any) -> MissionPlan:
    return plan_mission(town_mission(vehicles, **changes))
