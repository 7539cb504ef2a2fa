"""Flying one straight leg: when it counts as flown, and where a vehicle comes to rest if it brakes now."""

from __future__ import annotations

import math
from dataclasses import dataclass

from vehicle_agent.domain.frames import Point, as_array
from vehicle_agent.domain.segments import segment_distance_m
from vehicle_agent.ports import VehicleState

ARRIVED_M = 4.0
SLOW_M_S = 4.0
SOON_S = 3.0
"""So long before it would brake a vehicle begins to think of the next leg."""
DECELERATION_M_S2 = 2.0
"""What a multicopter brakes with comfortably; ArduCopter's WPNAV_ACCEL is 2.5."""
SHARP_TURN_COSINE = 0.6
HARDLY_M = 2.0
"""So little beside a leg counts as on it."""


@dataclass(frozen=True, slots=True)
class Leg:
    """A straight leg that the vehicle has reserved and been told to fly.

    Attributes
    ----------
    end_enu_m
        Where it ends.
    why
        For a person to read.
    """

    end_enu_m: Point
    why: str


def is_flown(leg: Leg, state: VehicleState) -> bool:
    """Arrived and slow."""
    return math.dist(leg.end_enu_m, state.position_enu_m) <= ARRIVED_M and speed_m_s(state) <= SLOW_M_S


def is_ending(leg: Leg, state: VehicleState) -> bool:
    """So near to the end that the vehicle is about to brake: time to decide what comes next."""
    return math.dist(leg.end_enu_m, state.position_enu_m) <= ARRIVED_M + braking_distance_m(state)


def will_end_soon(leg: Leg, state: VehicleState) -> bool:
    """Whether it will be ending within a few seconds: time to think of what comes next."""
    return math.dist(leg.end_enu_m, state.position_enu_m) <= (
        ARRIVED_M + braking_distance_m(state) + SOON_S * speed_m_s(state)
    )


def turns_sharply(state: VehicleState, end_enu_m: Point) -> bool:
    """Whether going there at once would throw a fast vehicle far off both legs."""
    speed = speed_m_s(state)
    away = math.dist(end_enu_m, state.position_enu_m)
    if speed <= SLOW_M_S or away == 0.0:
        return False
    along = sum(v * (e - p) for v, e, p in zip(state.velocity_enu_m_s, end_enu_m, state.position_enu_m, strict=True))
    return along < SHARP_TURN_COSINE * speed * away


def swing(here: Point, rest: Point, end_enu_m: Point) -> tuple[tuple[Point, Point], ...]:
    """Lines beside a leg between which a vehicle is carried that turns into it in flight; none where it hardly is.

    Parameters
    ----------
    here, rest
        Where it is, and where it would come to rest if it braked now.
    """
    at = as_array(rest)
    if segment_distance_m(at, at, as_array(here), as_array(end_enu_m)) <= HARDLY_M:
        return ()
    return ((here, rest), (rest, end_enu_m))


def speed_m_s(state: VehicleState) -> float:
    return math.hypot(*state.velocity_enu_m_s)


def braking_distance_m(state: VehicleState) -> float:
    return speed_m_s(state) ** 2 / (2.0 * DECELERATION_M_S2)


def stopping_point(state: VehicleState) -> Point:
    """Where the vehicle comes to rest if it brakes now, ENU metres."""
    return resting_place(state.position_enu_m, state.velocity_enu_m_s)


def resting_place(position_enu_m: Point, velocity_enu_m_s: Point) -> Point:
    """As `stopping_point`, of any vehicle."""
    reach_s = math.hypot(*velocity_enu_m_s) / (2.0 * DECELERATION_M_S2)
    east, north, up = (p + reach_s * v for p, v in zip(position_enu_m, velocity_enu_m_s, strict=True))
    return (east, north, up)
