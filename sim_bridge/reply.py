"""What a vehicle answers to an order, and what it tells of itself: plain data."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from sim_bridge.modes import Behaviour, LandedState
from vehicle_agent.domain.frames import Point


class Outcome(IntEnum):
    """MAVLink's MAV_RESULT, as far as it is used."""

    ACCEPTED = 0
    TEMPORARILY_REJECTED = 1
    DENIED = 2
    UNSUPPORTED = 3
    FAILED = 4
    IN_PROGRESS = 5


@dataclass(frozen=True, slots=True)
class Reply:
    """The answer to an order: taken, or not and why."""

    outcome: Outcome
    text: str = ""

    @property
    def accepted(self) -> bool:
        return self.outcome is Outcome.ACCEPTED


ACCEPTED = Reply(Outcome.ACCEPTED)


@dataclass(frozen=True, slots=True)
class StatusText:
    """A line for people; severity as in syslog and MAVLink (lower is worse)."""

    severity: int
    text: str


@dataclass(frozen=True, slots=True)
class VehicleSnapshot:
    """What an autopilot knows of itself at one instant.

    Attributes
    ----------
    time_s
        Simulated seconds since the start.
    stamp_ms
        The same instant in Unix milliseconds.
    heading_deg
        Clockwise from north, [0, 360).
    mode, behaviour
        The flight mode as its autopilot numbers it, and what it does in it.
    battery_fraction
        Remaining charge in [0, 1].
    home_enu_m
        Where it returns to; None until the position is known.
    ready_to_arm
        Position known and pre-arm checks passed.
    """

    time_s: float
    stamp_ms: int
    position_enu_m: Point
    velocity_enu_m_s: Point
    heading_deg: float
    armed: bool
    landed: LandedState
    mode: IntEnum
    behaviour: Behaviour
    battery_fraction: float
    home_enu_m: Point | None
    ready_to_arm: bool
    has_flown: bool
    crashed: bool
