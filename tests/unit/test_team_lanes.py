"""The team's plan of lanes: which plan counts, what was flown, and what a plan that was told must hold."""

from __future__ import annotations

import dataclasses
import math

import msgspec
import numpy as np
import pytest

from vehicle_agent.domain.elevation import CellObservations, ElevationMap
from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.grid import Grid
from vehicle_agent.planning import lane_mending, team_lanes
from vehicle_agent.planning.constraints import Constraints
from vehicle_agent.planning.interface import AnnouncedLanes, AnnouncedTour, Situation, Teammate
from vehicle_agent.planning.team_lanes import LanesParams, TeamLanes
from vehicle_agent.wire import messages

GRID = Grid(100.0, 200.0, 2.0, 50, 40)
RANGE_M = 16.0
FEW = LanesParams(first_trials=3_000, trials=300)
AS_IT_IS = LanesParams(first_trials=0, trials=0)


def situation(*teammates: Teammate, index: int = 0) -> Situation:
    nowhere_known = np.full(GRID.shape, math.nan)
    constraints = Constraints(GRID, nowhere_known, 3.0, 20.0, 4.0)
    area = np.ones(GRID.shape, dtype=bool)
    return Situation(index, (105.0, 205.0, 5.0), ElevationMap(GRID), area, RANGE_M, constraints, teammates)


def mate(lanes: AnnouncedLanes | None, index: int = 1) -> Teammate:
    return Teammate(index, (110.0, 205.0, 5.0), (110.0, 205.0, 5.0), 1.0, None, lanes)


def started(now: Situation) -> TeamLanes:
    lanes = TeamLanes(now, None, FEW)
    lanes.mend(now)
    return lanes


def test_the_first_plan_is_for_all_and_stays_on_the_ground() -> None:
    lanes = started(situation(mate(None)))
    assert lanes.plan is not None
    assert lanes.plan.vehicles == (0, 1)
    for index in (0, 1):
        way = np.array(lanes.plan.way_of(index)).reshape(-1, 2)
        bends = way + np.array((100.0, 200.0))  # half cells are metres here
        assert len(bends) > 1
        assert (bends >= (100.0, 200.0)).all()
        assert (bends <= (200.0, 280.0)).all()


def test_the_plan_with_the_highest_number_counts() -> None:
    lanes = started(situation(mate(None)))
    assert lanes.plan is not None
    mine = lanes.plan
    late = AnnouncedLanes(mine.number + 2, 1, (0, 1), ((40, 40), (80, 60)))
    early = AnnouncedLanes(mine.number - 1, 1, (0, 1), ((20, 20), (60, 60)))
    other = TeamLanes(situation(mate(early), mate(late, 2)), None, AS_IT_IS)
    other.mend(situation(mate(early), mate(late, 2)))
    assert other.plan is not None
    assert (other.plan.number, other.plan.by) == (late.number + 1, 0)
    assert other.plan.ways[:2] == late.ways
    assert (other.own.bends_left, other.own.bends_en_m(1)) == (1, [(140.0, 240.0)])


def test_a_bend_that_was_flown_is_not_flown_again() -> None:
    lanes = TeamLanes(situation(mate(None)), None, AS_IT_IS)
    way = (40, 40, 80, 60)
    stale = situation(mate(AnnouncedLanes(5, 1, (0, 1), (way, ()))))
    lanes.mend(stale)
    assert lanes.plan is not None
    assert lanes.own.passing((137.0, 240.0, 5.0), 3.0) is lanes.own
    assert lanes.plan.way_of(0) == way
    lanes.own = lanes.own.passing((137.1, 240.0, 5.0), 3.0)
    assert lanes.plan.way_of(0) == way[2:]
    lanes.mend(situation(mate(AnnouncedLanes(lanes.plan.number + 1, 1, (0, 1), (way, ())))))
    assert lanes.plan.way_of(0) == way[2:]
    assert lanes.plan.flown[-2:] == way[:2]


def test_what_is_planned_for_a_teammate_begins_a_step_ahead_of_it() -> None:
    told = AnnouncedLanes(5, 1, (0, 1), ((), (17, 5, 40, 5)))  # its first bend lies 7 m ahead of it
    near, far = (
        dataclasses.replace(mate(told), goal_enu_m=(117.0, 205.0, 5.0), position_enu_m=(east_m, 205.0, 5.0))
        for east_m in (111.0, 110.0)
    )
    ways = []
    for teammate in (near, far):
        lanes = TeamLanes(situation(teammate), None, AS_IT_IS)
        lanes.mend(situation(teammate))
        assert lanes.plan is not None
        ways.append(lanes.plan.way_of(1))
    assert ways == [(40, 5), (17, 5, 40, 5)]


def test_bends_that_a_teammate_reached_are_left_out_when_the_plan_is_mended() -> None:
    lanes = started(situation(mate(None)))
    assert lanes.plan is not None
    told = AnnouncedLanes(lanes.plan.number + 1, 1, (0, 1), ((), (40, 40, 90, 40)), (40, 40))
    other = TeamLanes(situation(mate(told)), None, AS_IT_IS)
    other.mend(situation(mate(told)))
    assert other.plan is not None
    assert other.plan.way_of(1) == (90, 40)
    assert other.plan.number == told.number + 1


def test_vehicles_that_see_differently_far_mean_the_same_places() -> None:
    mine = started(situation(mate(None)))
    assert mine.plan is not None
    now = dataclasses.replace(situation(mate(mine.plan, 0), index=1), range_m=0.4 * RANGE_M)
    other = TeamLanes(now, None, AS_IT_IS)
    other.mend(now)
    assert other.plan is not None
    assert other.plan.way_of(0) == mine.plan.way_of(0)


