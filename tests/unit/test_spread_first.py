"""A team that knows a few points of the surface spreads over it before it covers."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from tests.fakes.hill_missions import hill_plan
from vehicle_agent.behaviour.outfit import first_place
from vehicle_agent.domain.elevation import ElevationMap
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.mission.checks import check_task
from vehicle_agent.mission.load import MissionError
from vehicle_agent.planning.constraints import Constraints, Reservation
from vehicle_agent.planning.interface import Observation, Situation, Wait, Waypoint
from vehicle_agent.planning.spread_first import PATIENCE, SpreadFirst, spread_team

GRID = Grid(0.0, 0.0, 10.0, 40, 40)
EVERYWHERE: BoolArray = np.ones(GRID.shape, dtype=np.bool_)
KNOWN = np.array([(50.0, 50.0, 10.0), (350.0, 60.0, 30.0), (200.0, 200.0, 60.0), (60.0, 340.0, 0.0)])
STARTS = np.array([(20.0 + 10.0 * index, 20.0) for index in range(5)])


class Stays:
    """A planner that counts what reaches it."""

    def __init__(self) -> None:
        self.told = self.asked = 0

    def tell(self, observation: Observation) -> None:
        self.told += 1

    def ask(self, situation: Situation) -> Wait:
        self.asked += 1
        return Wait("covering")


def situation(here: tuple[float, float, float], *, taken: bool = False) -> Situation:
    ahead = (here[0] + 300.0, here[1], here[2])
    wall = (Reservation(ahead, ahead, 1),) if taken else ()
    separation_m = 1_000.0 if taken else 5.0
    limits = Constraints(GRID, np.zeros(GRID.shape), 10.0, 80.0, 40.0, separation_m, wall)
    return Situation(0, here, ElevationMap(GRID), EVERYWHERE, 60.0, limits)


def test_everybody_works_the_same_places_out_far_apart_and_shares_them_without_crossing() -> None:
    first, second = (spread_team(KNOWN, GRID, EVERYWHERE, STARTS, 15.0, np.random.default_rng(4)) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    apart_m = np.linalg.norm(first[:, None, :2] - first[None, :, :2], axis=2) + 1e9 * np.eye(5)
    assert apart_m.min() > 100.0
    assert (first[:, 2] >= 15.0).all()
    assert (first[:, 2] <= 75.0).all()
    ways_m = np.linalg.norm(STARTS - first[:, :2], axis=1).sum()
    for one in range(5):
        for other in range(one):
            order = list(range(5))
            order[one], order[other] = other, one
            assert ways_m <= np.linalg.norm(STARTS - first[order, :2], axis=1).sum() + 1e-9


def test_a_place_outside_the_area_moves_inside() -> None:
    western = EVERYWHERE.copy()
    western[20:, :] = False
    places = spread_team(KNOWN, GRID, western, STARTS, 15.0, np.random.default_rng(4))
    assert (places[:, 0] <= 200.0).all()


def test_the_way_to_the_first_place_comes_before_coverage() -> None:
    coverer = Stays()
    planner = SpreadFirst((150.0, 20.0, 30.0), coverer)
    here = (20.0, 20.0, 12.0)
    for _ in range(20):
        planner.tell(Observation(here, 0.0))
        decision = planner.ask(situation(here))
        if not isinstance(decision, Waypoint):
            break
        assert "first place" in decision.why
        here = decision.position_enu_m
    assert math.dist(here[:2], (150.0, 20.0)) <= 2.0
    assert planner.arrived
    assert (coverer.told, coverer.asked) == (0, 1)
    planner.tell(Observation(here, 1.0))
    assert coverer.told == 1


def test_a_place_that_cannot_be_reached_is_let_go() -> None:
    coverer = Stays()
    planner = SpreadFirst((150.0, 20.0, 30.0), coverer)
    for _ in range(PATIENCE):
        assert planner.ask(situation((20.0, 20.0, 12.0), taken=True)) != Wait("covering")
    assert planner.ask(situation((20.0, 20.0, 12.0), taken=True)) == Wait("covering")
    assert coverer.asked == 1


def test_the_mission_says_what_is_known() -> None:
    task = {"kind": "cover", "step_m": 40.0, "known_points_enu_m": [[100.0, 100.0, 20.0], [500.0, 500.0, 60.0]]}
    plan = hill_plan(1, vehicles=3, task=task)
    places = [first_place(plan, index) for index in range(3)]
    assert len(set(places)) == 3
    assert first_place(hill_plan(1, vehicles=3, task={"kind": "cover", "step_m": 40.0}), 0) is None
    assert first_place(hill_plan(1, vehicles=3), 0) is None


@pytest.mark.parametrize("point", [[700.0, 100.0, 20.0], [100.0, -1.0, 20.0]])
def test_a_known_point_outside_the_area_is_refused_with_a_sentence(point: list[float]) -> None:
    task = {"kind": "cover", "step_m": 40.0, "known_points_enu_m": [[100.0, 100.0, 20.0], point]}
    with pytest.raises(MissionError, match=r"task\.known_points_enu_m\[1\]: .* lies outside the area; remove it"):
        check_task(hill_plan(1, task=task))


def test_a_point_needs_three_coordinates() -> None:
    task = {"kind": "cover", "step_m": 40.0, "known_points_enu_m": [[100.0, 100.0]]}
    with pytest.raises(msgspec.ValidationError, match="known_points_enu_m"):
        hill_plan(1, task=task)
