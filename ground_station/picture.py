"""What a ground station knows of a fleet: immutable values, nothing of terminals and nothing of Zenoh."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

from ground_station.conditions import Kind, Trouble
from ground_station.landmark_picture import LandmarkPicture
from ground_station.ledger import SequenceRanges
from ground_station.team_map import TeamMap
from ground_station.vehicle_picture import Condition, VehiclePicture, metres
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.wire.messages import Command, Outcome, PolygonCm, Severity, Stage

__all__ = ["Condition", "FleetState", "VehiclePicture", "metres"]

COMMAND_TIMEOUT_S = 5.0
"""Wall time after which a vehicle that has not answered a command counts as timed out."""
LOST_FOR_GOOD_S = 10.0
"""Wall time after which a lost vehicle no longer holds up the end of a mission."""


class Phase(Enum):
    """Where the fleet as a whole stands."""

    WAITING = "waiting"
    STARTING = "starting"
    WORKING = "working"
    HOLDING = "holding"
    RETURNING = "returning"
    SILENT = "silent"
    """Nobody is heard any more, and not all had finished."""
    DONE = "done"


@dataclass(frozen=True, slots=True)
class LogEntry:
    """One line of the event log.

    Attributes
    ----------
    number
        Counts all entries since the station's start.
    stamp_ms
        Unix time by the vehicle, or by the fleet's newest stamp for the station's own findings; 0 when unknown.
    source
        Vehicle or station.
    """

    number: int
    stamp_ms: int
    source: str
    severity: Severity
    code: str
    text: str


@dataclass(frozen=True, slots=True)
class Answer:
    """What one vehicle said to a command."""

    outcome: Outcome
    text: str


@dataclass(frozen=True, slots=True)
class CommandTrack:
    """A command of this station and what became of it per target.

    Attributes
    ----------
    timed_out
        Targets whose silence has been logged.
    """

    command: Command
    sent_s: float
    answers: Mapping[str, Answer] = field(default_factory=dict)
    timed_out: frozenset[str] = frozenset()

    def result_of(self, target: str, now_s: float) -> str:
        """One of `sent`, `accepted`, `refused: why`, `timed out`."""
        answer = self.answers.get(target)
        if answer is None:
            return "timed out" if now_s - self.sent_s >= COMMAND_TIMEOUT_S else "sent"
        word = "accepted" if answer.outcome is Outcome.ACCEPTED else "refused"
        return f"{word}: {answer.text}" if answer.text else word


@dataclass(frozen=True, slots=True)
class Stream:
    """How much of one vehicle's journal is on this map.

    Attributes
    ----------
    held
        Numbers of the records that were folded in.
    offered
        Records that exist as far as anybody has said.
    """

    held: SequenceRanges = field(default_factory=SequenceRanges)
    offered: int = 0

    @property
    def missing(self) -> int:
        return max(0, self.offered - self.held.contiguous)


@dataclass(frozen=True, slots=True)
class Counters:
    """What was not taken in.

    Attributes
    ----------
    undecodable, overflowed
        As counted by the link: wrong bytes, and messages pushed out of a full queue.
    foreign
        Messages of senders that are not in the mission.
    malformed
        Records whose cells are not of this mission's grid.
    repeated
        Messages that came a second time (ordinary: repairs and recovery overlap).
    """

    undecodable: int = 0
    overflowed: int = 0
    foreign: int = 0
    malformed: int = 0
    repeated: int = 0

    @property
    def bad(self) -> int:
        return self.undecodable + self.overflowed + self.foreign + self.malformed


@dataclass(frozen=True, slots=True)
class FleetState:
    """The whole picture at one moment; equal inputs make equal states.

    Attributes
    ----------
    plan
        The mission.
    station, station_boot_id
        Who this station is on the link; answers to other stations' commands are only logged.
    began_s, now_s
        Station time (monotonic wall seconds) of the start and of the last tick.
    vehicles
        By team index.
    landmarks
        What is known of landmarks; None for missions that map none.
    streams
        By (origin, stream_id).
    seen
        Sequence numbers taken in, by (sender, boot_id).
    log, log_total
        The newest entries, and how many there were in all.
    started_ms, newest_ms
        Earliest and latest stamp heard, Unix milliseconds; 0 before any.
    pace_samples
        (station time, newest status's stamp) pairs of the last seconds, for `speedup`.
    troubles
        What is wrong, as of the last tick, worst first.
    muted
        (vehicle, kind) pairs that the operator does not want to hear of.
    """

    plan: MissionPlan
    station: str
    station_boot_id: int
    began_s: float
    now_s: float
    vehicles: tuple[VehiclePicture, ...]
    team_map: TeamMap
    landmarks: LandmarkPicture | None = None
    streams: Mapping[tuple[str, int], Stream] = field(default_factory=dict)
    seen: Mapping[tuple[str, int], SequenceRanges] = field(default_factory=dict)
    log: tuple[LogEntry, ...] = ()
    log_total: int = 0
    commands: tuple[CommandTrack, ...] = ()
    counters: Counters = Counters()
    started_ms: int = 0
    newest_ms: int = 0
    pace_samples: tuple[tuple[float, int], ...] = ()
    troubles: tuple[Trouble, ...] = ()
    muted: frozenset[tuple[str, Kind]] = frozenset()

    @classmethod
    def initial(cls, plan: MissionPlan, station: str, station_boot_id: int, now_s: float) -> FleetState:
        names = plan.vehicle_names
        vehicles = tuple(VehiclePicture(name, index) for index, name in enumerate(names))
        town = plan.voxel_grid is not None
        team_map = TeamMap.empty(plan.grid, plan.area_cells, len(names), keeps_highest=town)
        landmarks = LandmarkPicture.of(plan)
        return cls(plan, station, station_boot_id, now_s, now_s, vehicles, team_map, landmarks)

    @property
    def elapsed_s(self) -> float:
        """Vehicle time since the earliest stamp heard."""
        return (self.newest_ms - self.started_ms) / 1_000

    @property
    def speedup(self) -> float | None:
        """Vehicle seconds per wall second; None until there is enough to tell."""
        if len(self.pace_samples) < 2:
            return None
        (first_s, first_ms), (last_s, last_ms) = self.pace_samples[0], self.pace_samples[-1]
        return (last_ms - first_ms) / 1_000 / (last_s - first_s) if last_s - first_s >= 2.0 else None

    @property
    def coverage(self) -> float:
        """Share of what is to be seen that is known, in [0, 1]; of a town as the vehicle that knows most says."""
        if self.plan.voxel_grid is None:
            return self.team_map.coverage
        told = [vehicle.status.known_permille for vehicle in self.vehicles if vehicle.status is not None]
        return max(told, default=0) / 1_000

    @property
    def heard_any(self) -> bool:
        return any(vehicle.status is not None for vehicle in self.vehicles)

    @property
    def records_missing(self) -> int:
        """Map records known to exist that are not on this map yet."""
        return sum(stream.missing for stream in self.streams.values())

    @property
    def phase(self) -> Phase:
        """Where the fleet stands, judged by the vehicles that are still heard."""
        if not self.heard_any:
            return Phase.WAITING
        if all(vehicle.finished for vehicle in self.vehicles):
            return Phase.DONE
        gone = (Condition.LOST, Condition.LEFT, Condition.AWAITED)
        active = {v.status.stage for v in self.vehicles if v.status and not v.finished and v.condition not in gone}
        if not active:
            ended = self.finished and any(vehicle.finished for vehicle in self.vehicles)
            return Phase.DONE if ended else Phase.SILENT
        if Stage.WORKING in active:
            return Phase.WORKING
        if active <= {Stage.HOLDING, Stage.YIELDED}:
            return Phase.HOLDING
        return Phase.RETURNING if active & {Stage.RETURNING, Stage.LANDING, Stage.HOLDING} else Phase.STARTING

    @property
    def finished(self) -> bool:
        """Every vehicle has ended its mission or is lost for good."""
        return all(
            vehicle.finished
            or (vehicle.condition is Condition.LOST and self.now_s - vehicle.condition_since_s >= LOST_FOR_GOOD_S)
            for vehicle in self.vehicles
        )

    def count(self, condition: Condition) -> int:
        return sum(vehicle.condition is condition for vehicle in self.vehicles)

    @property
    def audible_troubles(self) -> tuple[Trouble, ...]:
        """Troubles that are not muted, worst first."""
        return tuple(one for one in self.troubles if (one.vehicle, one.kind) not in self.muted)

    @property
    def zones(self) -> dict[int, PolygonCm]:
        """No-fly polygons by number, as the vehicles say that they keep them."""
        told = [vehicle.orders for vehicle in self.vehicles if vehicle.orders is not None]
        return {zone.number: zone.polygon_cm for orders in told for zone in orders.no_fly}

    @property
    def area_cm(self) -> PolygonCm:
        """The part of the area that counts by the operator's order; empty: all of it."""
        return next((v.orders.area_cm for v in self.vehicles if v.orders is not None and v.orders.area_cm), ())
