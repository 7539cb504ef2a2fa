"""A battery that drains with the work that is done."""

from __future__ import annotations

from dataclasses import dataclass

FULL_VOLT = 25.2
EMPTY_VOLT = 21.0
"""Six lithium-polymer cells, linear in between."""
IDLE_LOAD = 0.05
"""Draw of idling motors against the draw for which `endurance_s` is given."""
FAILED_FRACTION = 0.03
"""What is left after a cell has failed."""


@dataclass(slots=True)
class Battery:
    """Charge of one vehicle.

    Attributes
    ----------
    endurance_s
        How long a full battery lasts at a load of 1: hovering, or full speed on or in the water.
    remaining
        Share of charge left, in [0, 1].
    """

    endurance_s: float
    remaining: float = 1.0
    current_a: float = 0.0

    def drain(self, dt_s: float, load: float, capacity_mah: float) -> None:
        self.current_a = load * capacity_mah * 3.6 / self.endurance_s
        self.remaining = max(0.0, self.remaining - load * dt_s / self.endurance_s)

    def fail(self) -> None:
        """Lose a cell: next to nothing is left."""
        self.remaining = min(self.remaining, FAILED_FRACTION)

    @property
    def voltage_v(self) -> float:
        return EMPTY_VOLT + (FULL_VOLT - EMPTY_VOLT) * self.remaining
