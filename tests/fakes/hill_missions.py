"""Small missions over random hills."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import msgspec

from vehicle_agent.mission.load import MissionPlan, plan_mission
from vehicle_agent.mission.model import Mission


def copters(
    starts_en_m: Sequence[tuple[float, float]], names: Sequence[str] = (), range_m: float = 120.0, **changes: Any
) -> list[dict[str, Any]]:
    """The tables of a team of copters; `changes` replaces values in all of them."""
    return [
        {
            "name": names[number] if names else f"copter-{number}",
            "start_enu_m": list(start),
            "speed_m_s": 12.0,
            "sensor": {"kind": "range", "range_m": range_m},
            "min_above_terrain_m": 30.0,
            "max_above_terrain_m": 90.0,
            **changes,
        }
        for number, start in enumerate(starts_en_m)
    ]


def hill_mission(
    seed: int = 1,
    vehicles: int = 3,
    planner: str = "tours",
    team: list[dict[str, Any]] | None = None,
    **changes: Any,
) -> Mission:
    """36 ha of hills up to 80 m and copters that see 120 m; `changes` replaces whole tables."""
    content: dict[str, Any] = {
        "format": 1,
        "name": "hills",
        "seed": seed,
        "datum": {"latitude_deg": 45.0, "longitude_deg": 10.0},
        "area": {"cell_m": 10.0, "rectangle_enu_m": [0.0, 0.0, 600.0, 600.0], "fence_margin_m": 5.0},
        "terrain": {"kind": "gaussians", "peaks": 6, "height_m": [20.0, 80.0], "sigma_m": 80.0},
        "task": {"kind": "explore", "planner": planner, "step_m": 60.0},
        "vehicles": team or copters([(60.0 + 40.0 * number, 60.0) for number in range(vehicles)]),
        "stop": {"observed_fraction": 0.99, "time_limit_s": 600.0},
    }
    return msgspec.convert(content | changes, Mission)


def hill_plan(
    seed: int = 1,
    vehicles: int = 3,
    planner: str = "tours",
    team: list[dict[str, Any]] | None = None,
    **changes: Any,
) -> MissionPlan:
    """`hill_mission`, checked."""
    return plan_mission(hill_mission(seed, vehicles, planner, team, **changes))
