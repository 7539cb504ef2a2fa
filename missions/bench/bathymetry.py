"""Compares a fleet that looks where it pays with the usual practice on two kinds of sea floor (Kapoutsis 2015, 7)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from missions.bench.bathymetry_run import (
    MORE_SAMPLES,
    STEPS,
    VEHICLES,
    Outcome,
    survey_by_fleet,
    survey_by_lines,
)
from missions.bench.pool import measure_all
from missions.bench.results import Row, save_rows
from missions.terrain.sea_floor import FloorName
from vehicle_agent.planning.mapping.survey import SurveyParams

FLOORS: tuple[FloorName, ...] = ("sharp", "slope")
SAMPLES = VEHICLES * STEPS
FLEET = SurveyParams(way_m=1_000.0, nodes=6_400, part_m=250.0, step_m=2.0, rounds=150)
"""How the fleet surveys; it has time to think between two soundings."""
INFORMED = replace(FLEET, part_m=1_000.0)
"""The yardstick knows how rough the floor is, and needs no second thought."""


@dataclass(frozen=True, slots=True)
class Case:
    """One floor of one seed, for all methods."""

    floor: FloorName
    seed: int


def measure(case: Case) -> list[Outcome]:
    """Survey one floor by every method."""
    return [
        survey_by_fleet(case.floor, case.seed, FLEET),
        survey_by_fleet(case.floor, case.seed, INFORMED, informed=True),
        survey_by_lines(case.floor, case.seed, SAMPLES),
        survey_by_lines(case.floor, case.seed, round(MORE_SAMPLES * SAMPLES)),
    ]


def rows_of(outcomes: list[Outcome]) -> list[Row]:
    """A row per floor, method and number of samples; `error_ratio` is the fleet's error over this row's, paired."""
    rows: list[Row] = []
    for floor in FLOORS:
        fleet = {o.seed: o.l2_error for o in outcomes if o.floor == floor and o.method == "fleet"}
        kinds = sorted({(o.method, o.samples) for o in outcomes if o.floor == floor})
        for method, samples in kinds:
            alike = [o for o in outcomes if (o.floor, o.method, o.samples) == (floor, method, samples)]
            errors = np.array([o.l2_error for o in alike])
            rows.append(
                {
                    "map": floor,
                    "method": method,
                    "samples": samples,
                    "seeds": len(alike),
                    "l2_error": round(float(errors.mean()), 3),
                    "l2_error_sd": round(float(errors.std()), 3),
                    "time_s": round(float(np.mean([o.time_s for o in alike])), 1),
                    "error_ratio": round(float(np.mean([fleet[o.seed] / o.l2_error for o in alike])), 3),
                }
            )
    return rows


def table(rows: list[Row]) -> str:
    """The rows for people."""
    lines = [f"{'map':<6} {'method':<10} {'samples':>7} {'seeds':>5} {'L2 error':>16} {'time s':>8} {'fleet/this':>10}"]
    lines += [
        f"{row['map']:<6} {row['method']:<10} {row['samples']:>7} {row['seeds']:>5} "
        f"{row['l2_error']:>8.2f} sd {row['l2_error_sd']:>4.2f} {row['time_s']:>8.0f} {row['error_ratio']:>10.2f}"
        for row in rows
    ]
    return "\n".join(lines)


def bench_bathymetry(seeds: int, seed: int, json_file: Path | None) -> int:
    """Measure, print a table, write what was asked for; the exit code: 130 when Ctrl-C came before the end."""
    cases = [Case(floor, seed + number) for number in range(seeds) for floor in FLOORS]
    results, interrupted = measure_all(cases, measure, "bathymetry")
    rows = rows_of([outcome for outcomes in results for outcome in outcomes])
    print(table(rows))
    if json_file is not None:
        save_rows(json_file, "bathymetry", seed, rows)
    return 130 if interrupted else 0
