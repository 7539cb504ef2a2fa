"""Simulates a mission with one seed or many, each in lock-step, and tells how it went."""

from __future__ import annotations

import multiprocessing
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from missions.catalogue import load_named_mission
from missions.covered import covers
from missions.depth_map import maps
from missions.flown import Changes
from missions.lockstep import LockstepResult, simulate
from missions.report import AIM_FRACTION
from sim_bridge.world import World
from vehicle_agent.mission.load import MissionError

MIN_SEPARATION_M = 5.0
"""Two vehicles in the air closer than this, or than half of `safety.separation_m`, count as a breach."""


@dataclass(frozen=True, slots=True)
class Line:
    """What is told of one seed among many; `map_error_m` where the mission maps."""

    seed: int
    observed_fraction: float
    elapsed_s: float
    min_separation_m: float
    fence_breaches: int
    good: bool
    map_error_m: float | None = None

    def __str__(self) -> str:
        mark = "" if self.good else "  <- below the bar"
        drawn = "" if self.map_error_m is None else f"map error {self.map_error_m:5.3f} m  "
        return (
            f"seed {self.seed:>6}  observed {100 * self.observed_fraction:6.2f} %  {drawn}{self.elapsed_s:7.0f} s  "
            f"closest {self.min_separation_m:7.1f} m  fence breaches {self.fence_breaches}{mark}"
        )


def simulate_seeds(mission: str, seeds: Sequence[int | None], planner: str | None, out: Path | None, jobs: int) -> int:
    """Simulate, save into `out` (a folder per seed when there are several), print; return the exit code.

    Raises MissionError as `load_mission` does, and when `out` cannot be written.
    """
    if len(seeds) == 1:
        result = _fly(mission, seeds[0], planner, out, _show_progress if sys.stderr.isatty() else None)
        print(_text(result, out))
        return int(not _is_good(result))
    print(f"{len(seeds)} seeds of {mission}")
    lines = []
    for line in _fly_all(mission, [seed for seed in seeds if seed is not None], planner, out, jobs):
        lines.append(line)
        print(line, flush=True)
    bad = sum(not line.good for line in lines)
    worst = min(line.observed_fraction for line in lines)
    nearest_m = min(line.min_separation_m for line in lines)
    print(
        f"worst: {100 * worst:.2f} % observed, {nearest_m:.1f} m apart, "
        f"{sum(line.fence_breaches for line in lines)} fence breaches; {len(lines) - bad} of {len(lines)} seeds good"
    )
    if errors_m := [line.map_error_m for line in lines if line.map_error_m is not None]:
        print(f"map error: mean {np.mean(errors_m):.3f} m, sd {np.std(errors_m):.3f} m, worst {max(errors_m):.3f} m")
    return int(bad > 0)


def _fly_all(mission: str, seeds: Sequence[int], planner: str | None, out: Path | None, jobs: int) -> Iterator[Line]:
    arguments = [(mission, seed, planner, None if out is None else out / f"seed-{seed}") for seed in seeds]
    if jobs == 1:
        yield from map(_line, arguments)
        return
    context = multiprocessing.get_context("spawn")  # a fork would copy other libraries' threads half
    with ProcessPoolExecutor(jobs, mp_context=context) as pool:
        yield from pool.map(_line, arguments)


def _line(arguments: tuple[str, int, str | None, Path | None]) -> Line:
    mission, seed, planner, out = arguments
    result = _fly(mission, seed, planner, out)
    return Line(
        seed=seed,
        observed_fraction=result.observed_fraction,
        elapsed_s=result.elapsed_s,
        min_separation_m=result.min_separation_m,
        fence_breaches=result.fence_breaches,
        good=_is_good(result),
        map_error_m=None if result.depth_map is None else result.depth_map.rms_error_m,
    )


def _fly(
    mission: str,
    seed: int | None,
    planner: str | None,
    out: Path | None,
    progress: Callable[[float, float], None] | None = None,
) -> LockstepResult:
    plan = load_named_mission(mission, Changes(seed=seed, planner=planner).apply)
    result = simulate(plan, World.of(plan), progress)
    if out is not None:
        try:
            result.save(out)
        except OSError as error:
            trouble = f"{out}: cannot be written ({error.strerror}); choose another folder with --out"
            raise MissionError(trouble) from None
    return result


def _show_progress(elapsed_s: float, observed_fraction: float) -> None:
    print(f"\r  {elapsed_s:6.0f} s  {100 * observed_fraction:6.2f} % observed ", end="", file=sys.stderr, flush=True)


def _text(result: LockstepResult, out: Path | None) -> str:
    """A result for people, a line per vehicle."""
    mission, figures = result.plan.mission, result.summary()
    observed_cells = max(1, int(np.count_nonzero(result.team_map.observed)))
    lines = [
        f"{mission.name}: {100 * result.observed_fraction:.2f} % of the reachable surface observed in "
        f"{result.elapsed_s:.0f} s of simulated time (planner {mission.task.planner}, seed {mission.seed})",
        f"  closest two vehicles {result.min_separation_m:.1f} m, {result.fence_breaches} fence breaches, "
        f"{sum(result.crashed)} crashes",
    ]
    if result.not_seen:
        lines.append(f"  not seen: {result.not_seen}")
    if covers(result.plan):
        lines.append(f"  {100 * result.covered_fraction:.2f} % of the area covered at once, from where the team stayed")
    if figures["map_error_m"] is not None:
        lines.append(f"  depth map with a root mean square error of {figures['map_error_m']:.2f} m")
    for name, vehicle in figures["vehicles"].items():
        lines.append(
            f"  {name:<12} {'home' if vehicle['finished'] else 'NOT HOME':<8} {vehicle['distance_m'] / 1000:6.1f} km  "
            f"saw {100 * vehicle['first_seen_cells'] / observed_cells:5.1f} % first  sent "
            f"{vehicle['bytes_sent'] / 1000:6.0f} kB, {vehicle['bytes_per_s']:.0f} B/s"
        )
    if out is not None:
        lines.append(f"  kept in {out}")
    return "\n".join(lines)


def _is_good(result: LockstepResult) -> bool:
    return (
        (result.observed_fraction >= AIM_FRACTION or covers(result.plan) or maps(result.plan))
        and all(result.finished)
        and not any(result.crashed)
        and result.min_separation_m >= min(MIN_SEPARATION_M, 0.5 * result.plan.mission.safety.separation_m)
        and result.fence_breaches == 0
    )
