"""An underwater vehicle: dives from the surface, keeps its depth, has a position fix only at the surface."""

from __future__ import annotations

from dataclasses import dataclass

from sim_bridge.modes import Behaviour
from sim_bridge.navigation import FIX_DEPTH_M
from sim_bridge.vehicles.hull import Hull
from vehicle_agent.domain.frames import Point

DIVED_M = 0.5
"""Depth at which it has been under way."""


@dataclass(slots=True)
class BottomTracking:
    """How far following the ground has come.

    Attributes
    ----------
    distance_m
        To be kept; None until there was a reading deep enough.
    reading_m
        That was followed last.
    waiting
        For a reading, or to be deep enough.
    """

    distance_m: float | None = None
    reading_m: float | None = None
    waiting: bool = False


class Submarine(Hull):
    """One underwater vehicle; at the water's surface its relative altitude is 0."""

    last_resort = Behaviour.SURFACE

    def _fit_out(self) -> None:
        super()._fit_out()
        self._tracking = BottomTracking()

    @property
    def depth_m(self) -> float:
        """Below the water's surface, as its pressure sensor has it."""
        return self._bodies.water_level_m - float(self._bodies.position_enu_m[self.index, 2])

    @property
    def has_fix(self) -> bool:
        return super().has_fix and self.depth_m <= FIX_DEPTH_M

    def _within_reach(self, position_enu_m: Point) -> Point:
        return (*position_enu_m[:2], min(position_enu_m[2], self._bodies.water_level_m))

    def _begin(self, behaviour: Behaviour) -> None:
        if behaviour is Behaviour.SURFACE:
            self.pilot.fly_with((0.0, 0.0, self.settings.climb_m_s))
        elif behaviour is Behaviour.DEPTH_HOLD:
            self.pilot.keep_height()
        elif behaviour is Behaviour.TRACK_BOTTOM:
            self._tracking = BottomTracking()
            self.pilot.keep_height()
        elif behaviour is Behaviour.PILOTED:
            self.pilot.rest()
        else:
            super()._begin(behaviour)

    def _steer(self, time_s: float) -> None:
        if not self.has_flown:
            self.has_flown = self.depth_m > DIVED_M
        if self.behaviour is Behaviour.TRACK_BOTTOM and self.battery.remaining > 0.0:
            self._track_bottom()
        else:
            super()._steer(time_s)

    def _track_bottom(self) -> None:
        """Follow the ground at the distance from it at which following began; without a reading keep the depth."""
        tracking, distance_m = self._tracking, self.ground_distance_m()
        if distance_m is None or (tracking.distance_m is None and self.depth_m < self.settings.bottom_tracking_depth_m):
            if not tracking.waiting:
                tracking.waiting = True
                self.pilot.keep_height()
                self.say(
                    4,
                    "waiting for a rangefinder reading"
                    if distance_m is None
                    else f"descend below {self.settings.bottom_tracking_depth_m:g} meters to hold range",
                )
            return
        tracking.waiting = False
        if tracking.distance_m is None:
            tracking.distance_m = distance_m
            self.say(6, f"rangefinder target is {distance_m:.2f} m")
        if distance_m != tracking.reading_m:
            tracking.reading_m = distance_m
            self.pilot.keep_height_at(self.pilot.position_enu_m[2] - distance_m + tracking.distance_m)

    def _hits(self) -> bool:
        return self.armed
