"""Exploration by lanes and by tours when the plan or what there is to see changes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from vehicle_agent.domain.elevation import ElevationMap
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.planning.constraints import Constraints, Reservation
from vehicle_agent.planning.interface import AnnouncedLanes, Situation, Teammate, Waypoint
from vehicle_agent.planning.lane_explorer import LaneExplorer
from vehicle_agent.planning.team_lanes import LanesParams
from vehicle_agent.planning.tour_explorer import TourExplorer

GRID = Grid(0.0, 0.0, 2.0, 50, 40)
RANGE_M = 16.0
WHOLE = np.ones(GRID.shape, dtype=bool)
SECTOR = WHOLE & (np.arange(GRID.columns) > 42)[:, None] & (np.arange(GRID.rows) > 32)
CONSTRAINTS = Constraints(GRID, np.zeros(GRID.shape), 3.0, 20.0, 4.0)


def seen(area_cells: BoolArray) -> Situation:
    return Situation(0, (5.0, 5.0, 5.0), ElevationMap(GRID), area_cells, RANGE_M, CONSTRAINTS)


def test_tours_lead_through_an_area_that_grows() -> None:
    tours = TourExplorer(None, RANGE_M)
    decision = tours.ask(seen(SECTOR))
    for _ in range(3):  # the first leg is flown to its end
        assert isinstance(decision, Waypoint)
        decision = tours.ask(replace(seen(WHOLE), position_enu_m=decision.position_enu_m))
    assert isinstance(decision, Waypoint)
    assert decision.tour is not None
    assert len(decision.tour.patches) > 10


def test_a_sector_is_no_part_of_the_plan_for_the_team() -> None:
    lanes = LaneExplorer(None, TourExplorer(None, RANGE_M), LanesParams(first_trials=2_000, trials=200))
    before, alone, after = (lanes.ask(seen(area)) for area in (WHOLE, SECTOR, WHOLE))
    assert isinstance(before, Waypoint)
    assert isinstance(alone, Waypoint)
    assert isinstance(after, Waypoint)
    assert (before.lanes is None, alone.lanes is None, after.lanes is None) == (False, True, False)
    assert alone.goal_enu_m is not None
    assert SECTOR[GRID.cell_of(*alone.goal_enu_m[:2])]


def test_a_vehicle_that_thought_ahead_decides_as_it_would_at_once() -> None:
    params = LanesParams(first_trials=12_000, trials=300)
    ahead, at_once = (LaneExplorer(None, TourExplorer(None, RANGE_M), params) for _ in range(2))
    now = seen(WHOLE)
    assert [ahead.think(now, now.position_enu_m) for _ in range(3)] == [False, False, True]
    decision = ahead.ask(now)
    assert decision == at_once.ask(now)
    assert isinstance(decision, Waypoint)
    assert decision.lanes is not None
    assert ahead.think(now, now.position_enu_m)  # it follows this plan for some steps
    assert ahead.ask(now) == at_once.ask(now)


def test_nothing_is_thought_of_where_tours_lead() -> None:
    lanes = LaneExplorer(None, TourExplorer(None, RANGE_M), LanesParams(first_trials=12_000))
    lanes.ask(seen(WHOLE))
    assert lanes.think(seen(SECTOR), seen(SECTOR).position_enu_m)


START_ENU_M = (50.0, 40.0, 3.0)


def with_plan(number: int, *way: int) -> Situation:
    """A vehicle in the middle of the area, whose teammate far away told a plan."""
    plan = AnnouncedLanes(number, 1, (0, 1), (way, ()))
    mate = Teammate(1, (95.0, 75.0, 5.0), None, 0.0, None, plan)
    return replace(seen(WHOLE), position_enu_m=START_ENU_M, teammates=(mate,))


def fly(situations: list[Situation]) -> list[Waypoint]:
    """What a vehicle decides that tries no changes and is where it decided to be."""
    lanes = LaneExplorer(None, TourExplorer(None, RANGE_M), LanesParams(first_trials=0, trials=0))
    decisions: list[Waypoint] = []
    for situation in situations:
        here = decisions[-1].position_enu_m if decisions else START_ENU_M
        decision = lanes.ask(replace(situation, position_enu_m=here))
        assert isinstance(decision, Waypoint)
        decisions.append(decision)
    return decisions


def test_steps_decided_on_are_flown_before_the_latest_plan_is() -> None:
    eastward, northward = with_plan(10, 90, 40), with_plan(20, 50, 75)
    steps = fly([eastward, northward, northward, northward])
    assert [step.position_enu_m[:2] for step in steps[:3]] == [(54.0, 40.0), (58.0, 40.0), (62.0, 40.0)]
    turned = steps[3].position_enu_m
    assert (turned[0] - 62.0) / (turned[1] - 40.0) == pytest.approx((50.0 - 62.0) / (75.0 - 40.0))


def test_steps_go_round_a_bend_and_it_is_told_as_flown() -> None:
    steps = fly([with_plan(10, 58, 40, 58, 70)] * 3)
    assert [step.position_enu_m[:2] for step in steps] == [(54.0, 40.0), (58.0, 40.0), (58.0, 44.0)]
    told = [step.lanes for step in steps]
    assert [lanes and lanes.flown for lanes in told] == [(), (), (58, 40)]
    assert [lanes and lanes.way_of(0) for lanes in told] == [(58, 40, 58, 70)] * 2 + [(58, 70)]
    assert [step.route_enu_m[0][:2] for step in steps] == [(58.0, 40.0)] * 2 + [(58.0, 70.0)]


def test_a_step_that_was_not_flown_is_decided_on_again() -> None:
    situation = with_plan(10, 58, 40, 58, 70)
    lanes = LaneExplorer(None, TourExplorer(None, RANGE_M), LanesParams(first_trials=0, trials=0))
    nearly_there = replace(situation, position_enu_m=(53.0, 40.0, 3.0))
    first, second, again = (lanes.ask(asked) for asked in (situation, nearly_there, nearly_there))
    assert isinstance(first, Waypoint)
    assert isinstance(second, Waypoint)
    assert isinstance(again, Waypoint)
    assert first.position_enu_m[:2] == (54.0, 40.0)
    assert again.position_enu_m[:2] == second.position_enu_m[:2] == (57.0, 40.0)


def test_a_step_decided_on_keeps_clear_of_who_came_in_its_way() -> None:
    eastward = with_plan(10, 90, 40)
    mate = Reservation((60.0, 40.0, 3.0), (60.0, 40.0, 3.0))
    barred = replace(eastward, constraints=replace(CONSTRAINTS, separation_m=3.0, reservations=(mate,)))
    flown, turned = fly([eastward, barred])
    assert flown.position_enu_m == (54.0, 40.0, 3.0)
    assert math.dist(turned.position_enu_m, mate.start_enu_m) >= 3.0


def over(grid: Grid) -> Situation:
    """Two vehicles with a range of four metres in a corner of level ground."""
    constraints = Constraints(grid, np.zeros(grid.shape), 0.2, 4.0, 1.0)
    mates = (Teammate(1, (3.0, 1.0, 0.5)),)
    return Situation(0, (1.0, 1.0, 0.5), ElevationMap(grid), np.ones(grid.shape, dtype=bool), 4.0, constraints, mates)


@pytest.mark.parametrize(("cell_m", "by_tours"), [(2.0, False), (2.5, True)])
def test_tours_lead_where_cells_are_too_wide_for_lanes(cell_m: float, by_tours: bool) -> None:
    params = LanesParams(first_trials=100, trials=0)
    decision = LaneExplorer(None, TourExplorer(None, 4.0), params).ask(over(Grid(0.0, 0.0, cell_m, 30, 30)))
    assert isinstance(decision, Waypoint)
    assert (decision.lanes is None) == by_tours


def test_over_wide_ground_lanes_are_planned_for_what_is_near() -> None:
    params = LanesParams(first_trials=20_000, trials=0)
    decision = LaneExplorer(None, TourExplorer(None, 4.0), params).ask(over(Grid(0.0, 0.0, 1.0, 200, 200)))
    assert isinstance(decision, Waypoint)
    assert decision.lanes is not None
    bends_m = np.array([bend for way in decision.lanes.ways for bend in way]) * 0.5
    quarter_disc_m = math.sqrt(4.0 / math.pi * params.ground.window * 4.0**2 * 2)
    assert 0.5 * quarter_disc_m < bends_m.max() < quarter_disc_m + 4.0


def test_bends_beside_the_ground_are_led_to_its_edge() -> None:
    lanes = LaneExplorer(None, TourExplorer(None, RANGE_M), LanesParams(first_trials=0, trials=0))
    decision = lanes.ask(with_plan(10, 60_000, 40, 20, 65_535))
    assert isinstance(decision, Waypoint)
    assert decision.lanes is not None
    half_block_m, (east_m, north_m) = 2.0, (GRID.columns * GRID.cell_m, GRID.rows * GRID.cell_m)
    (first, second) = zip(decision.lanes.way_of(0)[::2], decision.lanes.way_of(0)[1::2], strict=True)
    assert east_m - half_block_m <= first[0] < east_m
    assert north_m - half_block_m <= second[1] < north_m
    assert decision.position_enu_m[0] > START_ENU_M[0]


def test_steps_decided_on_before_tours_led_are_not_flown_after_it() -> None:
    steps = fly([with_plan(10, 90, 40)])
    lanes = LaneExplorer(None, TourExplorer(None, RANGE_M), LanesParams(first_trials=0, trials=0))
    whole, sector = with_plan(10, 90, 40), replace(with_plan(10, 90, 40), area_cells=SECTOR)
    northward = with_plan(20, 50, 75)
    before, by_tours, after = (lanes.ask(situation) for situation in (whole, sector, northward))
    assert before == steps[0]
    assert isinstance(by_tours, Waypoint)
    assert isinstance(after, Waypoint)
    assert by_tours.lanes is None
    assert after.position_enu_m[:2] == (50.0, 44.0)


@pytest.mark.parametrize(("east_m", "flown"), [(54.0, (56, 40)), (53.4, ())])
def test_a_bend_is_told_as_flown_when_it_is_reached_not_when_it_was_expected(
    east_m: float, flown: tuple[int, ...]
) -> None:
    lanes = LaneExplorer(None, TourExplorer(None, RANGE_M), LanesParams(first_trials=0, trials=0))
    situation = with_plan(10, 56, 40, 56, 70)
    lanes.ask(situation)
    decision = lanes.ask(replace(situation, position_enu_m=(east_m, 40.0, 3.0)))
    assert isinstance(decision, Waypoint)
    assert decision.lanes is not None
    assert decision.lanes.flown == flown
    assert decision.lanes.way_of(0) == (56, 40, 56, 70)[len(flown) :]
