"""The messages of a fleet. Every quantity is a bounded integer or a bounded text, so no NaN can be said.

Positions are centimetres in the mission's ENU frame, stamps are milliseconds of Unix time as the vehicle's autopilot
tells it (so a simulation at ten times real time needs no flag anywhere).
"""

from __future__ import annotations

from enum import IntEnum
from typing import Annotated

import msgspec
from msgspec import Meta

NAME_PATTERN = r"^[a-z][a-z0-9-]{0,30}\Z"
MAX_BLOB_BYTES = 60_000
MAX_RECORDS = 256

Name = Annotated[str, Meta(pattern=NAME_PATTERN)]
U32 = Annotated[int, Meta(ge=0, le=2**32 - 1)]
PatchNumber = Annotated[int, Meta(ge=0, lt=400)]
TeamIndex = Annotated[int, Meta(ge=0, lt=256)]
BendPart = Annotated[int, Meta(ge=0, lt=2**20)]
"""East or north of a bend, in half cells of the map from its south-western corner."""
Bends = Annotated[tuple[BendPart, ...], Meta(max_length=128)]
StampMs = Annotated[int, Meta(ge=0, le=2**53)]
Centimetres = Annotated[int, Meta(ge=-(10**8), le=10**8)]
PositionCm = tuple[Centimetres, Centimetres, Centimetres]
PolygonCm = Annotated[tuple[tuple[Centimetres, Centimetres], ...], Meta(max_length=48)]
"""Corners in order, east and north, not closed; empty for none."""
Text = Annotated[str, Meta(max_length=160)]
Permille = Annotated[int, Meta(ge=0, le=1000)]


class Stage(IntEnum):
    """Where an agent stands in its mission."""

    CONNECTING = 0
    CONFIGURING = 1
    ARMING = 2
    TAKING_OFF = 3
    WORKING = 4
    HOLDING = 5
    RETURNING = 6
    LANDING = 7
    DONE = 8
    YIELDED = 9
    """The autopilot or a pilot took over: the agent watches and tells, and moves nothing."""
    REFUSED = 10
    """The agent will not fly: its last event says why."""


class Severity(IntEnum):
    """Severity of an event, as in syslog and MAVLink (lower is worse)."""

    CRITICAL = 2
    ERROR = 3
    WARNING = 4
    NOTICE = 5
    INFO = 6


class Verb(IntEnum):
    """What an operator can ask of a vehicle."""

    HOLD = 0
    RESUME = 1
    RETURN = 2
    LAND = 3
    GO_TO = 4
    """Fly to `point_cm` (its height above the ground there is the vehicle's own choice) and hold there."""
    VISIT = 5
    """Fly to `point_cm`, then go on with the mission."""
    NO_FLY = 6
    """Keep out of `polygon_cm` from now on, known as zone `number`; an empty polygon lifts that zone."""
    AREA = 7
    """Only the part of the mission's area inside `polygon_cm` is to be seen; empty: all of it again."""
    SECTOR = 8
    """See what lies inside `polygon_cm` before anything else; empty: no preference."""
    SPEED = 9
    """Fly no faster than `number` cm/s; 0: as the mission says."""
    RELEASE = 10
    """Count teammate `subject` as lost: its goals are free."""


class Outcome(IntEnum):
    """What became of a command at one vehicle."""

    ACCEPTED = 0
    REFUSED = 1


class Message(msgspec.Struct, array_like=True, frozen=True, kw_only=True):
    """What every message begins with.

    Attributes
    ----------
    sender
        Name of the vehicle or station that says it.
    boot_id
        Drawn anew at every start of the sender, so that a restart is seen.
    sequence
        Counts the sender's messages of this boot, all topics together.
    stamp_ms
        When it was said, Unix milliseconds by the sender's vehicle.
    """

    sender: Name
    boot_id: U32
    sequence: U32
    stamp_ms: StampMs


