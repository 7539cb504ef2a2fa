"""Between buildings, too, a leg that a teammate might cross is told first, and flown once that teammate was heard."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sim_bridge.world import World
from tests.fakes.town_missions import town_plan
from tests.fakes.town_navigators import OVER_THE_STREET, navigator_over_a_street
from vehicle_agent.behaviour.guide import Surroundings
from vehicle_agent.behaviour.intent import Whereabouts
from vehicle_agent.domain.frames import Point
from vehicle_agent.planning.constraints import Reservation
from vehicle_agent.planning.interface import Finished, Teammate
from vehicle_agent.ports import SensorScan, VehicleState

HERE = OVER_THE_STREET
BESIDE: Point = (20.0, 4.5, 12.5)
BEGAN_S = 100.0


def around(now_s: float, here: Point = HERE, *mates: Whereabouts, legs: tuple[Reservation, ...] = ()) -> Surroundings:
    state = VehicleState(stamp_ms=round(now_s * 1000), position_enu_m=here)
    return Surroundings(now_s, state, 1, (), legs, (), 0.0, mates)


def mate(said_s: float, place: Point = BESIDE) -> Whereabouts:
    return Whereabouts(1, round(said_s * 1000), said_s, ((place, place),))


def test_a_leg_near_a_teammate_is_flown_once_its_later_word_came() -> None:
    navigator = navigator_over_a_street()
    assert navigator.work(around(BEGAN_S, HERE, mate(BEGAN_S - 0.1))) is None
    assert navigator.intent is not None
    intended = navigator.intent.leg.end_enu_m
    for late_s in (1.0, 2.0, 3.0):
        assert navigator.work(around(BEGAN_S + late_s, HERE, mate(BEGAN_S - 0.1))) is None
    assert "waits to hear copter-1" in navigator.why
    assert navigator.work(around(BEGAN_S + 3.2, HERE, mate(BEGAN_S + 0.1))) == intended
    assert navigator.intent is None
    assert navigator.leg is not None
    assert "waits" not in navigator.why


@pytest.mark.parametrize("mates", [(), (mate(BEGAN_S - 0.1, (90.0, 90.0, 12.5)),)], ids=["alone", "far off"])
def test_with_nobody_near_nobody_waits(mates: tuple[Whereabouts, ...]) -> None:
    navigator = navigator_over_a_street()
    assert navigator.work(around(BEGAN_S, HERE, *mates)) is not None
    assert navigator.intent is None


def test_a_silent_teammate_is_not_waited_for_for_ever() -> None:
    navigator = navigator_over_a_street()
    assert navigator.work(around(BEGAN_S, HERE, mate(BEGAN_S - 0.1))) is None
    assert navigator.work(around(BEGAN_S + 15.0)) is not None  # it counts as lost: nobody tells where it is


@pytest.mark.parametrize(("their_since_s", "flies"), [(BEGAN_S - 0.5, False), (BEGAN_S + 0.5, True)])
def test_of_two_intents_that_cross_the_earlier_has_the_way(their_since_s: float, flies: bool) -> None:
    navigator = navigator_over_a_street()
    assert navigator.work(around(BEGAN_S, HERE, mate(BEGAN_S - 1.0))) is None
    assert navigator.intent is not None
    end = navigator.intent.leg.end_enu_m
    across = Reservation((end[0], end[1], end[2] + 9.0), end, 1, since_ms=round(their_since_s * 1000))
    target = navigator.work(around(BEGAN_S + 1.0, HERE, mate(BEGAN_S + 0.9), legs=(across,)))
    assert (target == end) is flies
    assert navigator.intent is None


def test_who_flies_does_not_stop_for_who_only_means_to() -> None:
    navigator = navigator_over_a_street()
    end = navigator.work(around(BEGAN_S))
    assert isinstance(end, tuple)
    across = Reservation((end[0], end[1], end[2] + 9.0), end, 1, since_ms=round(BEGAN_S * 1000))
    assert navigator.work(around(BEGAN_S + 1.0, legs=(across,))) is None
    assert navigator.work(around(BEGAN_S + 2.0, legs=(replace(across, owner_index=-1, since_ms=0),))) is not None
    assert "making room" in navigator.why


def test_a_teammate_that_claims_a_goal_and_gets_nowhere_is_not_waited_for_for_ever() -> None:
    """Word that it had nothing left to look at was lost."""
    navigator = navigator_over_a_street()
    navigator.limit(np.ones((40, 40), dtype=np.bool_), np.zeros((40, 40), dtype=np.bool_), None)  # nothing to look at
    now_s, moved_until_s = BEGAN_S, BEGAN_S + 60.0
    ended: Point | Finished | None = None
    while not isinstance(ended, Finished) and now_s < BEGAN_S + 200.0:
        place = (20.0, 4.5 + min(now_s, moved_until_s) - BEGAN_S, 12.5)
        looking = Teammate(1, place, (20.0, 100.0, 0.0))
        ended = navigator.work(replace(around(now_s), teammates=(looking,)))
        now_s += 2.0
    assert isinstance(ended, Finished)
    assert now_s > moved_until_s


def test_who_sees_under_way_what_it_went_for_stops_and_turns_to_the_next() -> None:
    navigator = navigator_over_a_street()
    end = navigator.work(around(BEGAN_S))
    assert isinstance(end, tuple)
    way = np.subtract(end, HERE)
    length_m = float(np.linalg.norm(way))
    assert length_m > 4.0
    plan = town_plan()
    town = World.of(plan).town
    assert town is not None
    navigator._shared.take_scan(SensorScan(town.scan(end, 10.0, 10)))
    everywhere, behind = np.ones((40, 40), dtype=np.bool_), np.zeros((40, 40), dtype=np.bool_)
    behind[:6] = True
    navigator.limit(everywhere, behind, None)  # what is left to be looked at lies the other way
    east_m, north_m, up_m = (np.array(HERE) + 0.5 * way / length_m).tolist()
    moving = VehicleState(
        stamp_ms=round(1000 * BEGAN_S) + 500,
        position_enu_m=(east_m, north_m, up_m),
        velocity_enu_m_s=tuple((2.0 * way / length_m).tolist()),
    )
    rest = navigator.work(replace(around(BEGAN_S + 0.5), state=moving))
    assert isinstance(rest, tuple)
    assert np.linalg.norm(np.subtract(rest, HERE)) < length_m - 1.0
