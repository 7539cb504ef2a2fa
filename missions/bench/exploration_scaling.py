"""`missions bench exploration --scaling`: planning time by size of team and map, beside that of closest frontier."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from missions.bench.exploration import HILLS, Job, run_job
from missions.bench.exploration_run import ExplorationRun, TeamParams
from missions.bench.hills import HillsParams
from missions.bench.pool import measure_all
from missions.bench.results import Row, save_rows
from vehicle_agent.domain import kernels
from vehicle_agent.mission.tasks import DEFAULT_PLANNER, PlannerName

RIVAL: PlannerName = "closest-frontier"
STEPS = 60
"""A run ends after so many steps, or when all is seen; its first plans count."""


@dataclass(frozen=True, slots=True)
class Size:
    """One team on one map.

    Attributes
    ----------
    vehicles
        Size of the team.
    cells_per_side
        Of the square map, whose cells are those of the exploration bench and whose hills lie as densely as there.
    """

    vehicles: int
    cells_per_side: int

    @property
    def hills(self) -> HillsParams:
        scale = self.cells_per_side * HILLS.cell_m / HILLS.side_m
        return replace(HILLS, side_m=scale * HILLS.side_m, peaks=max(1, round(scale**2 * HILLS.peaks)))


SIZES = (Size(2, 100), Size(8, 100), Size(32, 100), Size(64, 100), Size(8, 300), Size(8, 1000))


def bench_scaling(
    environments: int, range_m: float, step_m: float, seed: int, json_file: Path | None,
    sizes: Sequence[Size] = SIZES, steps: int = STEPS,
) -> int:  # fmt: skip
    """Run the bench and print its table; returns the exit code.

    One run after the other, each planner in turn on the same hills and all sizes before the next hills, so that none
    has the machine for itself when it is fast.
    """
    kernels.warm_up()
    team = TeamParams(range_m=range_m, step_m=step_m)
    jobs = [
        Job(planner, environment, seed, size.vehicles, team, None, size.hills, steps)
        for environment in range(environments)
        for size in sizes
        for planner in (DEFAULT_PLANNER, RIVAL)
    ]
    done, interrupted = measure_all(jobs, run_job, "timing plans", processes=1)
    rows = []
    print(f"milliseconds per decision within the first {steps} steps, {environments} environments, seed {seed}")
    print("planner           vehicles  cells per side  decisions   median     mean      p99  median / rival's")
    for size in sizes:
        of_size = [(job, run) for job, run in done if (job.vehicles, job.hills) == (size.vehicles, size.hills)]
        medians = {}
        for planner in (DEFAULT_PLANNER, RIVAL):
            runs = [run for job, run in of_size if job.planner == planner]
            if runs:
                rows.append(row(planner, size, runs))
                medians[planner] = rows[-1]["plan_ms_median"]
        for figures in rows[len(rows) - len(medians) :]:
            print_row(figures, medians.get(RIVAL))
    if json_file is not None:
        save_rows(json_file, "exploration-scaling", seed, rows)
    return 130 if interrupted else 0


def row(planner: PlannerName, size: Size, runs: Sequence[ExplorationRun]) -> Row:
    """Planning time of one planner over all environments of one size."""
    asks = np.concatenate([run.ask_ms for run in runs])
    return {
        "planner": planner,
        "default": planner == DEFAULT_PLANNER,
        "vehicles": size.vehicles,
        "cells_per_side": size.cells_per_side,
        "environments": len(runs),
        "decisions": len(asks),
        "plan_ms_median": float(np.median(asks)),
        "plan_ms_mean": float(np.mean(asks)),
        "plan_ms_p99": float(np.percentile(asks, 99)),
    }


def print_row(figures: Row, rival_median_ms: float | None) -> None:
    """One planner's line for one size."""
    print(
        f"{figures['planner']:17s} {figures['vehicles']:8d} {figures['cells_per_side']:15d} {figures['decisions']:10d} "
        f"{figures['plan_ms_median']:8.3f} {figures['plan_ms_mean']:8.3f} {figures['plan_ms_p99']:8.3f}  "
        + (f"{figures['plan_ms_median'] / rival_median_ms:15.3f}" if rival_median_ms else "")
    )
