"""The team's plan of lanes: which plan counts, what was flown, and what a plan that was told must hold."""

from __future__ import annotations

import dataclasses
import math

import msgspec
import numpy as np
import pytest

from vehicle_agent.domain.elevation import ElevationMap
from vehicle_agent.domain.grid import Grid
from vehicle_agent.planning.constraints import Constraints
from vehicle_agent.planning.interface import AnnouncedLanes, AnnouncedTour, Situation, Teammate
from vehicle_agent.planning.team_lanes import LanesParams, TeamLanes
from vehicle_agent.wire import messages

GRID = Grid(100.0, 200.0, 2.0, 50, 40)
RANGE_M = 16.0
FEW = LanesParams(first_trials=3_000, trials=300)


def situation(*teammates: Teammate, index: int = 0) -> Situation:
    nowhere_known = np.full(GRID.shape, math.nan)
    constraints = Constraints(GRID, nowhere_known, 3.0, 20.0, 4.0)
    area = np.ones(GRID.shape, dtype=bool)
    return Situation(index, (105.0, 205.0, 5.0), ElevationMap(GRID), area, RANGE_M, constraints, teammates)


def mate(lanes: AnnouncedLanes | None, index: int = 1) -> Teammate:
    return Teammate(index, (110.0, 205.0, 5.0), (110.0, 205.0, 5.0), 1.0, None, lanes)


def started(now: Situation) -> TeamLanes:
    lanes = TeamLanes(now, None, FEW)
    lanes.unseen_ranges2(now)
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
    late = AnnouncedLanes(mine.number + 2, 1, (0, 1), ((40, 40), (80, 80)))
    early = AnnouncedLanes(mine.number - 1, 1, (0, 1), ((20, 20), (60, 60)))
    lanes.adopt(situation(mate(early)))
    assert lanes.plan == mine
    lanes.adopt(situation(mate(early), mate(late, 2)))
    assert lanes.plan.ways == late.ways
    assert lanes.first_bend_en_m == (140.0, 240.0) == lanes.bends_en_m()[0]


def test_a_bend_that_was_flown_is_not_flown_again() -> None:
    lanes = started(situation(mate(None)))
    assert lanes.plan is not None
    way = lanes.plan.way_of(0)
    lanes.reached_first()
    assert lanes.plan.way_of(0) == way[2:]
    stale = AnnouncedLanes(lanes.plan.number + 1, 1, (0, 1), (way, ()))
    lanes.adopt(situation(mate(stale)))
    assert lanes.plan.way_of(0) == way[2:]
    assert lanes.plan.flown[-2:] == way[:2]


def test_bends_that_a_teammate_reached_are_left_out_when_the_plan_is_mended() -> None:
    lanes = started(situation(mate(None)))
    assert lanes.plan is not None
    told = AnnouncedLanes(lanes.plan.number + 1, 1, (0, 1), ((), (40, 40, 120, 40)), (40, 40))
    params = LanesParams(first_trials=0, trials=0)
    other = TeamLanes(situation(mate(told)), None, params)
    other.unseen_ranges2(situation(mate(told)))
    other.mend(situation(mate(told)))
    assert other.plan is not None
    assert other.plan.way_of(1) == (120, 40)
    assert other.plan.number == told.number + 1


def test_vehicles_that_see_differently_far_mean_the_same_places() -> None:
    mine = started(situation(mate(None)))
    assert mine.plan is not None
    now = dataclasses.replace(situation(mate(mine.plan, 0), index=1), range_m=0.4 * RANGE_M)
    other = TeamLanes(now, None, LanesParams(first_trials=0, trials=0))
    other.unseen_ranges2(now)
    other.mend(now)
    assert other.plan is not None
    assert other.plan.way_of(0) == mine.plan.way_of(0)


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
