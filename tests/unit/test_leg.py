"""When a leg is flown, and where a vehicle comes to rest."""

from __future__ import annotations

import pytest

from vehicle_agent.behaviour.leg import Leg, braking_distance_m, is_ending, is_flown, stopping_point, turns_sharply
from vehicle_agent.domain.frames import Point
from vehicle_agent.ports import VehicleState

LEG = Leg((100.0, 0.0, 50.0), "")


def state(position: Point, velocity: Point = (0.0, 0.0, 0.0)) -> VehicleState:
    return VehicleState(stamp_ms=0, position_enu_m=position, velocity_enu_m_s=velocity)


def test_a_leg_is_flown_when_the_vehicle_is_there_and_slow() -> None:
    assert is_flown(LEG, state((98.0, 1.0, 50.0), (1.0, 0.0, 0.0)))
    assert not is_flown(LEG, state((98.0, 1.0, 50.0), (10.0, 0.0, 0.0)))
    assert not is_flown(LEG, state((80.0, 0.0, 50.0)))
    assert not is_flown(LEG, state((100.0, 0.0, 60.0)))


def test_a_leg_ends_where_braking_begins() -> None:
    fast = (10.0, 0.0, 0.0)  # 25 m to rest
    assert is_ending(LEG, state((75.0, 0.0, 50.0), fast))
    assert not is_ending(LEG, state((60.0, 0.0, 50.0), fast))


def test_it_comes_to_rest_ahead_of_itself() -> None:
    assert stopping_point(state((0.0, 0.0, 50.0), (0.0, 12.0, 0.0))) == pytest.approx((0.0, 36.0, 50.0))
    assert stopping_point(state((1.0, 2.0, 3.0))) == (1.0, 2.0, 3.0)
    assert braking_distance_m(state((0.0, 0.0, 0.0), (3.0, 4.0, 0.0))) == pytest.approx(6.25)


@pytest.mark.parametrize(
    ("velocity", "end", "sharp"),
    [
        ((10.0, 0.0, 0.0), (100.0, 0.0, 50.0), False),
        ((10.0, 0.0, 0.0), (100.0, 40.0, 50.0), False),
        ((10.0, 0.0, 0.0), (0.0, 100.0, 50.0), True),
        ((10.0, 0.0, 0.0), (-100.0, 0.0, 50.0), True),
        ((2.0, 0.0, 0.0), (-100.0, 0.0, 50.0), False),  # slow enough for any turn
        ((10.0, 0.0, 0.0), (0.0, 0.0, 50.0), False),  # it is there
    ],
)
def test_sharp_turns(velocity: Point, end: Point, sharp: bool) -> None:
    assert turns_sharply(state((0.0, 0.0, 50.0), velocity), end) is sharp
