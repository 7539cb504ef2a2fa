"""What can happen to a ground station's picture."""

from __future__ import annotations

from dataclasses import dataclass

from vehicle_agent.wire.messages import AnyMessage, Command


@dataclass(frozen=True, slots=True)
class Heard:
    """A message came in at station time `arrival_s`."""

    message: AnyMessage
    arrival_s: float


@dataclass(frozen=True, slots=True)
class AliveChanged:
    """A participant's liveliness token came or went."""

    participant: str
    alive: bool
    arrival_s: float


@dataclass(frozen=True, slots=True)
class CommandSent:
    """This station sent a command."""

    command: Command
    sent_s: float


@dataclass(frozen=True, slots=True)
class LinkCounted:
    """The link's own totals of what it had to throw away."""

    undecodable: int
    overflowed: int


@dataclass(frozen=True, slots=True)
class Tick:
    """Station time went on; silence is judged at ticks only."""

    now_s: float


@dataclass(frozen=True, slots=True)
class Acknowledged:
    """The operator has seen a vehicle's trouble; `kind` is the name of a `conditions.Kind`."""

    vehicle: str
    kind: str


@dataclass(frozen=True, slots=True)
class Muted:
    """The operator does not want to hear of a vehicle's trouble any more, or wants to again."""

    vehicle: str
    kind: str
    muted: bool = True


@dataclass(frozen=True, slots=True)
class AutopilotHeard:
    """An autopilot's own heartbeat came in over MAVLink, beside the fleet's link; `source` says from where."""

    system_id: int
    armed: bool
    in_failsafe: bool
    source: str
    arrival_s: float


FleetInput = Heard | AliveChanged | CommandSent | LinkCounted | Tick | Acknowledged | Muted | AutopilotHeard
