"""Exploration of towns: how fast teams see all of the surface that can be seen (Renzaglia 2020, figure 11)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from missions.bench.pool import measure_all
from missions.bench.results import Row, save_rows
from missions.bench.urban_run import UrbanExploration, UrbanParams, UrbanRun
from sim_bridge.observable import observable_of
from sim_bridge.town import draw_town
from vehicle_agent.domain.ray_fan import down_looking_fan
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.mission.terrain import TownTerrain

SIDE_M, HEIGHT_M, VOXEL_M = 100.0, 30.0, 1.0
TOWN_SPAWN_KEY = 3000
CURVE_S = 10
"""Between two points of the curves in the rows."""
NEARLY_ALL = 0.99
"""Share of the observable surface after which the tail of an exploration begins."""


@dataclass(frozen=True, slots=True)
class Case:
    """One team in one town."""

    seed: int
    environment: int
    vehicles: int


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of a case; `surface_voxels` is the size of the observable surface."""

    case: Case
    run: UrbanRun
    surface_voxels: int


def bench_urban(environments: int, vehicles: Sequence[int], seed: int, json_file: Path | None) -> int:
    """Measure, print a table, write what was asked for; the exit code: 130 when Ctrl-C came before the end."""
    cases = [Case(seed, environment, size) for environment in range(environments) for size in vehicles]
    outcomes, interrupted = measure_all(cases, measure, "urban")
    print(table(outcomes, vehicles))
    if json_file is not None:
        save_rows(json_file, "urban", seed, [row(outcome) for outcome in outcomes])
    return 130 if interrupted else 0


def measure(case: Case) -> Outcome:
    """Let one team explore one town."""
    params = UrbanParams()
    grid = VoxelGrid(0.0, 0.0, -VOXEL_M, VOXEL_M, round(SIDE_M), round(SIDE_M), round(HEIGHT_M))
    rng = np.random.default_rng(np.random.SeedSequence(case.seed, spawn_key=(TOWN_SPAWN_KEY, case.environment)))
    solid = draw_town(grid, TownTerrain(), rng)
    fan = down_looking_fan(params.range_m / VOXEL_M)
    ceiling = grid.voxel_of((0.5, 0.5, params.ceiling_m))[2]
    starts = [(4 + 4 * (place % 3), 4 + 4 * (place // 3), ceiling) for place in range(case.vehicles)]
    truth = observable_of(solid, ceiling, starts[0], fan)
    exploration = UrbanExploration(grid, solid, truth, starts, fan, params)
    return Outcome(case, exploration.run(), int(truth.surface.sum()))


def row(outcome: Outcome) -> Row:
    """One team in one town as figures."""
    run, vehicle_s = outcome.run, outcome.case.vehicles * max(1, len(outcome.run.observed_share) - 1)
    return {
        "environment": outcome.case.environment,
        "vehicles": outcome.case.vehicles,
        "surface_voxels": outcome.surface_voxels,
        "observed_share": run.observed_share[-1],
        "time_s": len(run.observed_share) - 1,
        "finished": run.finished_s is not None,
        "seen_99_s": run.seen_s(NEARLY_ALL),
        "idle_share": round(run.idle_s / vehicle_s, 4),
        "held_up_share": round(run.held_up_s / vehicle_s, 4),
        "closest_m": round(run.closest_m, 2),
        "bytes_per_vehicle_per_s": round(run.bytes_told / outcome.case.vehicles / len(run.observed_share), 1),
        "curve_s": CURVE_S,
        "curve": [round(share, 4) for share in run.observed_share[::CURVE_S]],
    }


def table(outcomes: Sequence[Outcome], vehicles: Sequence[int]) -> str:
    """Means by team size, and how much less time larger teams need in the same towns."""
    lines = []
    times: dict[int, dict[int, int]] = {size: {} for size in vehicles}
    for size in vehicles:
        mine = [outcome for outcome in outcomes if outcome.case.vehicles == size]
        if not mine:
            continue
        times[size] = {outcome.case.environment: len(outcome.run.observed_share) - 1 for outcome in mine}
        taken = np.array(list(times[size].values()))
        worst = min(outcome.run.observed_share[-1] for outcome in mine)
        nearest_m = min(outcome.run.closest_m for outcome in mine)
        told = np.mean([row(outcome)["bytes_per_vehicle_per_s"] for outcome in mine])
        lines.append(
            f"{size} vehicles: {taken.mean():6.1f} s on average, sd {taken.std():5.1f}, {len(mine)} towns; "
            f"least observed {100 * worst:.2f} % of the observable surface; closest {nearest_m:.1f} m; "
            f"map messages {told:.0f} B/s per vehicle"
        )
        lines.append("  " + losses([outcome.run for outcome in mine], size))
    for fewer, more in pairwise(vehicles):
        both = sorted(times[fewer].keys() & times[more].keys())
        if both:
            ratio = sum(times[more][town] for town in both) / sum(times[fewer][town] for town in both)
            lines.append(
                f"{more} need {100 * (1.0 - ratio):.1f} % less time than {fewer}: "
                f"parallel efficiency {100 * fewer / (more * ratio):.1f} %, "
                f"with 100 % it would be {100 * (1.0 - fewer / more):.1f} % less"
            )
    return "\n".join(lines) if lines else "nothing was finished"


def losses(runs: Sequence[UrbanRun], vehicles: int) -> str:
    """Where a team's time went, on average over its runs."""
    vehicle_s = vehicles * sum(len(run.observed_share) - 1 for run in runs)
    idle, held_up = sum(run.idle_s for run in runs) / vehicle_s, sum(run.held_up_s for run in runs) / vehicle_s
    text = f"without a goal {100 * idle:.1f} % of their time, held up {100 * held_up:.1f} %"
    seen = [(run.seen_s(NEARLY_ALL), len(run.observed_share) - 1) for run in runs]
    reached = [(nearly_s, end_s - nearly_s) for nearly_s, end_s in seen if nearly_s is not None]
    if reached:
        nearly_s, rest_s = np.mean(reached, axis=0)
        text += f"; {100 * NEARLY_ALL:.0f} % seen after {nearly_s:.1f} s, the rest took {rest_s:.1f} s"
    return text
