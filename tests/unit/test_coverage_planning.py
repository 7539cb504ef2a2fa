"""Static coverage: the objective, the decreasing step, and the stations that a team agrees on."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from missions.bench.coverage_run import CoverageRun, CoverageTeam, cover
from missions.bench.coverage_starts import STARTS, Start, draw_start
from missions.bench.hills import HillsParams, draw_hills
from missions.bench.informed import AscentParams, informed_optimum
from vehicle_agent.domain.clearance import ground_heights
from vehicle_agent.domain.elevation import CellObservations, ElevationMap
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.sensing import view
from vehicle_agent.planning.cao import CaoParams
from vehicle_agent.planning.constraints import Constraints
from vehicle_agent.planning.coverage import CaoCoverage, StepSchedule, coverage_objective, coverage_share
from vehicle_agent.planning.explore_then_cover import ExploreThenCover
from vehicle_agent.planning.interface import (
    Decision,
    Finished,
    Observation,
    Planner,
    Situation,
    Teammate,
    Wait,
    Waypoint,
)
from vehicle_agent.planning.stations import Stations, StationsParams

HILLS = HillsParams(side_m=60.0, cell_m=1.5, peaks=4, height_m=(3.0, 12.0), sigma_m=8.0)
TEAM = CoverageTeam(range_m=18.0)


def hills(seed: int) -> FloatArray:
    return draw_hills(HILLS, np.random.default_rng(seed))


def team_of(size: int, seed: int, params: StationsParams | None = None) -> list[Planner]:
    return [Stations(np.random.default_rng([seed, index]), params) for index in range(size)]


def run(
    seed: int, planners: Sequence[Planner], start: Start = "cvt", iterations: int = 400, team: CoverageTeam = TEAM
) -> CoverageRun:
    surface = hills(seed)
    starts = draw_start(start, HILLS.grid, surface, team, len(planners), np.random.default_rng(seed))
    return cover(HILLS.grid, surface, starts, planners, team, iterations)


def assert_within_limits(result: CoverageRun, surface: FloatArray, team: CoverageTeam) -> None:
    grid = HILLS.grid
    places = result.positions_enu_m.reshape(-1, 3)
    ground = ground_heights(surface, grid.west_m, grid.south_m, grid.cell_m, places)
    assert (places[:, 2] - ground).min() >= team.min_above_m
    assert places[:, 2].max() <= team.ceiling_m
    steps = np.linalg.norm(np.diff(result.positions_enu_m, axis=0), axis=2)
    assert steps.max() <= team.step_m + 1e-9
    assert result.min_separation_m >= team.separation_m - 1e-9


def test_shared_cells_are_shared() -> None:
    views = np.zeros((3, 1, 4), dtype=np.bool_)
    views[0, 0, :3] = views[1, 0, 1:3] = views[2, 0, 2:] = True
    assert coverage_share(views[0], [views[1], views[2]]) == pytest.approx(1.0 + 1.0 / 2.0 + 1.0 / 3.0)
    everybody = sum(coverage_share(views[k], [views[m] for m in range(3) if m != k]) for k in range(3))
    assert everybody == pytest.approx(4.0)


def test_the_objective_comes_from_the_teams_map() -> None:
    grid = Grid(0.0, 0.0, 1.0, 20, 20)
    team_map = ElevationMap(grid)
    known = np.arange(200, dtype=np.int64)
    team_map.observe(0, CellObservations(known, np.zeros(200, dtype=np.int32), np.ones(200, dtype=np.int64)))
    area = np.ones(grid.shape, dtype=np.bool_)
    here = (5.0, 10.0, 4.0)
    alone = coverage_objective(team_map, area, here, 5.0, [])
    assert alone == pytest.approx(9.0 * math.pi, rel=0.15)
    assert coverage_objective(team_map, area, here, 5.0, [(here, 5.0)]) == pytest.approx(alone / 2.0)
    assert coverage_objective(team_map, area, (17.0, 10.0, 4.0), 5.0, []) == 0.0


def test_the_step_satisfies_the_condition_on_alpha() -> None:
    schedule = StepSchedule(2.0)
    steps = np.array([schedule.step_m(t) for t in range(200_000)])
    assert steps[0] == 2.0
    assert (np.diff(steps) < 0.0).all()
    assert steps[-1] < 0.01
    first, second = steps[:100_000].sum(), steps[100_000:].sum()
    assert second > 0.15 * first
    assert (steps[100_000:] ** 2).sum() < 0.05 * (steps**2).sum()
    for decay in (0.5, 1.01):
        with pytest.raises(ValueError, match="does not satisfy"):
            StepSchedule(1.0, decay=decay)


@pytest.mark.parametrize("start", STARTS)
def test_starts_are_admissible(start: Start) -> None:
    for seed in range(3):
        surface = hills(seed)
        places = draw_start(start, HILLS.grid, surface, TEAM, 12, np.random.default_rng(seed))
        ground = ground_heights(surface, 0.0, 0.0, HILLS.cell_m, places)
        assert (places[:, 2] >= ground + TEAM.min_above_m).all()
        apart = np.linalg.norm(places[:, None] - places[None], axis=2) + 1e9 * np.eye(12)
        assert apart.min() >= TEAM.separation_m


def test_more_vehicles_than_fit_are_refused() -> None:
    crowd = CoverageTeam(separation_m=40.0)
    with pytest.raises(ValueError, match="take fewer"):
        draw_start("random", HILLS.grid, hills(0), crowd, 10, np.random.default_rng(0))
    with pytest.raises(ValueError, match="take fewer"):
        draw_start("corner", HILLS.grid, hills(0), TEAM, 400, np.random.default_rng(0))


@pytest.mark.parametrize("seed", [1, 2])
def test_cao_climbs_and_keeps_its_limits(seed: int) -> None:
    planners = [CaoCoverage(CaoParams(1.0), np.random.default_rng([seed, index])) for index in range(4)]
    result = run(seed, planners, "random", iterations=150)
    assert result.covered_fraction.max() > result.covered_fraction[0] + 0.03
    assert_within_limits(result, hills(seed), TEAM)


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("seed", [1, 2])
def test_stations_come_near_to_the_informed_optimum_from_anywhere(seed: int, start: Start) -> None:
    result = run(seed, team_of(5, seed), start)
    rng = np.random.default_rng(seed)
    best, places = informed_optimum(HILLS.grid, hills(seed), TEAM, 5, rng, AscentParams(starts=6, kept=2))
    assert len(places) == 5
    assert result.covered_fraction[-1] >= 0.96 * best
    assert_within_limits(result, hills(seed), TEAM)


def test_the_same_seed_gives_the_same_run() -> None:
    first, second = (run(3, team_of(4, 3), iterations=60) for _ in range(2))
    np.testing.assert_array_equal(first.positions_enu_m, second.positions_enu_m)


def test_a_team_that_has_settled_has_finished() -> None:
    result = run(1, team_of(4, 1, StationsParams(heated_decisions=20)))
    assert len(result.covered_fraction) < 400
    assert result.covered_fraction[-1] == result.covered_fraction[-10]


def surveyed(surface: FloatArray) -> ElevationMap:
    grid = HILLS.grid
    team_map = ElevationMap(grid)
    everything = np.arange(grid.cells, dtype=np.int64)
    heights_dm = np.round(10.0 * surface.ravel()).astype(np.int32)
    team_map.observe(0, CellObservations(everything, heights_dm, np.ones(grid.cells, dtype=np.int64)))
    return team_map


class Talk:
    """A team on known ground without flight: each takes its station at once, and all hear of it."""

    def __init__(self, surface: FloatArray, planners: Sequence[Stations]) -> None:
        self.surface, self.planners = surface, list(planners)
        self.map = surveyed(surface)
        grid = HILLS.grid
        middle = (0.5 * (grid.west_m + grid.east_m), 0.5 * (grid.south_m + grid.north_m))
        self.places = [(middle[0] + 3.0 * index, middle[1], 20.0) for index in range(len(planners))]
        self.present = list(range(len(planners)))

    def turn(self) -> list[Decision]:
        decisions = []
        for index in self.present:
            mates = tuple(Teammate(k, self.places[k], self.places[k]) for k in self.present if k != index)
            limits = Constraints(HILLS.grid, self.map.elevation_m, 3.0, 50.0, 500.0, 2.0)
            area = np.ones(HILLS.grid.shape, dtype=np.bool_)
            situation = Situation(index, self.places[index], self.map, area, TEAM.range_m, limits, mates)
            decision = self.planners[index].ask(situation)
            if isinstance(decision, Waypoint):
                self.places[index] = decision.position_enu_m
            decisions.append(decision)
        return decisions

    def covered(self) -> float:
        views = [view(HILLS.grid, self.surface, self.places[k], TEAM.range_m) for k in self.present]
        return float(np.logical_or.reduce(views).mean())


def talk(seed: int, size: int) -> Talk:
    params = StationsParams(heated_decisions=40, hold=30)
    return Talk(hills(seed), [Stations(np.random.default_rng([seed, k]), params) for k in range(size)])


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_team_spreads_again_when_a_member_dies_and_when_one_joins(seed: int) -> None:
    team = talk(seed, 5)
    for _ in range(60):
        team.turn()
    whole = team.covered()
    lost = max(team.present, key=lambda k: view(HILLS.grid, team.surface, team.places[k], TEAM.range_m).sum())
    team.present.remove(lost)
    left = team.covered()
    for _ in range(60):
        team.turn()
    spread = team.covered()
    assert spread > left + 0.2 * (whole - left)
    team.present.append(lost)
    for _ in range(60):
        team.turn()
    assert team.covered() >= 0.97 * whole


def test_those_who_leave_after_the_hold_are_not_replaced() -> None:
    team = talk(1, 4)
    done: list[int] = []
    for _ in range(400):
        decisions = dict(zip(list(team.present), team.turn(), strict=True))
        done = [index for index, decision in decisions.items() if isinstance(decision, Finished)]
        if done:
            break
    assert done
    before = list(team.places)
    team.present = [index for index in team.present if index not in done[:1]]
    for _ in range(8):
        team.turn()
    assert team.places == before


def test_no_station_is_taken_too_near_to_a_teammates() -> None:
    team = talk(2, 6)
    for _ in range(50):
        team.turn()
    apart = [math.dist(team.places[i], team.places[k]) for i in range(6) for k in range(i)]
    assert min(apart) >= TEAM.separation_m


class Says:
    """A planner that says what it was told to."""

    def __init__(self, decision: Decision) -> None:
        self.decision = decision
        self.told = 0

    def tell(self, observation: Observation) -> None:
        self.told += 1

    def ask(self, situation: Situation) -> Decision:
        return self.decision


@pytest.mark.parametrize(
    ("explorer", "known", "switches"), [("busy", 0.5, False), ("busy", 0.95, True), ("done", 0.5, True)]
)
def test_coverage_begins_when_enough_is_known_or_nothing_more_can_be(
    explorer: str, known: float, switches: bool
) -> None:
    grid = HILLS.grid
    team_map = ElevationMap(grid)
    cells = np.arange(int(known * grid.cells), dtype=np.int64)
    team_map.observe(0, CellObservations(cells, np.zeros(len(cells), np.int32), np.ones(len(cells), np.int64)))
    limits = Constraints(grid, team_map.elevation_m, 3.0, 50.0, 2.0)
    situation = Situation(0, (5.0, 5.0, 5.0), team_map, np.ones(grid.shape, dtype=np.bool_), 18.0, limits)
    first = Says(Finished("nothing left") if explorer == "done" else Wait("exploring"))
    second = Says(Wait("covering"))
    planner = ExploreThenCover(first, second, enough=0.9)
    assert planner.ask(situation) == (second if switches else first).decision
    planner.tell(Observation((5.0, 5.0, 5.0), 1.0))
    assert (first.told, second.told) == ((0, 1) if switches else (1, 0))
