"""`missions bench mapping`: landmarks left after 500 steps over both maps, every method under the same constraints."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from missions.bench.mapping_methods import ABLATION, DEFAULT, METHODS, exchange_for, make_mover
from missions.bench.mapping_run import MappingRun, Team, Trouble, run_team
from missions.bench.mapping_world import MAPS, Setup, make_world
from missions.bench.pool import measure_all
from missions.bench.results import Row, save_rows
from vehicle_agent.mission.load import MissionError

FEW, EVERY = "1100", "all"
LANDMARKS = (FEW, EVERY)
ABLATION_VEHICLES = 3
ROBUST = "default troubled"
"""The default with 30 % of all packets lost, 3 landmarks per packet and one vehicle dead at half time."""
ROBUST_LOSS, ROBUST_CAPACITY = 0.3, 3
KEYS = (
    "map", "vehicles", "landmarks", "method", "remaining_percent_mean", "remaining_percent_sd", "sum_of_error_mean",
    "bytes_per_vehicle_per_step", "step_ms_median",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Case:
    """One run."""

    map: str
    vehicles: int
    landmarks: str
    method: str
    seed: int
    export: Path | None


@dataclass(frozen=True, slots=True)
class Outcome:
    """What remains of one run for its row."""

    remaining_percent: float
    sum_of_error: float
    bytes_per_vehicle_per_step: float
    step_ms: tuple[float, ...]
    agree_after_repair: bool
    step_done_percent: tuple[float, ...] = ()


def bench_mapping(
    seeds: int,
    vehicles: Sequence[int],
    landmarks: Sequence[str],
    seed: int,
    json_file: Path | None,
    export: Path | None,
    times: bool = False,
) -> int:
    """Measure, print a table, write what was asked for; the exit code: 130 when Ctrl-C came before the end."""
    if export is not None:
        _prepare(export)
    cases = list(cases_of(seeds, vehicles, landmarks, seed, export))
    results, interrupted = measure_all(cases, measure, "mapping")
    rows = rows_of(results)
    print(table(rows))
    print(disturbance(results))
    print(agreement(results))
    if times:
        print(times_by_done(results))
    if json_file is not None:
        save_rows(json_file, "mapping", seed, rows)
    return 130 if interrupted else 0


def cases_of(
    seeds: int, vehicles: Sequence[int], landmarks: Sequence[str], seed: int, export: Path | None
) -> Iterator[Case]:
    """Every run of the bench, seed by seed, so that a run cut short has something of everything."""
    for number in range(seeds):
        for size in vehicles:
            for many in landmarks:
                for name in MAPS:
                    ablation = tuple(ABLATION) if size == ABLATION_VEHICLES and many == FEW else ()
                    for method in (*METHODS, ROBUST, *ablation):
                        yield Case(name, size, many, method, seed + number, export)


def measure(case: Case) -> tuple[Case, Outcome]:
    """Run one case; all chance comes from its seed."""
    world = make_world(case.map, case.landmarks == FEW)
    setup, trouble, method = Setup(), Trouble(), case.method
    if method == ROBUST:
        setup = Setup(capacity=ROBUST_CAPACITY)
        trouble = Trouble(ROBUST_LOSS, dead_vehicle=case.vehicles - 1, dead_at=setup.steps // 2)
        method = DEFAULT
    team = Team(world, setup, case.vehicles, exchange_for(method, setup, world), trouble, _rng(case, 0))
    mover = make_mover(method, case.vehicles, len(world.layout), setup, _rng(case, 1))
    run = run_team(team, mover, setup.steps)
    _export(case, run)
    per_step = run.bytes_sent / (case.vehicles * team.steps)  # of the steps that it took
    return case, Outcome(
        float(run.remaining_percent[-1]), run.sum_of_error, per_step, tuple(run.step_ms), run.agree_after_repair,
        tuple(run.step_done_percent),
    )  # fmt: skip


def rows_of(results: Sequence[tuple[Case, Outcome]]) -> list[Row]:
    """A row for every map, team size, number of landmarks and method, in that order."""
    gathered: dict[tuple[str, int, str, str], list[Outcome]] = {}
    for case, outcome in results:
        gathered.setdefault((case.map, case.vehicles, case.landmarks, case.method), []).append(outcome)
    rows = []
    for group, mine in gathered.items():
        left = [outcome.remaining_percent for outcome in mine]
        figures = (
            float(np.mean(left)),
            float(np.std(left)),
            float(np.mean([outcome.sum_of_error for outcome in mine])),
            float(np.mean([outcome.bytes_per_vehicle_per_step for outcome in mine])),
            float(np.median(np.concatenate([outcome.step_ms for outcome in mine]))),
        )
        rows.append(dict(zip(KEYS, (*group, *figures), strict=True)))
    return rows


def table(rows: Sequence[Row]) -> str:
    """The rows for people."""
    lines = ["map     vehicles  landmarks  method             remaining %       sum of error  bytes  step ms"]
    lines.extend(
        f"{row['map']:<7} {row['vehicles']:8d}  {row['landmarks']:>9}  {row['method']:<18} "
        f"{row['remaining_percent_mean']:6.2f} ±{row['remaining_percent_sd']:5.2f}   "
        f"{row['sum_of_error_mean']:12.0f}  {row['bytes_per_vehicle_per_step']:5.0f}  {row['step_ms_median']:7.2f}"
        for row in rows
    )
    lines.append("bytes per vehicle and step; step ms of one vehicle for default, of the whole team for the others")
    return "\n".join(lines)


def disturbance(results: Sequence[tuple[Case, Outcome]]) -> str:
    """What loss, a thinner link and a death cost the default, for people."""
    left: dict[tuple[str, int, str], dict[str, list[Outcome]]] = {}
    for case, outcome in results:
        if case.method in (DEFAULT, ROBUST):
            left.setdefault((case.map, case.vehicles, case.landmarks), {}).setdefault(case.method, []).append(outcome)
    lines = []
    for (name, vehicles, many), group in left.items():
        if len(group) == 2:
            calm, troubled = (np.mean([one.remaining_percent for one in group[key]]) for key in (DEFAULT, ROBUST))
            agreed = sum(one.agree_after_repair for one in group[ROBUST])
            lines.append(
                f"{name}, {vehicles} vehicles, {many} landmarks: {ROBUST_LOSS:.0%} loss, {ROBUST_CAPACITY} landmarks a "
                f"packet and a death at half time leave {troubled:.3f} % instead of {calm:.3f} %; "
                f"survivors' maps equal after repair in {agreed} of {len(group[ROBUST])} runs"
            )
    return "\n".join(lines)


def times_by_done(results: Sequence[tuple[Case, Outcome]]) -> str:
    """Median planning time of the default's decisions by tenth of the landmarks done, for people."""
    gathered: dict[tuple[int, str], list[Outcome]] = {}
    for case, outcome in results:
        if case.method == DEFAULT:
            gathered.setdefault((case.vehicles, case.landmarks), []).append(outcome)
    lines = ["step ms of one vehicle (default), median by tenth of the landmarks done:"]
    for (vehicles, many), mine in gathered.items():
        took = np.concatenate([one.step_ms for one in mine])
        tenth = np.minimum(np.concatenate([one.step_done_percent for one in mine]) // 10.0, 9.0)
        medians = [f"{np.median(took[tenth == n]):.2f}" if np.any(tenth == n) else "-" for n in range(10)]
        lines.append(f"{vehicles:3d} vehicles, {many:>4} landmarks: {'  '.join(medians)}")
    return "\n".join(lines)


def agreement(results: Sequence[tuple[Case, Outcome]]) -> str:
    """Whether maps were equal after repair, for people."""
    agreed = sum(outcome.agree_after_repair for _, outcome in results)
    return f"maps of all living vehicles equal after repair in {agreed} of {len(results)} runs"


def _rng(case: Case, purpose: int) -> np.random.Generator:
    """A generator for one purpose in one case: 0 the sensors and the radio, 1 the method's own dice."""
    where = (MAPS.index(case.map), case.vehicles, LANDMARKS.index(case.landmarks))
    return np.random.default_rng(np.random.SeedSequence(case.seed, spawn_key=(*where, purpose)))


def _prepare(folder: Path) -> None:
    """Make the export folder and write the surfaces."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name in MAPS:
            np.savez_compressed(folder / f"map_{name}.npz", elevation=make_world(name, few=True).elevation)
    except OSError as error:
        raise MissionError(
            f"{folder}: cannot be written ({error.strerror}); choose another folder with --export"
        ) from None


def _export(case: Case, run: MappingRun) -> None:
    if case.export is not None:
        method = case.method.replace(" ", "-").replace("+", "")
        name = f"run_{case.map}_{case.vehicles}_{case.landmarks}_{method}_{case.seed}.npz"
        np.savez_compressed(case.export / name, positions_enu_m=run.positions, remaining_percent=run.remaining_percent)