@pytest.mark.parametrize(
    ("vehicles", "first_plans", "first_tried", "tried"),
    [(1, 2, 60, 120), (2, 3, 60, 90), (3, 3, 60, 60), (4, 4, 45, 45), (10, 10, 18, 18)],
)
def test_the_team_shares_the_changes_that_are_tried(
    monkeypatch: pytest.MonkeyPatch, vehicles: int, first_plans: int, first_tried: int, tried: int
) -> None:
    trials = []
    monkeypatch.setattr(lane_mending, "mend_lanes", lambda ways, annealing, *_: trials.append(annealing.trials))
    now = situation(*(mate(None, index) for index in range(1, vehicles)))
    lanes = TeamLanes(now, None, LanesParams(first_trials=60, trials=60, large_team=3, few_try=2))
    for _ in range(first_plans + 2):
        lanes.mend(now)
    assert trials == [first_tried] * first_plans + [tried] * 2


@pytest.mark.parametrize("reached", [False, True])
def test_where_a_bend_was_reached_what_it_did_not_show_is_not_looked_for_again(reached: bool) -> None:
    unseen = np.zeros(GRID.shape, dtype=bool)
    unseen[30:38, 20:28] = True
    team_map, cells = ElevationMap(GRID), np.flatnonzero(~unseen)
    team_map.observe(0, CellObservations(cells, np.zeros(len(cells), dtype=np.int32), 1_000 + cells))
    bend = (68, 48)  # in its middle
    told = AnnouncedLanes(1, 1, (0, 1), ((), ()), bend if reached else ())
    now = dataclasses.replace(situation(mate(told)), team_map=team_map)
    lanes = TeamLanes(now, None, FEW)
    lanes.mend(now)
    assert lanes.plan is not None
    ways = np.concatenate([np.array(way).reshape(-1, 2) for way in lanes.plan.ways])
    leads_there = bool(len(ways)) and np.hypot(*(ways - bend).T).min() < RANGE_M
    assert leads_there is not reached


PLACE: Point = (115.0, 205.0, 5.0)


def begun_for(place_enu_m: Point, now: Situation) -> TeamLanes:
    """A plan that is half mended for a decision at a place."""
    lanes = TeamLanes(now, None, FEW)
    lanes.begin(now, place_enu_m)
    assert not lanes.go_on(1_500)
    return lanes


def test_a_plan_mended_in_parts_on_the_way_is_that_mended_at_the_place() -> None:
    now = situation(mate(None))
    there = dataclasses.replace(now, position_enu_m=PLACE)
    lanes, at_once = begun_for(PLACE, now), TeamLanes(now, None, FEW)
    lanes.begin(now, PLACE)
    assert lanes.go_on(1_500)
    lanes.mend(there)
    at_once.begin(now, PLACE)
    at_once.mend(there)
    assert lanes.plan is not None
    assert lanes.plan == at_once.plan


@pytest.mark.parametrize("died", [False, True])
def test_what_was_begun_for_another_place_or_team_is_begun_anew(died: bool) -> None:
    now = situation(mate(None))
    lanes = begun_for(now.position_enu_m, now)
    if died:
        lanes.begin(situation(), now.position_enu_m)
    else:
        lanes.begin(now, PLACE)
    assert not lanes.go_on(2_999)
    assert lanes.go_on(1)


@pytest.mark.parametrize(("later", "counts"), [(0, False), (1, True)])
def test_a_newer_plan_that_was_heard_meanwhile_counts(later: int, counts: bool) -> None:
    told = AnnouncedLanes(2, 1, (0, 1), ((40, 40, 90, 40), (80, 60)))
    lanes = begun_for(situation().position_enu_m, situation(mate(told)))
    heard = dataclasses.replace(told, number=told.number + later, by=1)
    lanes.mend(situation(mate(heard)))
    assert lanes.plan is not None
    assert (lanes.plan.number, lanes.plan.by) == (3, 1 if counts else 0)
    assert (lanes.plan.way_of(0) == told.way_of(0)) is counts


def test_a_plan_of_the_last_number_keeps_nobody_from_planning() -> None:
    told = AnnouncedLanes(team_lanes.LAST_NUMBER, 1, (0, 1), ((40, 40), (80, 60)))
    lanes = started(situation(mate(told)))
    assert lanes.plan is not None
    assert lanes.plan.by == 0


def test_a_teammate_that_flies_tours_has_no_way_in_the_plan() -> None:
    tourist = dataclasses.replace(mate(None, 1), tour=AnnouncedTour(1, (3, 4)))
    lanes = started(situation(tourist, mate(None, 2)))
    assert lanes.plan is not None
    assert lanes.plan.vehicles == (0, 2)


@pytest.mark.parametrize(
    ("vehicles", "ways", "flown"),
    [((0, 1), ((1, 2),), ()), ((0, 0), ((), ()), ()), ((0,), ((1, 2, 3),), ()), ((0,), ((),), (1,))],
)
def test_a_plan_that_does_not_fit_together_is_no_message(
    vehicles: tuple[int, ...], ways: tuple[tuple[int, ...], ...], flown: tuple[int, ...]
) -> None:
    raw = msgspec.msgpack.encode((1, 0, vehicles, ways, flown))
    with pytest.raises(msgspec.ValidationError):
        msgspec.msgpack.decode(raw, type=messages.LanePlan)
