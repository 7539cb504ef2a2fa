"""How a vehicle steers: targets and limits for its body. Positions are those it believes in, not the true ones."""

from __future__ import annotations

import math

import numpy as np

from sim_bridge.dynamics import (
    ACCELERATION,
    BRAKING_SHARE,
    CLIMB,
    POSITION_GAIN_1_S,
    SINK,
    SPEED,
    TURN_RADIUS,
    VERTICAL_ACCELERATION,
    Bodies,
    Motion,
)
from sim_bridge.personality import Settings
from vehicle_agent.domain.frames import Point

ARRIVED_M = 0.5
"""Distance at which a climb counts as finished."""
_SLOWEST = np.array([0.1, 0.1, 0.1, 0.1, 0.1, 0.0])
_FASTEST = np.array([100.0, 50.0, 50.0, 20.0, 20.0, 1000.0])
"""What a body can do, whatever its parameters say; columns as in `Bodies.limits`."""


class Pilot:
    """Drives one row of the bodies.

    Attributes
    ----------
    settings
        Limits from the parameters; call `refresh_limits` after setting them.
    taking_off
        True from the order to climb until the height is reached.
    commanded_speed_m_s
        Speed asked for during this flight mode; None: that of the settings.
    broken
        Its motors no longer pull, whatever is asked.
    """

    __slots__ = ("_bodies", "_index", "broken", "commanded_speed_m_s", "settings", "taking_off")

    def __init__(self, bodies: Bodies, index: int, settings: Settings) -> None:
        self._bodies = bodies
        self._index = index
        self.settings = settings
        self.taking_off = False
        self.broken = False
        self.commanded_speed_m_s: float | None = None
        self.refresh_limits()

    @property
    def position_enu_m(self) -> Point:
        """Where it believes to be."""
        true, error = self._bodies.position_enu_m[self._index].tolist(), self._bodies.error_m[self._index].tolist()
        return (true[0] + error[0], true[1] + error[1], true[2] + error[2])

    @property
    def velocity_enu_m_s(self) -> Point:
        east, north, up = self._bodies.velocity_enu_m_s[self._index].tolist()
        return (east, north, up)

    @property
    def target_enu_m(self) -> Point | None:
        """Where the body is going to; None unless it goes to a point."""
        if self._bodies.motion[self._index] != Motion.POSITION:
            return None
        east, north, up = self._bodies.target[self._index].tolist()
        return (east, north, up)

    @property
    def flies_with_velocity(self) -> bool:
        return bool(self._bodies.motion[self._index] == Motion.VELOCITY)

    def height_above_ground_m(self) -> float:
        return float(self._bodies.position_enu_m[self._index, 2] - self._bodies.ground_m[self._index])

    def refresh_limits(self, speed_m_s: float = 0.0) -> None:
        """Take limits from the settings, the commanded speed, or a speed that a manoeuvre asks for (0: none)."""
        settings, limits = self.settings, self._bodies.limits[self._index]
        limits[SPEED] = self.commanded_speed_m_s or speed_m_s or settings.speed_m_s
        limits[CLIMB] = settings.climb_m_s
        limits[SINK] = settings.sink_m_s
        limits[ACCELERATION] = settings.acceleration_m_s2
        limits[VERTICAL_ACCELERATION] = settings.vertical_acceleration_m_s2
        limits[TURN_RADIUS] = settings.turn_radius_m
        np.clip(limits, _SLOWEST, _FASTEST, out=limits)

    def begin_mode(self) -> None:
        """Forget what belonged to the flight mode before this one."""
        self.taking_off = False
        self.commanded_speed_m_s = None
        self.refresh_limits()

    def _move(self, motion: Motion) -> None:
        self._bodies.motion[self._index] = Motion.OFF if self.broken else motion

    def rest(self) -> None:
        """Stop pulling: the body stands, falls or drifts."""
        self._move(Motion.OFF)

    def fly_to(self, target_enu_m: Point) -> None:
        self._move(Motion.POSITION)
        self._bodies.target[self._index] = target_enu_m

    def fly_with(self, velocity_enu_m_s: Point) -> None:
        self._move(Motion.VELOCITY)
        self._bodies.target[self._index] = velocity_enu_m_s

    def keep_height(self) -> None:
        """Keep the present height and drift."""
        self.keep_height_at(self.position_enu_m[2])

    def keep_height_at(self, up_m: float) -> None:
        """Go to a height, keep it and drift."""
        self._bodies.target[self._index] = (*self.position_enu_m[:2], up_m)
        self._move(Motion.KEEP_HEIGHT)

    def climb_to(self, up_m: float) -> None:
        """Begin a take-off straight up."""
        east_m, north_m, _ = self.position_enu_m
        self.taking_off = True
        self.fly_to((east_m, north_m, up_m))

    def stop(self) -> None:
        """Brake and stay where braking ends."""
        self.fly_to(self.stopping_point())

    def stopping_point(self) -> Point:
        """Where it would come to rest by braking now."""
        velocity = self._bodies.velocity_enu_m_s[self._index]
        limits = self._bodies.limits[self._index]
        point = np.array(self.position_enu_m)
        pace = float(np.hypot(velocity[0], velocity[1]))
        if pace > 0.0:
            point[:2] += velocity[:2] / pace * _stopping_distance_m(pace, float(limits[ACCELERATION]))
        sink = float(velocity[2])
        point[2] += math.copysign(_stopping_distance_m(abs(sink), float(limits[VERTICAL_ACCELERATION])), sink)
        east, north, up = point.tolist()
        return (east, north, up)

    def begin_landing(self) -> None:
        """Land where braking ends."""
        self._bodies.target[self._index] = self.stopping_point()
        self.descend()

    def descend(self) -> None:
        """Sink towards the ground, slowing down to the touchdown speed as a rangefinder would have it."""
        settings, limits = self.settings, self._bodies.limits[self._index]
        touchdown = max(0.1, settings.land_speed_m_s)
        fastest = settings.land_speed_high_m_s or settings.sink_m_s
        above_m = max(0.0, self.height_above_ground_m() - settings.land_slow_below_m)
        braking = BRAKING_SHARE * float(limits[VERTICAL_ACCELERATION])
        rate = max(touchdown, min(fastest, math.sqrt(touchdown**2 + 2.0 * braking * above_m)))
        limits[SINK] = min(rate, float(_FASTEST[SINK]))
        self._move(Motion.DESCEND)


def _stopping_distance_m(speed_m_s: float, acceleration_m_s2: float) -> float:
    """Distance at which the approach law asks for just this speed."""
    braking = BRAKING_SHARE * acceleration_m_s2
    knee_m = braking / POSITION_GAIN_1_S**2
    if speed_m_s < knee_m * POSITION_GAIN_1_S:
        return speed_m_s / POSITION_GAIN_1_S
    return speed_m_s**2 / (2.0 * braking) + 0.5 * knee_m
