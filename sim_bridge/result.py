"""What the simulator leaves behind: the truth about every vehicle at the end of a run."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from sim_bridge.fleet import Fleet

FILE_NAME = "sim_result.json"


def result_of(fleet: Fleet, late_ticks: int) -> dict[str, Any]:
    """The run in plain values; `min_separation_m` is null when no two vehicles were ever in the air together."""
    separation_m = fleet.referee.min_separation_m
    return {
        "vehicles": {
            name: {
                "position_enu_m": [round(metres, 2) for metres in vehicle.true_position_enu_m],
                "armed": vehicle.armed,
                "has_flown": vehicle.has_flown,
                "crashed": vehicle.crashed,
                "mode": vehicle.mode.name,
                "distance_from_home_m": round(fleet.distance_from_home_m(vehicle.index), 2),
                "battery_fraction": round(vehicle.battery.remaining, 4),
            }
            for name, vehicle in zip(fleet.plan.vehicle_names, fleet.vehicles, strict=True)
        },
        "min_separation_m": round(separation_m, 2) if math.isfinite(separation_m) else None,
        "fence_breaches": fleet.referee.fence_breaches,
        "outside_s": round(fleet.referee.outside_s, 1),
        "crashes": fleet.crashes,
        "late_ticks": late_ticks,
        "simulated_s": round(fleet.time_s, 2),
    }


def write_result(folder: Path, result: dict[str, Any]) -> Path:
    """Write `sim_result.json` whole or not at all."""
    path = folder / FILE_NAME
    partial = path.with_suffix(".json.part")
    partial.write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
    partial.replace(path)
    return path
