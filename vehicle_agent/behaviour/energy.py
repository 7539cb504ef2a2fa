"""Whether the charge that is left still brings the vehicle home."""

from __future__ import annotations

LEARN_S = 20.0
DETOUR = 1.5
"""The way home is reckoned longer than the straight line by this factor."""
LAST_SHARE = 0.5
"""Share of the reserve with which a vehicle must go down."""


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
        """Whether a vehicle at home can wait no longer for its way down to become free."""
        return battery_fraction is not None and battery_fraction <= LAST_SHARE * self._reserve
