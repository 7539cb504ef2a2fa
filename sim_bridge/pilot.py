"""How the copter steers in each flight mode: targets and rates for its body, step by step."""

from __future__ import annotations

import math
from enum import Enum

import numpy as np

from sim_bridge.dynamics import (
    ACCELERATION,
    BRAKING_SHARE,
    CLIMB,
    POSITION_GAIN_1_S,
    SINK,
    SPEED,
    VERTICAL_ACCELERATION,
    Bodies,
    Motion,
)
from sim_bridge.parameters import ParameterTable
from vehicle_agent.domain.frames import Point

ARRIVED_M = 0.5
"""Distance at which a climb counts as finished."""
_SLOWEST = np.array([0.1, 0.1, 0.1, 0.5, 0.5])
_FASTEST = np.array([100.0, 50.0, 50.0, 20.0, 20.0])
"""What a body can do, whatever its parameters say; columns as in `Bodies.limits`."""
MIN_CONE_SLOPE = 0.5
"""RTL_CONE_SLOPE below this is ignored, as ArduPilot does."""


class ReturnPhase(Enum):
    """Where a return stands."""

    CLIMB = "climb"
    TRAVEL = "travel"
    LOITER = "loiter"
    DESCEND = "descend"


class Pilot:
    """Drives one row of the bodies.

    Attributes
    ----------
    taking_off
        True from the order to climb until the height is reached.
    return_phase
        Where a return stands; None outside of one.
    commanded_speed_m_s
        Speed asked for during this flight mode; None: WPNAV_SPEED.
    """

    __slots__ = (
        "_bodies", "_index", "_loiter_until_s", "_parameters", "_return_to", "_return_up_m", "commanded_speed_m_s",
        "return_phase", "taking_off",
    )  # fmt: skip

    def __init__(self, bodies: Bodies, index: int, parameters: ParameterTable) -> None:
        self._bodies = bodies
        self._index = index
        self._parameters = parameters
        self._return_to: Point = (0.0, 0.0, 0.0)
        self._return_up_m = 0.0
        self._loiter_until_s = math.inf
        self.taking_off = False
        self.return_phase: ReturnPhase | None = None
        self.commanded_speed_m_s: float | None = None
        self.refresh_limits()

    @property
    def position_enu_m(self) -> Point:
        east, north, up = self._bodies.position_enu_m[self._index].tolist()
        return (east, north, up)

    @property
    def velocity_enu_m_s(self) -> Point:
        east, north, up = self._bodies.velocity_enu_m_s[self._index].tolist()
        return (east, north, up)

    @property
    def target_enu_m(self) -> Point | None:
        """Where the body is flying to; None unless it flies to a point."""
        if self._bodies.motion[self._index] != Motion.POSITION:
            return None
        east, north, up = self._bodies.target[self._index].tolist()
        return (east, north, up)

    @property
    def flies_with_velocity(self) -> bool:
        return bool(self._bodies.motion[self._index] == Motion.VELOCITY)

    def height_above_ground_m(self) -> float:
        return float(self._bodies.position_enu_m[self._index, 2] - self._bodies.ground_m[self._index])

    def refresh_limits(self) -> None:
        """Take speeds and accelerations from the parameters (centimetres) and the commanded speed."""
        parameters, limits = self._parameters, self._bodies.limits[self._index]
        speed = parameters["WPNAV_SPEED"] / 100.0
        if self.return_phase is not None and parameters["RTL_SPEED"] > 0:
            speed = parameters["RTL_SPEED"] / 100.0
        limits[SPEED] = speed if self.commanded_speed_m_s is None else self.commanded_speed_m_s
        limits[CLIMB] = parameters["WPNAV_SPEED_UP"] / 100.0
        limits[SINK] = parameters["WPNAV_SPEED_DN"] / 100.0
        limits[ACCELERATION] = parameters["WPNAV_ACCEL"] / 100.0
        limits[VERTICAL_ACCELERATION] = parameters["WPNAV_ACCEL_Z"] / 100.0
        np.clip(limits, _SLOWEST, _FASTEST, out=limits)

    def begin_mode(self) -> None:
        """Forget what belonged to the flight mode before this one."""
        self.taking_off = False
        self.return_phase = None
        self.commanded_speed_m_s = None
        self.refresh_limits()

    def rest(self) -> None:
        """Stop pulling: the body stands, or falls."""
        self._bodies.motion[self._index] = Motion.OFF

    def fly_to(self, target_enu_m: Point) -> None:
        self._bodies.motion[self._index] = Motion.POSITION
        self._bodies.target[self._index] = target_enu_m

    def fly_with(self, velocity_enu_m_s: Point) -> None:
        self._bodies.motion[self._index] = Motion.VELOCITY
        self._bodies.target[self._index] = velocity_enu_m_s

    def climb_to(self, up_m: float) -> None:
        """Begin a take-off straight up."""
        east_m, north_m, _ = self.position_enu_m
        self.taking_off = True
        self.fly_to((east_m, north_m, up_m))

    def stop(self) -> None:
        """Brake and stay where braking ends."""
        self.fly_to(self._stopping_point())

    def _stopping_point(self) -> Point:
        position = self._bodies.position_enu_m[self._index]
        velocity = self._bodies.velocity_enu_m_s[self._index]
        limits = self._bodies.limits[self._index]
        point = position.copy()
        pace = float(np.hypot(velocity[0], velocity[1]))
        if pace > 0.0:
            point[:2] += velocity[:2] / pace * _stopping_distance_m(pace, float(limits[ACCELERATION]))
        sink = float(velocity[2])
        point[2] += math.copysign(_stopping_distance_m(abs(sink), float(limits[VERTICAL_ACCELERATION])), sink)
        east, north, up = point.tolist()
        return (east, north, up)

    def begin_landing(self) -> None:
        """Land where braking ends."""
        self._bodies.target[self._index] = self._stopping_point()
        self.descend()

    def descend(self) -> None:
        """Sink towards the ground, slowing down to LAND_SPEED at LAND_ALT_LOW as a rangefinder would have it."""
        parameters, limits = self._parameters, self._bodies.limits[self._index]
        touchdown = max(0.1, parameters["LAND_SPEED"] / 100.0)
        fastest = parameters["LAND_SPEED_HIGH"] / 100.0 or parameters["WPNAV_SPEED_DN"] / 100.0
        above_m = max(0.0, self.height_above_ground_m() - parameters["LAND_ALT_LOW"] / 100.0)
        braking = BRAKING_SHARE * float(limits[VERTICAL_ACCELERATION])
        rate = max(touchdown, min(fastest, math.sqrt(touchdown**2 + 2.0 * braking * above_m)))
        limits[SINK] = min(rate, float(_FASTEST[SINK]))
        self._bodies.motion[self._index] = Motion.DESCEND

    def begin_return(self, home_enu_m: Point) -> None:
        """Begin ArduPilot's RTL: climb to max(here, home + RTL_ALT), less close to home by RTL_CONE_SLOPE."""
        parameters = self._parameters
        east_m, north_m, _ = self._stopping_point()
        here_m = self.position_enu_m[2] - home_enu_m[2]
        lowest_m = max(0.0, here_m + max(0.0, parameters["RTL_CLIMB_MIN"] / 100.0))
        height_m = max(lowest_m, parameters["RTL_ALT"] / 100.0)
        slope = parameters["RTL_CONE_SLOPE"]
        if slope >= MIN_CONE_SLOPE:
            distance_m = math.hypot(east_m - home_enu_m[0], north_m - home_enu_m[1])
            height_m = min(height_m, max(distance_m * slope, lowest_m))
        self._return_to = home_enu_m
        self._return_up_m = home_enu_m[2] + height_m
        self._loiter_until_s = math.inf
        self.return_phase = ReturnPhase.CLIMB
        self.refresh_limits()
        self.fly_to((east_m, north_m, self._return_up_m))

    def fly_return(self, time_s: float) -> None:
        """Carry a return on by one step."""
        east_m, north_m, up_m = self.position_enu_m
        home_east_m, home_north_m, _ = self._return_to
        if self.return_phase is ReturnPhase.CLIMB and abs(up_m - self._return_up_m) < ARRIVED_M:
            self.return_phase = ReturnPhase.TRAVEL
            self.fly_to((home_east_m, home_north_m, self._return_up_m))
        elif self.return_phase is ReturnPhase.TRAVEL:
            if math.hypot(east_m - home_east_m, north_m - home_north_m) < self._parameters["WPNAV_RADIUS"] / 100.0:
                self.return_phase = ReturnPhase.LOITER
                self._loiter_until_s = time_s + self._parameters["RTL_LOIT_TIME"] / 1000.0
        elif self.return_phase is ReturnPhase.LOITER and time_s >= self._loiter_until_s:
            self.return_phase = ReturnPhase.DESCEND
        if self.return_phase is ReturnPhase.DESCEND:
            self.descend()


def _stopping_distance_m(speed_m_s: float, acceleration_m_s2: float) -> float:
    """Distance at which the approach law asks for just this speed."""
    braking = BRAKING_SHARE * acceleration_m_s2
    knee_m = braking / POSITION_GAIN_1_S**2
    if speed_m_s < knee_m * POSITION_GAIN_1_S:
        return speed_m_s / POSITION_GAIN_1_S
    return speed_m_s**2 / (2.0 * braking) + 0.5 * knee_m
