"""What the harbour survey's map suffers from a poorer radio and from positions that no fix mends, and what helps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from missions.bench.pool import measure_all
from missions.bench.results import Row, save_rows
from missions.catalogue import load_named_mission
from missions.lockstep import simulate
from vehicle_agent.mission.model import Mission
from vehicle_agent.mission.tasks import MapTask

POOR_LOSS, POOR_DELAY_S = 0.3, 2.0


def _changed(mission: Mission, loss: float | None = None, delay_s: float | None = None, **task: object) -> Mission:
    assert isinstance(mission.task, MapTask)
    radio = mission.radio
    if loss is not None and delay_s is not None:
        radio = msgspec.structs.replace(radio, loss=loss, delay_s=delay_s)
    return msgspec.structs.replace(mission, radio=radio, task=msgspec.structs.replace(mission.task, **task))


def _down(mission: Mission) -> tuple[str, ...]:
    return (mission.vehicles[-1].name,)


CASES: dict[str, Callable[[Mission], Mission]] = {
    "as it is": _changed,
    "no loss, no delay": lambda mission: _changed(mission, 0.0, 0.0),
    "30 % loss, 2 s late": lambda mission: _changed(mission, POOR_LOSS, POOR_DELAY_S),
    "one stays down, ranges": lambda mission: _changed(mission, stays_down=_down(mission)),
    "one stays down, no ranges": lambda mission: _changed(mission, stays_down=_down(mission), ranging=False),
    "all stay down": lambda mission: _changed(mission, surfacing=False),
}


@dataclass(frozen=True, slots=True)
class Case:
    """One flight."""

    name: str
    seed: int


@dataclass(frozen=True, slots=True)
class Outcome:
    """What one flight left."""

    case: str
    map_error_m: float
    bytes_per_s: float


def measure(case: Case) -> Outcome:
    """Simulate the harbour mission, changed as the case says."""

    def change(mission: Mission) -> Mission:
        return CASES[case.name](msgspec.structs.replace(mission, seed=case.seed))

    result = simulate(load_named_mission("harbour", change))
    drawn = result.depth_map
    error_m = drawn.rms_error_m if drawn is not None and drawn.rms_error_m is not None else np.nan
    return Outcome(case.name, error_m, max(result.bytes_sent) / max(result.elapsed_s, 1.0))


def rows_of(outcomes: list[Outcome]) -> list[Row]:
    """A row per case."""
    rows: list[Row] = []
    for name in CASES:
        alike = [outcome for outcome in outcomes if outcome.case == name]
        if alike:
            errors_m = np.array([outcome.map_error_m for outcome in alike])
            rows.append(
                {
                    "case": name,
                    "seeds": len(alike),
                    "map_error_m": round(float(errors_m.mean()), 3),
                    "map_error_sd_m": round(float(errors_m.std()), 3),
                    "bytes_per_s": round(float(np.mean([outcome.bytes_per_s for outcome in alike])), 1),
                }
            )
    return rows


def table(rows: list[Row]) -> str:
    """The rows for people."""
    lines = [f"{'case':<26} {'seeds':>5} {'map error m':>17} {'bytes/s':>8}"]
    lines += [
        f"{row['case']:<26} {row['seeds']:>5} {row['map_error_m']:>9.3f} sd {row['map_error_sd_m']:>5.3f} "
        f"{row['bytes_per_s']:>8.1f}"
        for row in rows
    ]
    return "\n".join(lines)


def bench_harbour(seeds: int, seed: int, json_file: Path | None) -> int:
    """Measure, print a table, write what was asked for; the exit code: 130 when Ctrl-C came before the end."""
    cases = [Case(name, seed + number) for number in range(seeds) for name in CASES]
    outcomes, interrupted = measure_all(cases, measure, "harbour")
    rows = rows_of(outcomes)
    print(table(rows))
    if json_file is not None:
        save_rows(json_file, "harbour", seed, rows)
    return 130 if interrupted else 0
