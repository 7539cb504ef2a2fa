"""A battery that drains in proportion to flying time."""

from __future__ import annotations

from dataclasses import dataclass

FULL_VOLT = 25.2
EMPTY_VOLT = 21.0
"""Six lithium-polymer cells, linear in between."""
IDLE_SHARE = 0.05
"""Draw of idling motors against hovering."""


@dataclass(slots=True)
class Battery:
    """Charge of one vehicle.

    Attributes
    ----------
    endurance_s
        Flying time of a full battery.
    remaining
        Share of charge left, in [0, 1].
    """

    endurance_s: float
    remaining: float = 1.0
    current_a: float = 0.0

    def drain(self, dt_s: float, armed: bool, airborne: bool, capacity_mah: float) -> None:
        share = (1.0 if airborne else IDLE_SHARE) if armed else 0.0
        self.current_a = share * capacity_mah * 3.6 / self.endurance_s
        self.remaining = max(0.0, self.remaining - share * dt_s / self.endurance_s)

    @property
    def voltage_v(self) -> float:
        return EMPTY_VOLT + (FULL_VOLT - EMPTY_VOLT) * self.remaining
