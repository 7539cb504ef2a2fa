"""How the harbour's map grows on board of each vehicle while the survey goes on, by how much its radio carries."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from missions.bench.pool import measure_all
from missions.bench.results import Row, save_rows
from missions.catalogue import load_named_mission
from missions.depth_map import draw_depth_map
from missions.lockstep import simulate
from sim_bridge.world import World
from vehicle_agent.domain.landmark_atlas import LandmarkAtlas
from vehicle_agent.domain.team_map import TeamMap
from vehicle_agent.mission.model import RadioTable

PERIOD_S = 120.0

RADIOS: dict[str, Callable[[RadioTable], RadioTable]] = {
    "1000 bytes per 2 s, all heard": lambda radio: msgspec.structs.replace(
        radio, packet_bytes=None, loss=0.0, delay_s=0.0
    ),
    "200 bytes per 10 s, as it is": lambda radio: radio,
    "the same, 30 % loss, 2 s late": lambda radio: msgspec.structs.replace(radio, loss=0.3, delay_s=2.0),
    "200 bytes per 30 s, 30 % loss": lambda radio: msgspec.structs.replace(
        radio, packet_period_s=30.0, loss=0.3, delay_s=2.0
    ),
    "one packet of 1000 heard": lambda radio: msgspec.structs.replace(radio, loss=0.999),
}


@dataclass(frozen=True, slots=True)
class Case:
    """One flight."""

    name: str
    seed: int


@dataclass(frozen=True, slots=True)
class Outcome:
    """The errors of one flight's maps.

    Attributes
    ----------
    errors_m
        Root mean square error of the map on board, the mean of all vehicles, after each `PERIOD_S`.
    team_error_m
        Of all that they measured together, at the end.
    """

    case: str
    errors_m: tuple[float, ...]
    team_error_m: float


def measure(case: Case) -> Outcome:
    """Simulate the harbour mission with one radio, and draw what each vehicle knows again and again."""
    plan = load_named_mission(
        "harbour",
        lambda mission: msgspec.structs.replace(mission, seed=case.seed, radio=RADIOS[case.name](mission.radio)),
    )
    world, errors_m = World.of(plan), list[float]()

    def draw(time_s: float, maps: Sequence[TeamMap]) -> None:
        if time_s < PERIOD_S * (len(errors_m) + 1) or time_s > plan.mission.stop.time_limit_s + PERIOD_S / 2:
            return
        drawn = [draw_depth_map(plan, known, world.elevation_m) for known in maps if isinstance(known, LandmarkAtlas)]
        found = [each.rms_error_m for each in drawn if each is not None and each.rms_error_m is not None]
        errors_m.append(float(np.mean(found)) if found else np.nan)

    result = simulate(plan, world, watch=draw)
    team = result.depth_map
    return Outcome(case.name, tuple(errors_m), np.nan if team is None or team.rms_error_m is None else team.rms_error_m)


def rows_of(outcomes: Sequence[Outcome]) -> list[Row]:
    """A row per radio and time, and one of what the team holds together at the end (`minutes` None)."""
    rows: list[Row] = []
    for name in RADIOS:
        alike = [outcome for outcome in outcomes if outcome.case == name]
        if not alike:
            continue
        periods = min(len(outcome.errors_m) for outcome in alike)
        errors = {
            round(PERIOD_S * (place + 1) / 60.0): [each.errors_m[place] for each in alike] for place in range(periods)
        }
        for minutes, errors_m in [*errors.items(), (None, [each.team_error_m for each in alike])]:
            error_m, sd_m = round(float(np.mean(errors_m)), 3), round(float(np.std(errors_m)), 3)
            rows.append(
                {"radio": name, "seeds": len(alike), "minutes": minutes, "map_error_m": error_m, "map_error_sd_m": sd_m}
            )
    return rows


def table(rows: Sequence[Row]) -> str:
    """The rows for people: a line per radio."""
    times = sorted({row["minutes"] for row in rows if row["minutes"] is not None})
    lines = [f"{'map error on board, m, after minutes':<36}" + "".join(f"{time:>7}" for time in times) + "   team"]
    for name in dict.fromkeys(row["radio"] for row in rows):
        errors_m = {row["minutes"]: row["map_error_m"] for row in rows if row["radio"] == name}
        told = "".join(f"{errors_m[time]:>7.2f}" if time in errors_m else f"{'':>7}" for time in times)
        lines.append(f"{name:<36}{told}{errors_m[None]:>7.2f}")
    return "\n".join(lines)


def bench_harbour_over_time(seeds: int, seed: int, json_file: Path | None) -> int:
    """Measure, print a table, write what was asked for; the exit code: 130 when Ctrl-C came before the end."""
    cases = [Case(name, seed + number) for number in range(seeds) for name in RADIOS]
    outcomes, interrupted = measure_all(cases, measure, "harbour")
    rows = rows_of(outcomes)
    print(table(rows))
    if json_file is not None:
        save_rows(json_file, "harbour-over-time", seed, rows)
    return 130 if interrupted else 0
