"""What each planner decides in situations that leave no doubt."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vehicle_agent.domain.elevation import CellObservations, ElevationMap
from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.grid import Grid
from vehicle_agent.planning.baselines.closest_frontier import ClosestFrontier
from vehicle_agent.planning.baselines.greedy import Greedy, assign_nearest_pairs
from vehicle_agent.planning.cao import CaoParams
from vehicle_agent.planning.choose import make_planner
from vehicle_agent.planning.claims import Claims
from vehicle_agent.planning.constraints import Constraints, Reservation
from vehicle_agent.planning.exploration import CaoExplorer, Fcao
from vehicle_agent.planning.frontier_travel import bearing_word
from vehicle_agent.planning.given_up import GivenUp
from vehicle_agent.planning.interface import Finished, Observation, Situation, Teammate, Wait, Waypoint

GRID = Grid(0.0, 0.0, 10.0, 60, 40)
RANGE_M = 80.0
ALL = np.ones(GRID.shape, dtype=bool)
PLANNERS = ("tours", "lanes", "claims", "fcao", "cao", "closest-frontier", "greedy")


def known(*rectangles: tuple[int, int, int, int]) -> ElevationMap:
    """A level map, known in rectangles of cells (first column, first row, end column, end row)."""
    team_map = ElevationMap(GRID)
    seen = np.zeros(GRID.shape, dtype=bool)
    for left, low, right, high in rectangles:
        seen[left:right, low:high] = True
    indices = np.flatnonzero(seen.ravel())
    zeros = np.zeros(len(indices), dtype=np.int64)
    team_map.observe(0, CellObservations(indices, zeros.astype(np.int32), zeros + 1_000))
    return team_map


def situation(
    team_map: ElevationMap,
    position: Point,
    *teammates: Teammate,
    index: int = 0,
    reservations: tuple[Reservation, ...] = (),
) -> Situation:
    surface = np.where(team_map.observed, 0.0, math.nan)
    constraints = Constraints(GRID, surface, 20.0, 60.0, 60.0, 20.0, reservations)
    return Situation(index, position, team_map, ALL, RANGE_M, constraints, teammates)


def planner(name: str) -> object:
    return make_planner(name, GRID, RANGE_M, 60.0, (0.0, 0.0), np.random.default_rng(0))  # type: ignore[arg-type]


def goal_of(decision: object) -> tuple[float, float]:
    assert isinstance(decision, Waypoint)
    assert decision.goal_enu_m is not None
    return decision.goal_enu_m[:2]


@pytest.mark.parametrize("name", PLANNERS)
def test_every_planner_ends_when_everything_is_seen(name: str) -> None:
    chosen = planner(name)
    everything = situation(known((0, 0, 60, 40)), (300.0, 200.0, 20.0))
    for _ in range(2):
        chosen.tell(Observation((300.0, 200.0, 20.0), 2400.0))  # type: ignore[attr-defined]
    decision = chosen.ask(everything)  # type: ignore[attr-defined]
    assert isinstance(decision, Finished)


@pytest.mark.parametrize("name", PLANNERS)
def test_every_planner_gives_an_admissible_leg_with_a_reason(name: str) -> None:
    chosen = planner(name)
    here = (150.0, 150.0, 25.0)
    now = situation(known((5, 5, 30, 30)), here)
    chosen.tell(Observation(here, 100.0))  # type: ignore[attr-defined]
    decision = chosen.ask(now)  # type: ignore[attr-defined]
    assert isinstance(decision, Waypoint)
    assert decision.why
    assert now.constraints.admissible(here, np.array([decision.position_enu_m])).all()
    assert len(decision.route_enu_m) <= 12


@pytest.mark.parametrize("name", PLANNERS)
def test_every_planner_waits_where_nothing_is_admissible(name: str) -> None:
    chosen = planner(name)
    ringed = tuple(
        Reservation((150.0 + 25.0 * math.cos(a), 150.0 + 25.0 * math.sin(a), 0.0), (150.0, 150.0, 200.0), 1)
        for a in np.linspace(0.0, 6.0, 9)
    )
    crowded = situation(known((14, 14, 17, 17)), (155.0, 155.0, 20.0), reservations=ringed)
    chosen.tell(Observation((155.0, 155.0, 20.0), 9.0))  # type: ignore[attr-defined]
    assert isinstance(chosen.ask(crowded), Wait | Waypoint)  # type: ignore[attr-defined]


def test_closest_frontier_goes_to_the_closest() -> None:
    decision = ClosestFrontier(GRID).ask(situation(known((5, 5, 30, 35)), (100.0, 200.0, 20.0)))
    assert goal_of(decision) == pytest.approx((55.0, 195.0), abs=10.1)


def test_nearest_pairs_are_distinct_while_there_are_enough() -> None:
    vehicles = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    clusters = np.array([[3.0, 0.0], [0.0, 50.0], [0.0, -80.0]])
    assigned = assign_nearest_pairs(vehicles, clusters)
    assert sorted(assigned) == [0, 1, 2]
    assert assigned[2] == 0  # the nearest pair of all
    assert assign_nearest_pairs(vehicles, clusters[:1]) == [0, 0, 0]


def test_greedy_teammates_choose_distinct_clusters() -> None:
    team_map = known((5, 5, 45, 35))
    places = [(100.0, 200.0, 20.0), (120.0, 200.0, 20.0), (140.0, 200.0, 20.0)]
    goals = set()
    for index, place in enumerate(places):
        others = tuple(Teammate(i, p) for i, p in enumerate(places) if i != index)
        goals.add(goal_of(Greedy(GRID, RANGE_M).ask(situation(team_map, place, *others, index=index))))
    assert len(goals) == 3


def two_frontiers() -> ElevationMap:
    """Known over the whole height between columns 10 and 50: something to see west and east of it."""
    return known((10, 0, 50, 40))


def test_claims_leaves_a_nearer_teammate_its_frontier() -> None:
    here = (220.0, 200.0, 20.0)
    alone = goal_of(Claims(GRID, RANGE_M).ask(situation(two_frontiers(), here)))
    assert alone[0] < 150.0
    teammate = Teammate(1, (130.0, 200.0, 20.0), (105.0, 200.0, 20.0), 25.0)
    beside = goal_of(Claims(GRID, RANGE_M).ask(situation(two_frontiers(), here, teammate)))
    assert math.dist(beside, (105.0, 200.0)) > 1.2 * RANGE_M


def test_claims_keeps_its_frontier_against_a_teammate_further_away() -> None:
    here = (150.0, 200.0, 20.0)
    teammate = Teammate(1, (400.0, 200.0, 20.0), (105.0, 200.0, 20.0), 295.0)
    assert goal_of(Claims(GRID, RANGE_M).ask(situation(two_frontiers(), here, teammate)))[0] < 150.0


def test_cao_alone_moves_by_its_step_and_claims_no_goal() -> None:
    explorer = CaoExplorer(CaoParams(40.0), np.random.default_rng(0))
    here = (300.0, 200.0, 40.0)
    explorer.tell(Observation(here, 5.0))
    decision = explorer.ask(situation(two_frontiers(), here))
    assert isinstance(decision, Waypoint)
    assert decision.goal_enu_m is None
    assert math.dist(decision.position_enu_m, here) == pytest.approx(40.0)


def test_fcao_goes_to_the_frontier_while_the_objective_stands_still() -> None:
    fcao = Fcao(CaoParams(40.0), GRID, np.random.default_rng(0))
    here = (300.0, 200.0, 40.0)
    now = situation(two_frontiers(), here)
    told = []
    for objective in (5.0, 9.0, 9.0, 9.0, 12.0, 12.0):
        fcao.tell(Observation(here, objective))
        decision = fcao.ask(now)
        assert isinstance(decision, Waypoint)
        told.append(decision.why.startswith("frontier"))
    assert told == [False, False, True, True, False, True]


def test_fcao_takes_a_frontier_when_no_perturbation_is_admissible() -> None:
    fcao = Fcao(CaoParams(500.0), GRID, np.random.default_rng(0))
    here = (300.0, 200.0, 40.0)
    fcao.tell(Observation(here, 5.0))
    decision = fcao.ask(situation(two_frontiers(), here))
    assert isinstance(decision, Waypoint)
    assert decision.why.startswith("frontier")


def test_a_frontier_that_comes_no_nearer_is_given_up_with_its_neighbours() -> None:
    given_up = GivenUp(GRID)
    cell = 20 * GRID.rows + 10
    assert [given_up.chose(cell, 100.0) for _ in range(5)] == [False, False, False, False, True]
    kept = given_up.without(ALL)
    assert np.argwhere(~kept).tolist() == [[c, r] for c in (19, 20, 21) for r in (9, 10, 11)]


def test_progress_keeps_a_frontier() -> None:
    given_up = GivenUp(GRID)
    assert not any(given_up.chose(5, 500.0 - 10.0 * step) for step in range(40))


def test_two_frontiers_chosen_in_turn_come_to_an_end() -> None:
    given_up = GivenUp(GRID)
    ends = [given_up.chose(cell, 100.0) for _ in range(10) for cell in (5, 500)]
    assert any(ends)


def test_going_to_and_fro_comes_to_an_end() -> None:
    given_up = GivenUp(GRID)
    assert any(given_up.chose(5, 100.0 + 8.0 * (number % 2)) for number in range(20))


def test_coming_back_from_afar_costs_no_frontier() -> None:
    given_up = GivenUp(GRID)
    for away_m in (300.0, 200.0, 100.0, 50.0, 400.0, 300.0, 200.0, 100.0, 60.0, 40.0):
        assert not given_up.chose(5, away_m)


def test_a_way_that_is_taken_for_a_moment_costs_no_frontier() -> None:
    given_up = GivenUp(GRID)
    assert not any(given_up.waited(5) for _ in range(20))
    assert not given_up.chose(5, 100.0)
    assert [given_up.waited(5) for _ in range(30)] == [False] * 29 + [True]


def test_the_border_can_be_given_up() -> None:
    given_up = GivenUp(GRID)
    for cell in (0, GRID.cells - 1):
        while not given_up.chose(cell, 1.0):
            pass
    assert (~given_up.without(ALL)).sum() == 8


def test_frontier_planners_let_go_of_what_they_cannot_mend() -> None:
    """A lone unseen cell under a vehicle that sees nothing new: in the end there is nothing left to do."""
    team_map = known((0, 0, 60, 40))
    team_map.first_stamp_ms[30, 20] = np.iinfo(np.int64).max
    for name in ("closest-frontier", "greedy", "claims"):
        chosen = planner(name)
        here: Point = (305.0, 205.0, 20.0)
        decisions = 0
        while not isinstance(decision := chosen.ask(situation(team_map, here)), Finished):  # type: ignore[attr-defined]
            here = decision.position_enu_m if isinstance(decision, Waypoint) else here
            decisions += 1
            assert decisions < 60


@pytest.mark.parametrize("name", ["tours", "lanes"])
def test_sharing_planners_let_go_of_ground_that_nobody_may_fly_near_enough_to_see(name: str) -> None:
    """A forbidden block in a map that is known but for it: a vehicle beside it must not hover for ever."""
    team_map = known((0, 0, 60, 10), (0, 30, 60, 40), (0, 10, 20, 30), (40, 10, 60, 30))
    sharing = planner(name)
    here: Point = (203.0, 94.0, 20.0)
    decisions = 0
    while not isinstance(decision := sharing.ask(situation(team_map, here)), Finished):  # type: ignore[attr-defined]
        here = decision.position_enu_m if isinstance(decision, Waypoint) else here
        decisions += 1
        assert decisions < 400


def test_bearings_in_words() -> None:
    words = [bearing_word((0.0, 0.0), (math.sin(a), math.cos(a))) for a in np.radians(np.arange(0, 360, 45))]
    assert words == ["N", "NE", "E", "SE", "S", "SW", "W", "NW"]
