"""What an agent needs from the world, and what passes between the two: data in, data out, no I/O here."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Protocol

from vehicle_agent.domain.elevation import CellObservations
from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.range_image import RangeImage
from vehicle_agent.wire.messages import AnyMessage


class FlightMode(Enum):
    """Flight modes in words common to all autopilots."""

    GUIDED = "guided"
    """Obeys its agent's targets."""
    HOLD = "hold"
    RETURN = "return"
    LAND = "land"
    MANUAL = "manual"
    """Any mode in which a person steers."""
    MISSION = "mission"
    UNKNOWN = "unknown"


class Landed(Enum):
    """Where the autopilot believes its vehicle to be."""

    UNKNOWN = "unknown"
    ON_GROUND = "on-ground"
    TAKING_OFF = "taking-off"
    IN_AIR = "in-air"
    LANDING = "landing"


@dataclass(frozen=True, slots=True)
class Sounding:
    """One reading of a beam straight down from the vehicle.

    Attributes
    ----------
    stamp_ms
        Unix time by the autopilot, milliseconds, by which readings are told apart.
    range_m
        Distance along the beam; None when nothing within its limits answered.
    """

    stamp_ms: int
    range_m: float | None


@dataclass(frozen=True, slots=True)
class VehicleState:
    """What the autopilot tells of itself.

    Attributes
    ----------
    stamp_ms
        Unix time by the autopilot, milliseconds.
    position_enu_m, velocity_enu_m_s
        In the mission's frame.
    heading_deg
        Clockwise from north, [0, 360).
    battery_fraction
        Remaining charge in [0, 1]; None when unknown.
    ready_to_arm
        Position known and pre-arm checks passed.
    home_enu_m
        Where the autopilot returns to; None until it knows.
    rival_controller
        True once another component has been heard speaking with this agent's MAVLink system id.
    sounding
        Last reading of the autopilot's own downward beam; None without one.
    """

    stamp_ms: int
    position_enu_m: Point
    velocity_enu_m_s: Point = (0.0, 0.0, 0.0)
    heading_deg: float = 0.0
    armed: bool = False
    landed: Landed = Landed.UNKNOWN
    mode: FlightMode = FlightMode.UNKNOWN
    battery_fraction: float | None = None
    ready_to_arm: bool = False
    home_enu_m: Point | None = None
    rival_controller: bool = False
    sounding: Sounding | None = None


@dataclass(frozen=True, slots=True)
class SetParameter:
    """Set an autopilot parameter; done when the autopilot echoes the value."""

    name: str
    value: float


@dataclass(frozen=True, slots=True)
class Arm:
    """Switch to guided flight and start the motors."""


@dataclass(frozen=True, slots=True)
class Disarm:
    """Stop the motors on the ground."""


@dataclass(frozen=True, slots=True)
class TakeOff:
    """Climb straight up to `height_m` above home."""

    height_m: float


@dataclass(frozen=True, slots=True)
class GoTo:
    """Fly straight to a point of the mission's frame and stay there; switches to guided flight."""

    position_enu_m: Point


@dataclass(frozen=True, slots=True)
class SetSpeed:
    """Limit the speed over ground."""

    speed_m_s: float


@dataclass(frozen=True, slots=True)
class Hold:
    """Stop and stay."""


@dataclass(frozen=True, slots=True)
class ReturnHome:
    """The autopilot's own return: climb to its return altitude, fly home, land, disarm."""


@dataclass(frozen=True, slots=True)
class Land:
    """Land here and disarm."""


Order = SetParameter | Arm | Disarm | TakeOff | GoTo | SetSpeed | Hold | ReturnHome | Land


@dataclass(frozen=True, slots=True)
class Action:
    """An order with the number under which its result comes back."""

    action_id: int
    order: Order


@dataclass(frozen=True, slots=True)
class ActionResult:
    """What the autopilot answered: `accepted`, or not and why in one sentence."""

    action_id: int
    accepted: bool
    text: str = ""


@dataclass(frozen=True, slots=True)
class SensorScan:
    """What the vehicle's own sensor saw at one instant: surface cells, or distances along rays."""

    seen: CellObservations | RangeImage


@dataclass(frozen=True, slots=True)
class AutopilotText:
    """A STATUSTEXT of the autopilot; severity as in syslog."""

    severity: int
    text: str


@dataclass(frozen=True, slots=True)
class TeammateRange:
    """Distance to a teammate, by the time that a packet of it took through the water.

    Attributes
    ----------
    sender, sequence
        Of the packet.
    range_m
        Distance from where the teammate said it to where this vehicle was then.
    """

    sender: str
    sequence: int
    range_m: float


@dataclass(slots=True)
class Inbox:
    """What came in since the last step, each list in order of arrival."""

    state: VehicleState | None = None
    scans: list[SensorScan] = field(default_factory=list)
    messages: list[AnyMessage] = field(default_factory=list)
    results: list[ActionResult] = field(default_factory=list)
    texts: list[AutopilotText] = field(default_factory=list)
    ranges: list[TeammateRange] = field(default_factory=list)


@dataclass(slots=True)
class Outbox:
    """What the agent wants done, in order: journal first, then actions and messages."""

    journal: list[bytes] = field(default_factory=list)
    actions: list[Action] = field(default_factory=list)
    messages: list[AnyMessage] = field(default_factory=list)


class Autopilot(Protocol):
    """A vehicle's autopilot, seen from its agent."""

    def poll(self) -> tuple[VehicleState | None, list[ActionResult], list[AutopilotText]]:
        """Take the newest state (None when nothing new came), and the results and texts since the last poll."""
        ...

    def submit(self, action: Action) -> None:
        """Start an action; its result comes out of `poll`. Never blocks."""
        ...


class Team(Protocol):
    """The radio to teammates and stations."""

    def poll(self) -> list[AnyMessage]:
        """Take the messages that arrived, in order of arrival."""
        ...

    def publish(self, message: AnyMessage) -> None:
        """Send to everybody in reach. Never blocks."""
        ...


class Payload(Protocol):
    """The vehicle's mapping sensor."""

    def poll(self) -> list[SensorScan]:
        """Take the scans that arrived, in order."""
        ...


class Journal(Protocol):
    """Records that survive the death of the agent."""

    def records(self) -> Iterable[bytes]:
        """Every whole record of earlier runs, oldest first; a torn last record is left out."""
        ...

    def append(self, records: Sequence[bytes]) -> None:
        """Keep records, in order, before anything that depends on them is sent."""
        ...
