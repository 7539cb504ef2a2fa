"""A surface vessel: always on the water, under way as soon as it is armed."""

from __future__ import annotations

import math

from sim_bridge.modes import Behaviour
from sim_bridge.vehicles.hull import Hull
from vehicle_agent.domain.frames import Point

UNDER_WAY_M = 1.0
"""Distance from where it was armed at which it has been under way."""


class Boat(Hull):
    """One surface vessel."""

    last_resort = Behaviour.BRAKE

    def height_error_m(self, upward_m: float) -> float:
        return 0.0

    def _within_reach(self, position_enu_m: Point) -> Point:
        return (position_enu_m[0], position_enu_m[1], self._bodies.water_level_m)

    def _begin(self, behaviour: Behaviour) -> None:
        if behaviour is Behaviour.RETURN and self.home_enu_m is not None:
            self.pilot.refresh_limits(self.settings.return_speed_m_s)
            self.pilot.fly_to(self._within_reach(self.return_place_enu_m()))
        elif behaviour in (Behaviour.PILOTED, Behaviour.BRAKE, Behaviour.GUIDED):
            # The motors idle: the current may carry it off, as it does with ArduRover in HOLD.
            self.pilot.rest()
        else:
            super()._begin(behaviour)

    def _steer(self, time_s: float) -> None:
        if not self.has_flown and self.home_enu_m is not None:
            here = self.pilot.position_enu_m
            self.has_flown = math.hypot(here[0] - self.home_enu_m[0], here[1] - self.home_enu_m[1]) > UNDER_WAY_M
        super()._steer(time_s)

    def _hits(self) -> bool:
        return self.armed