class Status(Message, frozen=True, tag=1, kw_only=True):
    """Where a vehicle is, what it does and why; said about once a second of vehicle time."""

    stage: Stage
    mode: Annotated[str, Meta(max_length=16)]
    armed: bool
    position_cm: PositionCm
    velocity_cm_s: PositionCm
    heading_deg: Annotated[int, Meta(ge=0, le=360)]
    battery_permille: Annotated[int, Meta(ge=-1, le=1000)]
    """Remaining charge in permille; -1 when the autopilot does not know."""
    leg_end_cm: PositionCm
    """End of the straight leg reserved by the vehicle; its own position when it reserves none.

    From arming on it is where the take-off will end.
    """
    home_cm: PositionCm
    known_permille: Permille
    """Share of the area's cells observed on this vehicle's own map."""
    first_seen_cells: U32
    """Cells this vehicle saw first (ties shared, rounded), J_E of Renzaglia eq. 5."""
    bytes_sent: U32
    messages_dropped: U32
    why: Text
    path_cm: Annotated[tuple[PositionCm, ...], Meta(max_length=12)] = ()
    """Waypoints after the reserved leg, as planned now."""
    return_up_cm: Centimetres = 0
    """ENU height to which its autopilot climbs when it returns by itself."""
    next_end_cm: PositionCm | None = None
    """End of the leg that it means to fly once it knows that no teammate's earlier one crosses; None without one."""
    next_told_ms: U32 = 0
    """Milliseconds since it first told of that leg."""


class DeltaRecord(msgspec.Struct, array_like=True, frozen=True):
    """One journalled piece of one vehicle's own observations; identified by (origin, stream_id, delta_sequence)."""

    origin: Name
    stream_id: U32
    """Drawn when the origin's journal was begun; a restarted agent that resumes its journal keeps it."""
    delta_sequence: U32
    """0, 1, 2, ... without gaps within a stream."""
    cells: Annotated[bytes, Meta(max_length=MAX_BLOB_BYTES)]
    """Packed observations: `vehicle_agent.wire.cells`, or in a town `vehicle_agent.wire.voxel_blob`."""


class MapDelta(Message, frozen=True, tag=2, kw_only=True):
    """What the sender observed since its last delta."""

    record: DeltaRecord


class LanePlan(msgspec.Struct, array_like=True, frozen=True):
    """Ways of straight lanes for a whole team, of bends told as east and north by turns."""

    number: U32
    """Higher than every plan's that it was made from."""
    by: TeamIndex
    """Who made it."""
    vehicles: Annotated[tuple[TeamIndex, ...], Meta(max_length=256)]
    """Whom it is made for."""
    ways: tuple[Bends, ...]
    """One for each of them."""
    flown: Annotated[tuple[BendPart, ...], Meta(max_length=16)] = ()
    """Bends that the sender reached last."""

    def __post_init__(self) -> None:
        if len(self.ways) != len(self.vehicles) or len(set(self.vehicles)) != len(self.vehicles):
            raise ValueError("a team's lanes need one way for each vehicle")
        if any(len(way) % 2 for way in (*self.ways, self.flown)):
            raise ValueError("a bend needs an east and a north")


class Claim(Message, frozen=True, tag=3, kw_only=True):
    """The goal that the sender is going for, so that others choose another; `active` false lets it go."""

    active: bool
    goal_cm: PositionCm
    cost_m: Annotated[int, Meta(ge=0, le=10**7)]
    """Length of the sender's way to the goal, metres."""
    tour_number: U32 = 0
    """Higher than every tour's that the sender knew of when it planned its own; 0 when it plans none."""
    tour: Annotated[tuple[PatchNumber, ...], Meta(max_length=400)] = ()
    """Patches of the ground that the sender means to visit, the next one first."""
    lanes: LanePlan | None = None
    """The team's plan that the sender follows."""


class Event(Message, frozen=True, tag=4, kw_only=True):
    """Something that an operator wants to read once."""

    severity: Severity
    code: Annotated[str, Meta(max_length=32)]
    """A stable word for programs, e.g. `took-off`, `returned`, `yielded`."""
    text: Text


