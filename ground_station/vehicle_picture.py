"""One vehicle as a station knows it."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from ground_station.evidence import Evidence
from vehicle_agent.domain.frames import Point
from vehicle_agent.wire.messages import Claim, Orders, PositionCm, Stage, Status

FINISHED_STAGES = (Stage.DONE, Stage.REFUSED)


class Condition(Enum):
    """How well a vehicle's agent is heard."""

    AWAITED = "awaited"
    """Not heard since this station started."""
    LIVE = "live"
    SUSPECT = "suspect"
    """A status is a second overdue."""
    LOST = "lost"
    """Silent for a whole lease, or its liveliness token is gone."""
    LEFT = "left"
    """Silent after its mission had ended: nothing to worry about."""


@dataclass(frozen=True, slots=True)
class AutopilotPicture:
    """An autopilot as last heard beside the fleet's link.

    Attributes
    ----------
    heard_s
        Station time of its last heartbeat.
    armed, in_failsafe
        As that heartbeat says.
    sources
        From where heartbeats with its system id came, each with the station time of the last one; newest last.
    """

    heard_s: float
    armed: bool
    in_failsafe: bool
    sources: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class VehiclePicture:
    """One vehicle as last heard.

    Attributes
    ----------
    name, index
        As in the mission's team.
    status
        The last status with its texts made safe; None before the first.
    arrival_s
        Station time at which it came.
    past_boots
        Boot ids of earlier lives of the agent; what they still say about themselves is ignored.
    alive, alive_changed_s
        The agent's liveliness token (None: never seen) and the station time of its last change.
    condition, condition_since_s
        As of the last tick.
    claim
        The goal it goes for, or None.
    trail_en_m
        Where it was: (east, north) pairs in ENU metres, oldest first, thinned.
    sent_samples
        (stamp_ms, bytes_sent) pairs over the last seconds, for `bytes_per_s`.
    evidence
        What its statuses say over time.
    orders
        What stands ordered at it; None when it has not told.
    autopilot
        What its autopilot says by itself over MAVLink; None where nobody listens, or it was never heard.
    """

    name: str
    index: int
    status: Status | None = None
    arrival_s: float | None = None
    past_boots: tuple[int, ...] = ()
    alive: bool | None = None
    alive_changed_s: float = 0.0
    condition: Condition = Condition.AWAITED
    condition_since_s: float = 0.0
    claim: Claim | None = None
    trail_en_m: tuple[tuple[float, float], ...] = ()
    sent_samples: tuple[tuple[float, int], ...] = ()
    evidence: Evidence = field(default_factory=Evidence)
    orders: Orders | None = None
    autopilot: AutopilotPicture | None = None

    @property
    def position_enu_m(self) -> Point | None:
        return None if self.status is None else metres(self.status.position_cm)

    @property
    def bytes_per_s(self) -> float:
        """Bytes sent per second of vehicle time, over the last ten seconds or so."""
        if len(self.sent_samples) < 2:
            return 0.0
        (first_ms, first_bytes), (last_ms, last_bytes) = self.sent_samples[0], self.sent_samples[-1]
        return 1_000.0 * (last_bytes - first_bytes) / max(1, last_ms - first_ms)

    @property
    def finished(self) -> bool:
        return self.status is not None and self.status.stage in FINISHED_STAGES

    def age_s(self, now_s: float) -> float | None:
        """Station time since the last status; None before the first."""
        return None if self.arrival_s is None else max(0.0, now_s - self.arrival_s)


def metres(position_cm: PositionCm) -> Point:
    """Centimetres of the wire to ENU metres."""
    east, north, up = position_cm
    return (east / 100, north / 100, up / 100)
