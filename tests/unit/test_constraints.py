"""Legs that are allowed, and how a vehicle gets out of where it should not be."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vehicle_agent.domain.grid import Grid
from vehicle_agent.planning.constraints import Constraints, Reservation
from vehicle_agent.planning.travel import next_leg

GRID = Grid(0.0, 0.0, 10.0, 20, 20)


def over(surface_m: np.ndarray, *reservations: Reservation, reach_m: float = 60.0) -> Constraints:
    return Constraints(GRID, surface_m, 30.0, 90.0, reach_m, 20.0, reservations)


def level() -> np.ndarray:
    return np.zeros(GRID.shape)


def test_fit_takes_the_lowest_height_over_the_target() -> None:
    assert over(level()).fit((50.0, 50.0, 30.0), (90.0, 50.0)) == pytest.approx((90.0, 50.0, 30.0))


def test_fit_stops_at_the_reach() -> None:
    end = over(level()).fit((20.0, 50.0, 30.0), (190.0, 50.0))
    assert end == pytest.approx((80.0, 50.0, 30.0))


def test_fit_of_three_legs_in_a_line_goes_three_times_as_far() -> None:
    end = over(level(), reach_m=20.0).fit((20.0, 50.0, 30.0), (190.0, 50.0), 3)
    assert end == pytest.approx((80.0, 50.0, 30.0))


def test_a_climb_in_several_legs_goes_higher_than_one_may() -> None:
    low = (50.0, 50.0, 5.0)  # 25 m below the height band
    assert over(level(), reach_m=10.0).climb(low) is None
    assert over(level(), reach_m=10.0).climb(low, 2) == pytest.approx((50.0, 50.0, 30.0))


def test_fit_flies_higher_over_a_ridge_in_between() -> None:
    surface = level()
    surface[7, :] = 20.0
    constraints = over(surface)
    end = constraints.fit((45.0, 50.0, 40.0), (105.0, 50.0))
    assert end is not None
    assert end[2] > 30.0
    assert constraints.clearance_m((45.0, 50.0, 40.0), end) >= 30.0 - 0.05


def test_a_cliff_is_taken_in_short_steep_legs() -> None:
    surface = level()
    surface[7, :] = 55.0
    surface[8:, :] = 60.0
    constraints = Constraints(GRID, surface, 30.0, 40.0, 60.0)
    here, goal = (65.0, 50.0, 30.0), (185.0, 50.0)
    for _ in range(20):
        end = next_leg(here, goal, constraints)
        assert end is not None
        assert constraints.clearance_m(here, end) >= 29.9
        here = end
    assert here[:2] == pytest.approx(goal)


def test_a_vehicle_too_low_may_climb_away_but_not_sink() -> None:
    constraints = over(level())
    here = (50.0, 50.0, 12.0)
    ends = np.array([[80.0, 50.0, 40.0], [50.0, 50.0, 30.0], [80.0, 50.0, 12.0], [50.0, 50.0, 5.0]])
    assert constraints.admissible(here, ends).tolist() == [True, True, False, False]


def test_a_vehicle_too_high_may_come_down() -> None:
    end = over(level()).fit((50.0, 50.0, 140.0), (50.0, 50.0))
    assert end is not None
    assert end[2] <= 90.0


def test_a_vehicle_too_near_to_a_teammate_may_leave_but_not_approach() -> None:
    beside = Reservation((50.0, 60.0, 30.0), (50.0, 60.0, 30.0), 0)
    constraints = over(level(), beside)
    here = (50.0, 50.0, 30.0)
    assert constraints.conflict(here, (50.0, 20.0, 30.0)) is None
    assert constraints.conflict(here, (50.0, 90.0, 30.0)) is beside


def test_who_sits_on_a_teammates_leg_must_not_fly_towards_the_teammate() -> None:
    head_on = Reservation((150.0, 50.0, 30.0), (50.0, 50.0, 30.0), 0)
    constraints = over(level(), head_on)
    here = (50.0, 50.0, 30.0)
    assert constraints.conflict(here, (145.0, 50.0, 30.0)) is head_on
    assert constraints.conflict(here, (50.0, 20.0, 30.0)) is None


def test_every_conflict_is_told_not_only_the_first() -> None:
    rivals = [Reservation((x, 20.0, 30.0), (x, 80.0, 30.0), index) for index, x in enumerate((80.0, 100.0))]
    constraints = over(level(), *rivals)
    assert list(constraints.conflicts((20.0, 50.0, 30.0), (130.0, 50.0, 30.0))) == rivals


def test_who_rests_on_a_leg_blocks_it() -> None:
    constraints = over(level())
    leg = ((20.0, 50.0, 30.0), (130.0, 50.0, 30.0))
    assert constraints.blocks(*leg, (100.0, 60.0, 30.0))
    assert not constraints.blocks(*leg, (100.0, 80.0, 30.0))


def test_crossing_at_another_height_is_no_conflict() -> None:
    below = Reservation((80.0, 0.0, 30.0), (80.0, 100.0, 30.0), 0)
    assert over(level(), below).conflict((20.0, 50.0, 55.0), (130.0, 50.0, 55.0)) is None


def test_no_leg_leaves_the_grid() -> None:
    constraints = over(level())
    assert not constraints.admissible((50.0, 50.0, 40.0), np.array([[-3.0, 50.0, 40.0], [50.0, -40.0, 40.0]])).any()


@pytest.mark.parametrize("outside", [(-60.0, 50.0, 40.0), (50.0, 240.0, 40.0), (2.0, 2.0, 40.0)])
def test_a_vehicle_outside_the_grid_comes_back(outside: tuple[float, float, float]) -> None:
    constraints = over(level(), reach_m=100.0)
    here = outside
    for _ in range(4):
        end = next_leg(here, (100.0, 100.0), constraints)
        assert end is not None
        here = end
    assert here[:2] == pytest.approx((100.0, 100.0))


def test_a_vehicle_over_forbidden_ground_leaves_it_by_the_shortest_way() -> None:
    surface = level()
    surface[:8, :] = math.nan
    end = next_leg((68.0, 50.0, 40.0), (30.0, 50.0), over(surface))
    assert end is not None
    assert end[:2] == pytest.approx((85.0, 55.0))


def test_the_way_leads_around_unknown_ground() -> None:
    surface = level()
    surface[8:11, :15] = math.nan
    constraints = over(surface)
    here, goal = (40.0, 45.0, 30.0), (150.0, 45.0)
    legs = 0
    while math.dist(here[:2], goal) > 1.0:
        end = next_leg(here, goal, constraints)
        assert end is not None
        assert constraints.admissible(here, np.array([end])).all()
        here, legs = end, legs + 1
        assert legs < 20


@pytest.mark.parametrize("here", [(103.0, 44.0, 40.0), (101.0, 48.0, 40.0), (99.0, 44.0, 90.0), (100.5, 99.0, 40.0)])
def test_a_vehicle_beside_a_forbidden_corner_gets_round_it(here: tuple[float, float, float]) -> None:
    surface = level()
    surface[5:10, 5:10] = math.nan
    legs = 0
    while math.dist(here[:2], (75.0, 140.0)) > 1.0:
        end = next_leg(here, (75.0, 140.0), over(surface))
        assert end is not None
        assert over(surface).clearance_m(here, end) >= 29.0
        here, legs = (end[0] + 0.3, end[1] - 0.2, end[2] + 0.1), legs + 1  # nobody arrives to the centimetre
        assert legs < 20


def test_without_any_known_ground_there_is_no_leg() -> None:
    assert next_leg((50.0, 50.0, 40.0), (90.0, 50.0), over(np.full(GRID.shape, math.nan))) is None


def test_a_goal_that_cannot_be_reached_is_approached() -> None:
    surface = level()
    surface[10:13, :] = math.nan
    here = (40.0, 55.0, 30.0)
    for _ in range(6):
        end = next_leg(here, (180.0, 55.0), over(surface))
        if end is None:
            break
        here = end
    assert here[0] == pytest.approx(95.0)