class Command(Message, frozen=True, tag=5, kw_only=True):
    """An operator's order. A vehicle obeys a (sender, boot_id, command_id) once, however often it arrives."""

    command_id: U32
    verb: Verb
    targets: Annotated[tuple[Name, ...], Meta(max_length=64)]
    point_cm: PositionCm = (0, 0, 0)
    polygon_cm: PolygonCm = ()
    number: Annotated[int, Meta(ge=0, le=2**31)] = 0
    subject: Annotated[str, Meta(max_length=31)] = ""


class CommandResult(Message, frozen=True, tag=6, kw_only=True):
    """One vehicle's answer to one command."""

    station: Name
    station_boot_id: U32
    command_id: U32
    verb: Verb
    outcome: Outcome
    text: Text


class StreamHeld(msgspec.Struct, array_like=True, frozen=True):
    """How much of one stream somebody holds without a gap: records 0 .. held - 1."""

    origin: Name
    stream_id: U32
    held: U32


class Digest(Message, frozen=True, tag=7, kw_only=True):
    """What the sender's map is made of; whoever holds more sends the missing records."""

    streams: Annotated[tuple[StreamHeld, ...], Meta(max_length=256)]


class Repair(Message, frozen=True, tag=8, kw_only=True):
    """Records that somebody's digest showed to be missing; useful to everybody who lacks them."""

    records: Annotated[tuple[DeltaRecord, ...], Meta(max_length=MAX_RECORDS)]


class Scan(Message, frozen=True, tag=9, kw_only=True):
    """What a vehicle's sensor saw at `stamp_ms`; from the payload to its own agent, never over the radio."""

    cells: Annotated[bytes, Meta(max_length=2_000_000)]
    """Packed observations: `vehicle_agent.wire.cells`, or of a half-sphere `vehicle_agent.wire.range_blob`."""


class BodyReport(Message, frozen=True, tag=10, kw_only=True):
    """The simulator's truth about one body, for referees and tests only; agents and stations never hear it."""

    vehicle: Name
    position_cm: PositionCm
    armed: bool
    has_flown: bool
    crashed: bool
    mode: Annotated[str, Meta(max_length=16)]


class Zone(msgspec.Struct, array_like=True, frozen=True):
    """A no-fly polygon under the number by which it can be lifted."""

    number: U32
    polygon_cm: PolygonCm


class Orders(Message, frozen=True, tag=11, kw_only=True):
    """What stands ordered at a vehicle, so that a station that starts late knows it too."""

    no_fly: Annotated[tuple[Zone, ...], Meta(max_length=16)] = ()
    area_cm: PolygonCm = ()
    sector_cm: PolygonCm = ()
    speed_limit_cm_s: Annotated[int, Meta(ge=0, le=2**31)] = 0
    """0: as the mission says."""


class WorkNote(msgspec.Struct, array_like=True, frozen=True):
    """Where the sender is going, and which landmarks are done around a place, without their heights."""

    goal_cm: PositionCm | None = None
    done_centre: U32 = 0
    done_bits: Annotated[bytes, Meta(max_length=32)] = b""
    """See `vehicle_agent.domain.done_sketch`; empty for no sketch."""


class Landmarks(Message, frozen=True, tag=12, kw_only=True):
    """What the sender tells of landmarks, and where it is (Kapoutsis 2015, section 3.4)."""

    position_cm: PositionCm
    position_sd_cm: Annotated[int, Meta(ge=0, le=10**8)]
    """How well it knows its position (c_R): one standard deviation."""
    records: Annotated[bytes, Meta(max_length=MAX_BLOB_BYTES)]
    """Packed records, see `vehicle_agent.wire.landmark_blob`."""
    note: WorkNote | None = None


class LandmarkDigest(Message, frozen=True, tag=13, kw_only=True):
    """Checksums of what the sender knows of landmarks: whoever knows other things tells them."""

    checksums: Annotated[tuple[U32, ...], Meta(min_length=1, max_length=64)]
    """One per block, see `LandmarkMap.digest`."""


AnyMessage = (
    Status
    | MapDelta
    | Claim
    | Event
    | Command
    | CommandResult
    | Digest
    | Repair
    | Scan
    | BodyReport
    | Orders
    | Landmarks
    | LandmarkDigest
)
