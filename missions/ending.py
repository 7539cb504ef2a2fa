"""When is a mission over? Decided from what is heard, without I/O and with the wall clock handed in."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import Enum

from missions.processes import is_simulated
from vehicle_agent.domain.frames import Point
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.wire.messages import AnyMessage, BodyReport, PositionCm, Stage, Status

SILENT_AFTER_S = 10.0
"""Wall time without a status after which an agent that still runs counts as gone (frozen, or cut off)."""
RETURN_ALLOWANCE_S = 900.0
"""Vehicle time that a vehicle gets to come home, beyond the time limit or after the others are done."""
START_ALLOWANCE_S = 120.0
"""Wall time within which a simulated fleet takes off, beyond `simulation.ready_after_s`."""
STANDSTILL_S = 60.0
"""Wall time without a newer stamp from anybody after which a flying fleet counts as stuck."""


class Ending(Enum):
    """Why a mission is over."""

    COMPLETE = "complete"
    TIME_LIMIT = "time-limit"
    NOT_LANDED = "not-landed"
    NO_TAKEOFF = "no-takeoff"
    STANDSTILL = "standstill"
    STOPPED = "stopped"
    """By the operator or a signal."""
    BROKEN = "broken"
    """A process that the mission cannot do without is gone."""


@dataclass(slots=True)
class VehicleRecord:
    """What was heard of one vehicle.

    Attributes
    ----------
    simulated
        Its body is the simulator's, so that `body` will come.
    status, body
        Newest message of the agent and of the simulator.
    status_heard_s
        Wall time of the newest status.
    first_stamp_ms
        Stamp of the first status, Unix milliseconds.
    took_off_ms, down_ms
        Stamps of the first armed report and of the last change to disarmed; None before.
    flown_m
        Length of the track since arming, through the positions reported.
    agent_ended
        Its process is gone.
    worked_at_m
        Where its agent last said that it was at work, mission's ENU metres.
    """

    simulated: bool
    status: Status | None = None
    body: BodyReport | None = None
    status_heard_s: float = 0.0
    first_stamp_ms: int | None = None
    took_off_ms: int | None = None
    down_ms: int | None = None
    flown_m: float = 0.0
    agent_ended: bool = False
    worked_at_m: Point | None = None
    _armed: bool = False
    _track_end_m: Point | None = None

    def hear(self, message: Status | BodyReport, now_s: float) -> None:
        """Take the agent's or the simulator's newest word; the simulator's decides the track of its bodies."""
        if isinstance(message, Status):
            self.status, self.status_heard_s = message, now_s
            if message.stage is Stage.WORKING:
                self.worked_at_m = _metres(message.position_cm)
            if self.first_stamp_ms is None:
                self.first_stamp_ms = message.stamp_ms
        else:
            self.body = message
        if self.simulated == isinstance(message, BodyReport):
            self._follow(message.armed, message.position_cm, message.stamp_ms)

    def agent_lives(self, now_s: float) -> bool:
        """Tell whether the agent runs and speaks; one that has not spoken yet is given the benefit of the doubt."""
        return not self.agent_ended and (self.status is None or now_s - self.status_heard_s <= SILENT_AFTER_S)

    @property
    def disarmed(self) -> bool:
        """Known to be disarmed."""
        report = self.body if self.simulated else self.status
        return report is not None and not report.armed

    @property
    def position_m(self) -> Point | None:
        """Last known position, mission's ENU metres."""
        report = (self.body if self.simulated else None) or self.status
        return None if report is None else _metres(report.position_cm)

    def settled(self, now_s: float) -> bool:
        """Tell whether nothing more is to be expected of this vehicle."""
        if self.body is not None and self.body.crashed:
            return True
        if self.agent_lives(now_s):
            done = self.status is not None and (
                self.status.stage in (Stage.DONE, Stage.REFUSED)
                or (self.status.stage is Stage.YIELDED and self.took_off_ms is not None)
            )
            return done and self.disarmed
        return self.disarmed or not self.simulated

    def _follow(self, armed: bool, position_cm: PositionCm, stamp_ms: int) -> None:
        position = _metres(position_cm)
        if armed and self.took_off_ms is None:
            self.took_off_ms = stamp_ms
        if self._armed and self._track_end_m is not None:
            self.flown_m += math.dist(position, self._track_end_m)
        if self._armed and not armed:
            self.down_ms = stamp_ms
        self._armed, self._track_end_m = armed, position


