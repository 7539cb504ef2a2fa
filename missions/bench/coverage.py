"""`missions bench coverage`: static coverage of random hills, the paper's way and ours, against an informed optimum."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from missions.bench.coverage_run import CoverageRun, CoverageTeam, cover
from missions.bench.coverage_starts import STARTS, Start, draw_start
from missions.bench.hills import HillsParams, draw_hills
from missions.bench.informed import informed_optimum
from missions.bench.pool import measure_all
from missions.bench.results import Row, save_rows
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.mission.load import MissionError
from vehicle_agent.planning.cao import CaoParams
from vehicle_agent.planning.coverage import CaoCoverage, StepSchedule
from vehicle_agent.planning.interface import Planner
from vehicle_agent.planning.stations import Stations

HILLS = HillsParams(side_m=100.0, cell_m=1.0, peaks=7, height_m=(5.0, 25.0), sigma_m=12.0)
TEAM = CoverageTeam()
ITERATIONS = 500
CAO_FIRST_STEP_M = 1.0
DEFAULT = "stations"
PLANNERS = ("cao", "stations")
OPTIMUM = "informed-optimum"
ANY_START = "any"


@dataclass(frozen=True, slots=True)
class Case:
    """One environment with one team size: every start and planner, and the optimum."""

    seed: int
    environment: int
    vehicles: int
    export: Path | None


@dataclass(frozen=True, slots=True)
class Outcome:
    """What one planner reached from one start in one environment; `best` is over the iterations."""

    vehicles: int
    start: str
    planner: str
    initial: float
    final: float
    best: float
    of_optimum: float
    step_ms: tuple[float, ...]


def bench_coverage(
    environments: int, vehicles: Sequence[int], seed: int, json_file: Path | None, export: Path | None
) -> int:
    """Measure, print a table, write what was asked for; the exit code: 130 when Ctrl-C came before the end."""
    if export is not None:
        _prepare(export, environments, seed)
    largest_first = sorted(vehicles, reverse=True)  # so that no core is left with a long case at the end
    cases = [Case(seed, environment, size, export) for size in largest_first for environment in range(environments)]
    results, interrupted = measure_all(cases, measure, "coverage")
    outcomes = [outcome for result in results for outcome in result]
    rows = rows_of(sorted(outcomes, key=lambda outcome: vehicles.index(outcome.vehicles)))
    print(table(rows))
    if json_file is not None:
        save_rows(json_file, "coverage", seed, rows)
    return 130 if interrupted else 0


def measure(case: Case) -> list[Outcome]:
    """All outcomes of one case."""
    grid = HILLS.grid
    elevation_m = environment(case.seed, case.environment)
    began_s = time.perf_counter()
    best, places = informed_optimum(grid, elevation_m, TEAM, case.vehicles, _rng(case, "optimum"))
    took_ms = 1e3 * (time.perf_counter() - began_s)
    outcomes = [Outcome(case.vehicles, ANY_START, OPTIMUM, best, best, best, 1.0, (took_ms,))]
    _export(case, OPTIMUM, ANY_START, places[None])
    for start in STARTS:
        starts = draw_start(start, grid, elevation_m, TEAM, case.vehicles, _rng(case, start))
        for planner in PLANNERS:
            planners = [make_planner(planner, _rng(case, start, planner, index)) for index in range(case.vehicles)]
            run = cover(grid, elevation_m, starts, planners, TEAM, ITERATIONS)
            outcomes.append(_outcome(case, start, planner, run, best))
            _export(case, planner, start, run.positions_enu_m)
    return outcomes


def environment(seed: int, number: int) -> FloatArray:
    """The surface of one environment: (columns, rows) float64, ENU z in metres."""
    return draw_hills(HILLS, np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(number,))))


def make_planner(name: str, rng: np.random.Generator) -> Planner:
    """One vehicle's planner by the name that it has in the rows."""
    match name:
        case "cao":
            schedule = StepSchedule(CAO_FIRST_STEP_M)
            return CaoCoverage(CaoParams(CAO_FIRST_STEP_M), rng, schedule)
        case "stations":
            return Stations(rng)
        case _:
            raise ValueError(f"there is no coverage planner '{name}'; choose {', '.join(PLANNERS)}")


def rows_of(outcomes: Sequence[Outcome]) -> list[Row]:
    """A row for every team size, start and planner, in that order."""
    rows = []
    order: dict[tuple[int, str, str], list[Outcome]] = {}
    for outcome in outcomes:
        order.setdefault((outcome.vehicles, outcome.start, outcome.planner), []).append(outcome)
    for (vehicles, start, planner), mine in order.items():
        row: Row = {"vehicles": vehicles, "start": start, "planner": planner, "default": planner == DEFAULT}
        for what in ("initial", "final", "best"):
            values = [float(getattr(outcome, what)) for outcome in mine]
            row[f"{what}_mean"], row[f"{what}_sd"] = float(np.mean(values)), float(np.std(values))
        row["of_optimum"] = float(np.mean([outcome.of_optimum for outcome in mine]))
        row["step_ms_median"] = float(np.median(np.concatenate([outcome.step_ms for outcome in mine])))
        rows.append(row)
    return rows


def table(rows: Sequence[Row]) -> str:
    """The rows for people."""
    lines = ["vehicles  start   planner             initial        final          best           of optimum  step ms"]
    for row in rows:
        figures = "  ".join(f"{row[f'{w}_mean']:.3f} ±{row[f'{w}_sd']:.3f} " for w in ("initial", "final", "best"))
        mark = "*" if row["default"] else " "
        lines.append(
            f"{row['vehicles']:8d}  {row['start']:<7} {row['planner']:<17}{mark} {figures} "
            f"{row['of_optimum']:9.3f}  {row['step_ms_median']:8.2f}"
        )
    lines.append(
        "* the default; final is after the last iteration, best over all; the optimum's time is a whole search"
    )
    return "\n".join(lines)


def _outcome(case: Case, start: Start, planner: str, run: CoverageRun, optimum: float) -> Outcome:
    curve = run.covered_fraction
    return Outcome(
        case.vehicles,
        start,
        planner,
        float(curve[0]),
        float(curve[-1]),
        float(curve.max()),
        float(curve[-1] / optimum),
        tuple(run.ask_ms),
    )


def _rng(case: Case, *what: Any) -> np.random.Generator:
    """A generator for one purpose in one case: nothing added elsewhere changes its draws."""
    words = [int.from_bytes(str(word).encode(), "little") for word in what]
    return np.random.default_rng([case.seed, case.environment, case.vehicles, *words])


def _prepare(folder: Path, environments: int, seed: int) -> None:
    """Make the export folder and write the environments."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for number in range(environments):
            elevation_m = environment(seed, number)
            np.savez(folder / f"env_{number:03d}.npz", elevation_m=elevation_m, cell_m=np.float64(HILLS.cell_m))
    except OSError as error:
        raise MissionError(
            f"{folder}: cannot be written ({error.strerror}); choose another folder with --export"
        ) from None


def _export(case: Case, planner: str, start: str, positions_enu_m: FloatArray) -> None:
    if case.export is not None:
        name = f"run_{case.environment:03d}_{planner}-{start}-{case.vehicles}.npz"
        np.savez(case.export / name, positions_enu_m=positions_enu_m, range_m=np.float64(TEAM.range_m))
