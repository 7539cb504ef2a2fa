"""How uncertain an underwater vehicle's position has become, and when a fix is worth the way to the surface."""

from __future__ import annotations

import math

from vehicle_agent.mission.sounding import DRIFT_M_S, TYPICAL_SLOPE
from vehicle_agent.ports import VehicleState

FIX_DEPTH_M = 0.45
"""An antenna deeper than this hears no satellites."""
FIXED_SD_M = 1.0
FIX_TAKES_S = 2.0
"""At the surface until the fix counts."""


class Drift:
    """Counts the time without a fix (t_uw of Kapoutsis 2015, eq. 4).

    Parameters
    ----------
    surface_up_m
        ENU z of the water's surface.
    dive_s
        Time from the surface to the working depth and back.
    sound_sd_m
        Standard deviation of a sounding with a perfect position.

    Attributes
    ----------
    unfixed_s
        Seconds since the last fix.
    """

    def __init__(self, surface_up_m: float, dive_s: float, sound_sd_m: float) -> None:
        self.unfixed_s = 0.0
        self._surface_up_m = surface_up_m
        self._cycle_s = dive_s + FIX_TAKES_S
        self._scale_s = sound_sd_m / (DRIFT_M_S * TYPICAL_SLOPE)
        self._fixed_at_s: float | None = None
        self._up_since_s: float | None = None

    @property
    def position_sd_m(self) -> float:
        """Standard deviation of the own position over ground."""
        return math.hypot(FIXED_SD_M, DRIFT_M_S * self.unfixed_s)

    @property
    def has_fix(self) -> bool:
        """At the surface for long enough."""
        return self.unfixed_s == 0.0

    def watch(self, now_s: float, state: VehicleState) -> None:
        """Take the newest state; call at every step."""
        if state.position_enu_m[2] < self._surface_up_m - FIX_DEPTH_M:
            self._up_since_s = None
        elif self._up_since_s is None:
            self._up_since_s = now_s
        if self._fixed_at_s is None or (self._up_since_s is not None and now_s - self._up_since_s >= FIX_TAKES_S):
            self._fixed_at_s = now_s
        self.unfixed_s = now_s - self._fixed_at_s

    def is_worth_a_fix(self) -> bool:
        """Whether soundings now tell less per second than they would on average with a fix at every such moment.

        A sounding's information falls with the time without a fix as 1 / (1 + (t / scale)^2); a cycle costs the way up
        and down. The average is greatest where the falling rate meets it (the marginal value theorem).
        """
        t = self.unfixed_s / self._scale_s
        rate_now = 1.0 / (1.0 + t * t)
        gathered_s = self._scale_s * math.atan(t)
        return rate_now < gathered_s / (self.unfixed_s + self._cycle_s)
