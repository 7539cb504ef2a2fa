"""Who steers the vehicle: its agent, or somebody who has changed the flight mode."""

from __future__ import annotations

from enum import Enum

from vehicle_agent.ports import FlightMode

YIELD_AFTER_S = 3.0
"""A mode that nobody here ordered must last so long before the agent gives way to it."""


class Steering(Enum):
    """What an agent may do."""

    OWN = "own"
    """Steer."""
    DOUBTFUL = "doubtful"
    """Give no orders: its last order may be under way, or a pilot or a failsafe may have taken over."""
    FOREIGN = "foreign"
    """Give way."""


class Authority:
    """Judges flight modes over time."""

    def __init__(self) -> None:
        self._foreign_since_s: float | None = None

    def judge(self, now_s: float, mode: FlightMode, own_modes: frozenset[FlightMode]) -> Steering:
        """Judge the present mode against those that the agent's last orders lead to."""
        if mode in own_modes:
            self._foreign_since_s = None
            return Steering.OWN
        if self._foreign_since_s is None:
            self._foreign_since_s = now_s
        return Steering.FOREIGN if now_s - self._foreign_since_s > YIELD_AFTER_S else Steering.DOUBTFUL

    def expect_change(self) -> None:
        """An order that changes the mode has been given: its time counts from now."""
        self._foreign_since_s = None
