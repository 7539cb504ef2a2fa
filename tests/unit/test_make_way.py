"""Between buildings and under water, too, nobody rests in a teammate's way up or down, or goes through one."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.fakes.map_missions import map_plan
from tests.fakes.town_missions import town_plan
from tests.fakes.town_navigators import OVER_THE_STREET, navigator_over_a_street
from vehicle_agent.behaviour.depth_navigator import DepthNavigator
from vehicle_agent.behaviour.guide import Surroundings
from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.segments import segment_distance_m
from vehicle_agent.planning.constraints import Reservation
from vehicle_agent.ports import VehicleState
from vehicle_agent.survey_agent import SurveyAgent


def surroundings(place: Point, now_s: float, passages: tuple[Reservation, ...]) -> Surroundings:
    state = VehicleState(stamp_ms=round(now_s * 1000), position_enu_m=place)
    return Surroundings(now_s, state, 1, (), passages, passages, 0.0)


def away_m(place: Point, leg: Reservation) -> float:
    at = np.array(place)
    return segment_distance_m(at, at, np.array(leg.start_enu_m), np.array(leg.end_enu_m))


def test_over_a_street_a_vehicle_makes_way_and_goes_on_when_its_teammate_is_down() -> None:
    navigator, here = navigator_over_a_street(), OVER_THE_STREET
    separation_m = town_plan().mission.safety.separation_m
    column = Reservation((10.0, 4.0, 18.0), (10.0, 4.0, 0.0), 1, has_way=True)
    now_s = 1.0
    for _ in range(20):
        target = navigator.work(surroundings(here, now_s, (column,)))
        assert navigator.leg is not None
        if isinstance(target, tuple):
            here = target
        now_s += 3.0
        if away_m(here, column) >= separation_m:
            break
    assert "makes way for copter-1" in navigator.why
    assert away_m(here, column) >= separation_m
    for _ in range(20):
        navigator.work(surroundings(here, now_s, ()))
        now_s += 3.0
    assert "makes way" not in navigator.why


@pytest.mark.parametrize("taken", [False, True])
def test_a_submarine_comes_up_for_a_fix_only_where_nobody_is_above(taken: bool) -> None:
    plan = map_plan()
    agent = SurveyAgent(plan, 1, 5, np.random.default_rng(0))
    navigator = agent._flight.navigator
    assert isinstance(navigator, DepthNavigator)
    surface_m = plan.mission.simulation.water_level_m
    here: Point = (20.0, 20.0, surface_m - 3.5)
    while not agent._drift.is_worth_a_fix():
        agent._drift.watch(agent._now_s, VehicleState(stamp_ms=0, position_enu_m=here))
        agent._now_s += 1.0
    above: Point = (20.0, 20.5, surface_m - 1.0)
    mates = (Reservation(above, above, 0),) if taken else ()
    around = replace(surroundings(here, agent._now_s, ()), reservations=mates)
    target = navigator.work(around)
    assert isinstance(target, tuple)
    comes_up = math.isclose(target[2], surface_m, abs_tol=0.2)
    assert comes_up is not taken
