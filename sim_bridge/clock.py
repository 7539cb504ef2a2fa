"""Simulated time: counted in whole microseconds from a fixed instant, so that runs repeat exactly."""

from __future__ import annotations

from dataclasses import dataclass

EPOCH_UNIX_S = 1_767_225_600
"""2026-01-01T00:00:00Z: Unix time at the start of every simulation."""


@dataclass(slots=True)
class SimClock:
    """Time of all vehicles of a fleet.

    Attributes
    ----------
    elapsed_us
        Simulated microseconds since the start.
    """

    elapsed_us: int = 0

    @property
    def time_s(self) -> float:
        return self.elapsed_us * 1e-6

    @property
    def unix_us(self) -> int:
        return EPOCH_UNIX_S * 1_000_000 + self.elapsed_us

    @property
    def unix_ms(self) -> int:
        return self.unix_us // 1000
