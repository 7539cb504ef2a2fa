"""ArduCopter's return: climb, fly home, loiter, land."""

from __future__ import annotations

import math
from enum import Enum

from sim_bridge.pilot import ARRIVED_M, Pilot
from vehicle_agent.domain.frames import Point

MIN_CONE_SLOPE = 0.5
"""RTL_CONE_SLOPE below this is ignored, as ArduPilot does."""


class ReturnPhase(Enum):
    """Where a return stands."""

    CLIMB = "climb"
    TRAVEL = "travel"
    LOITER = "loiter"
    DESCEND = "descend"


class ReturnFlight:
    """One return of one copter.

    Attributes
    ----------
    phase
        Where it stands.
    """

    __slots__ = ("_home_enu_m", "_loiter_until_s", "_pilot", "_up_m", "phase")

    def __init__(self, pilot: Pilot, home_enu_m: Point) -> None:
        """Begin: climb to max(here, home + return height), less close to home by the cone's slope."""
        settings = pilot.settings
        east_m, north_m, _ = pilot.stopping_point()
        here_m = pilot.position_enu_m[2] - home_enu_m[2]
        lowest_m = max(0.0, here_m + max(0.0, settings.return_climb_min_m))
        height_m = max(lowest_m, settings.return_height_m)
        slope = settings.return_cone_slope
        if slope >= MIN_CONE_SLOPE:
            distance_m = math.hypot(east_m - home_enu_m[0], north_m - home_enu_m[1])
            height_m = min(height_m, max(distance_m * slope, lowest_m))
        self._pilot = pilot
        self._home_enu_m = home_enu_m
        self._up_m = home_enu_m[2] + height_m
        self._loiter_until_s = math.inf
        self.phase = ReturnPhase.CLIMB
        pilot.refresh_limits(settings.return_speed_m_s)
        pilot.fly_to((east_m, north_m, self._up_m))

    def fly(self, time_s: float) -> None:
        """Carry on by one step."""
        pilot = self._pilot
        east_m, north_m, up_m = pilot.position_enu_m
        home_east_m, home_north_m, _ = self._home_enu_m
        if self.phase is ReturnPhase.CLIMB and abs(up_m - self._up_m) < ARRIVED_M:
            self.phase = ReturnPhase.TRAVEL
            pilot.fly_to((home_east_m, home_north_m, self._up_m))
        elif self.phase is ReturnPhase.TRAVEL:
            if math.hypot(east_m - home_east_m, north_m - home_north_m) < pilot.settings.arrival_radius_m:
                self.phase = ReturnPhase.LOITER
                self._loiter_until_s = time_s + pilot.settings.return_loiter_s
        elif self.phase is ReturnPhase.LOITER and time_s >= self._loiter_until_s:
            self.phase = ReturnPhase.DESCEND
        if self.phase is ReturnPhase.DESCEND:
            pilot.descend()
