"""`missions bench exploration`: steps until random hills are known, every planner on the same hills."""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from missions.bench.exploration_run import ExplorationRun, TeamParams, explore
from missions.bench.hills import HillsParams, draw_hills
from missions.bench.pool import measure_all
from missions.bench.results import Row, save_rows
from vehicle_agent.domain import kernels
from vehicle_agent.mission.tasks import PlannerName
from vehicle_agent.planning.choose import make_planner

PLANNERS: tuple[PlannerName, ...] = ("tours", "lanes", "claims", "fcao", "closest-frontier", "greedy")
HILLS = HillsParams()
LATTICE_M = 4.0
MAX_STEPS = 1_000


@dataclass(frozen=True, slots=True)
class Job:
    """One planner in one environment."""

    planner: PlannerName
    environment: int
    seed: int
    vehicles: int
    team: TeamParams
    export: Path | None
    hills: HillsParams = HILLS
    max_steps: int = MAX_STEPS


def starts(vehicles: int) -> list[tuple[float, float]]:
    """A square lattice in the south-western corner, east and north in ENU metres."""
    side = math.ceil(math.sqrt(vehicles))
    return [
        (0.5 * LATTICE_M + LATTICE_M * (n % side), 0.5 * LATTICE_M + LATTICE_M * (n // side)) for n in range(vehicles)
    ]


def least_steps(vehicles: int, team: TeamParams) -> float:
    """What hardly any team beats: the way to the farthest corner, or the area over what all can sweep."""
    farthest_m = min(math.dist(start, (HILLS.side_m, HILLS.side_m)) for start in starts(vehicles))
    sweep_m2 = 2.0 * team.range_m * team.step_m * vehicles
    return max(farthest_m / team.step_m, HILLS.side_m**2 / sweep_m2)


def run_job(job: Job) -> tuple[Job, ExplorationRun]:
    """Run one planner in one environment, both drawn from the seed; export what was asked for."""
    kernels.warm_up()  # what a process loads at its first call is no planning time
    grid = job.hills.grid
    hills = np.random.default_rng(np.random.SeedSequence(job.seed, spawn_key=(job.environment,)))
    elevation_m = draw_hills(job.hills, hills)
    planners = [
        make_planner(
            job.planner,
            grid,
            job.team.range_m,
            job.team.step_m,
            None,
            np.random.default_rng(np.random.SeedSequence(job.seed, spawn_key=(job.environment, 1 + index))),
        )
        for index in range(job.vehicles)
    ]
    run = explore(grid, elevation_m, starts(job.vehicles), planners, job.team, job.max_steps)
    if job.export is not None:
        np.savez_compressed(job.export / f"env_{job.environment:03d}.npz", elevation_m=elevation_m, cell_m=grid.cell_m)
        np.savez_compressed(
            job.export / f"run_{job.environment:03d}_{job.planner}.npz",
            positions_enu_m=run.positions_enu_m,
            range_m=job.team.range_m,
        )
    return job, run


def bench_exploration(
    environments: int, vehicles: int, range_m: float, step_m: float, seed: int, json_file: Path | None,
    export: Path | None,
) -> int:  # fmt: skip
    """Run the bench and print its table; returns the exit code."""
    if export is not None:
        export.mkdir(parents=True, exist_ok=True)
    kernels.warm_up()
    team = TeamParams(range_m=range_m, step_m=step_m)
    jobs = [
        Job(planner, environment, seed, vehicles, team, export)
        for environment in range(environments)
        for planner in PLANNERS
    ]
    done, interrupted = measure_all(jobs, run_job, "exploring")
    rows = []
    for planner in PLANNERS:
        runs = [run for job, run in done if job.planner == planner]
        if runs:
            rows.append(row(planner, runs, vehicles, team))
            print_row(rows[-1], len(runs), sum(not run.finished for run in runs))
    if json_file is not None:
        save_rows(json_file, "exploration", seed, rows)
    return 130 if interrupted else 0


def row(planner: PlannerName, runs: list[ExplorationRun], vehicles: int, team: TeamParams) -> Row:
    """Figures of one planner over all environments; a run that did not finish counts with the steps it had."""
    steps = [run.steps for run in runs]
    asks = np.concatenate([run.ask_ms for run in runs])
    return {
        "planner": planner,
        "steps_mean": statistics.fmean(steps),
        "steps_sd": statistics.pstdev(steps),
        "steps_over_bound": statistics.fmean(steps) / least_steps(vehicles, team),
        "step_ms_median": float(np.median(asks)),
        "step_ms_p99": float(np.percentile(asks, 99)),
        "bytes_per_vehicle_per_step": sum(run.bytes_sent for run in runs) / (vehicles * sum(steps)),
        "overlap": statistics.fmean(run.overlap for run in runs),
    }


def print_row(figures: Row, runs: int, unfinished: int) -> None:
    """One planner's line."""
    print(
        f"{figures['planner']:17s} steps {figures['steps_mean']:6.1f} +- {figures['steps_sd']:5.1f}, "
        f"{figures['steps_over_bound']:.2f} x bound; step {figures['step_ms_median']:.2f} ms, "
        f"p99 {figures['step_ms_p99']:.2f} ms; {figures['bytes_per_vehicle_per_step']:.0f} bytes per vehicle and step; "
        f"overlap {figures['overlap']:.2f}; {runs} runs" + (f", {unfinished} unfinished" if unfinished else "")
    )