@dataclass(slots=True)
class MissionWatch:
    """Follows a mission and tells when it is over.

    Attributes
    ----------
    vehicles
        Records by name, in team order.
    time_limit_s
        Vehicle time from the first take-off at which the agents turn home by themselves.
    ready_after_s
        Wall time until a simulated fleet is ready to arm; None when a vehicle is real and people decide.
    started_s
        Wall time from which waiting counts.
    """

    vehicles: dict[str, VehicleRecord]
    time_limit_s: float
    ready_after_s: float | None
    started_s: float
    newest_stamp_ms: int = 0
    first_airborne_s: float | None = None
    _progress_s: float = field(default=0.0, init=False)
    _waiting_since_ms: int | None = field(default=None, init=False)

    @classmethod
    def of(cls, plan: MissionPlan, now_s: float) -> MissionWatch:
        simulated = [is_simulated(plan, index) for index in range(len(plan.vehicle_names))]
        simulation = plan.mission.simulation
        records = {name: VehicleRecord(sim) for name, sim in zip(plan.vehicle_names, simulated, strict=True)}
        ready_after_s = simulation.ready_after_s / simulation.speedup if all(simulated) else None
        return cls(records, plan.mission.stop.time_limit_s, ready_after_s, now_s)

    def hear(self, messages: Iterable[AnyMessage], now_s: float) -> None:
        """Take what arrived at wall time `now_s`."""
        for message in messages:
            if not isinstance(message, Status | BodyReport):
                continue
            name = message.sender if isinstance(message, Status) else message.vehicle
            if (record := self.vehicles.get(name)) is None:
                continue
            record.hear(message, now_s)
            if message.stamp_ms > self.newest_stamp_ms:
                self.newest_stamp_ms, self._progress_s = message.stamp_ms, now_s
            if self.first_airborne_s is None and record.took_off_ms is not None:
                self.first_airborne_s = now_s

    def agent_ended(self, name: str) -> None:
        self.vehicles[name].agent_ended = True

    @property
    def first_take_off_ms(self) -> int | None:
        return min((r.took_off_ms for r in self.vehicles.values() if r.took_off_ms is not None), default=None)

    @property
    def elapsed_s(self) -> float:
        """Vehicle time from the first take-off until the last vehicle was down, or until now."""
        first_ms = self.first_take_off_ms
        if first_ms is None:
            return 0.0
        flown = [record for record in self.vehicles.values() if record.took_off_ms is not None]
        landed_ms = [record.down_ms for record in flown if record.disarmed and record.down_ms is not None]
        last_ms = max(landed_ms) if len(landed_ms) == len(flown) else self.newest_stamp_ms
        return max(0, last_ms - first_ms) / 1000.0

    def ending(self, now_s: float) -> tuple[Ending, str] | None:
        """Why the mission is over, with a sentence; None while it goes on."""
        settled = {name: record.settled(now_s) for name, record in self.vehicles.items()}
        if all(settled.values()):
            return (Ending.COMPLETE, "every vehicle is done")
        unsettled = ", ".join(name for name, done in settled.items() if not done)
        if self.first_take_off_ms is None:
            if self.ready_after_s is not None and now_s - self.started_s > self.ready_after_s + START_ALLOWANCE_S:
                return (Ending.NO_TAKEOFF, f"nobody took off within {now_s - self.started_s:.0f} s")
            return None
        if now_s - self._progress_s > STANDSTILL_S:
            return (Ending.STANDSTILL, f"nothing has been heard of {unsettled} for {STANDSTILL_S:.0f} s")
        limit_s = self.time_limit_s + RETURN_ALLOWANCE_S
        if self.newest_stamp_ms - self.first_take_off_ms > 1000.0 * limit_s:
            return (Ending.TIME_LIMIT, f"{unsettled} still out {RETURN_ALLOWANCE_S:.0f} s after stop.time_limit_s")
        return self._abandoned(unsettled, now_s)

    def _abandoned(self, unsettled: str, now_s: float) -> tuple[Ending, str] | None:
        """Give up on vehicles without agents that do not land, once everybody else is done."""
        if any(r.agent_lives(now_s) and not r.settled(now_s) for r in self.vehicles.values()):
            self._waiting_since_ms = None
            return None
        if self._waiting_since_ms is None:
            self._waiting_since_ms = self.newest_stamp_ms
        if self.newest_stamp_ms - self._waiting_since_ms > 1000.0 * RETURN_ALLOWANCE_S:
            text = f"{unsettled} lost its agent and did not land within {RETURN_ALLOWANCE_S:.0f} s"
            return (Ending.NOT_LANDED, text)
        return None


def _metres(position_cm: PositionCm) -> Point:
    east, north, up = position_cm
    return (east / 100.0, north / 100.0, up / 100.0)
