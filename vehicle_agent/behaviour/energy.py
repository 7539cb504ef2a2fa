"""Whether the charge that is left still brings the vehicle home."""

from __future__ import annotations

import math

LEARN_S = 20.0
DETOUR = 1.5
"""The way home is reckoned longer than the straight line by this factor."""
LAST_SHARE = 0.5
"""Share of the reserve with which a vehicle must go down."""
NEARER_M, STUCK_S = 1.0, 20.0
"""Who has come no nearer to home for so long is held up."""


class EnergyWatch:
    """Learns the drain of charge in flight and compares what is left with the way home.

    Parameters
    ----------
    reserve
        Share of charge with which the vehicle wants to be home.
    """

    def __init__(self, reserve: float) -> None:
        self._reserve = reserve
        self._first: tuple[float, float] | None = None
        self._drain_per_s = 0.0

    def note(self, now_s: float, battery_fraction: float | None) -> None:
        """Take a reading in flight."""
        if battery_fraction is None:
            return
        if self._first is None:
            self._first = (now_s, battery_fraction)
        elif now_s - self._first[0] >= LEARN_S:
            self._drain_per_s = max(0.0, (self._first[1] - battery_fraction) / (now_s - self._first[0]))

    def must_return(self, battery_fraction: float | None, way_home_s: float) -> bool:
        """Whether to turn back now, with the straight way home lasting `way_home_s` at full speed."""
        if battery_fraction is None:
            return False
        return battery_fraction - self._drain_per_s * DETOUR * way_home_s <= self._reserve

    def must_land(self, battery_fraction: float | None) -> bool:
        """Whether a vehicle that comes home can wait no longer for its way to become free."""
        return battery_fraction is not None and battery_fraction <= LAST_SHARE * self._reserve

    def is_nearly_gone(self, battery_fraction: float | None) -> bool:
        """Whether it must go down wherever it is, whoever is below: teammates see it come, and make room."""
        return battery_fraction is not None and battery_fraction <= LAST_SHARE**2 * self._reserve


class Headway:
    """Whether a vehicle on its way home still gets nearer."""

    def __init__(self) -> None:
        self._nearest_m = math.inf
        self._since_s = 0.0

    def begin(self, now_s: float) -> None:
        """Set off."""
        self._nearest_m, self._since_s = math.inf, now_s

    def is_stuck(self, now_s: float, away_m: float) -> bool:
        """Take the distance that is left; True when it has not become less for a while."""
        if away_m < self._nearest_m - NEARER_M:
            self._nearest_m, self._since_s = away_m, now_s
        return now_s - self._since_s > STUCK_S
