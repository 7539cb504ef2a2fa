"""Named conditions of vehicles: what is wrong, what the fleet does about it by itself, and what the operator can do.

Pure: a picture goes in, findings come out. The reducer turns findings into troubles that begin, last and end.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from ground_station.liveliness import HEARTBEAT_S, agent_died, autopilot_words
from ground_station.text import age
from ground_station.vehicle_picture import Condition, VehiclePicture
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.wire.messages import Severity, Stage, Status

STUCK_S = 60.0
ASTRAY_S = 6.0
SILENT_AUTOPILOT_S = 3.0
RIVAL_WINDOW_S = 10.0
SKEW_S = 3.0
DETOUR = 1.5
"""The way home is reckoned longer than the straight line by this factor."""
FLYING = (Stage.TAKING_OFF, Stage.WORKING, Stage.HOLDING, Stage.RETURNING, Stage.YIELDED)


class Kind(Enum):
    """What can be wrong with a vehicle; the value is its name on the screen."""

    AGENT_DEAD = "agent dead"
    OUT_OF_REACH = "out of reach"
    DUPLICATE = "two agents"
    DUPLICATE_ID = "duplicate id"
    AUTOPILOT_SILENT = "autopilot silent"
    LOW_BATTERY = "low battery"
    ASTRAY = "diverging"
    STUCK = "stuck"
    CLOCK_SKEW = "clock skew"
    PILOT = "pilot flies"
    REFUSED = "refused"
    SUSPECT = "suspect"


SEVERITIES: Mapping[Kind, Severity] = {
    Kind.AGENT_DEAD: Severity.ERROR,
    Kind.OUT_OF_REACH: Severity.ERROR,
    Kind.DUPLICATE: Severity.ERROR,
    Kind.DUPLICATE_ID: Severity.ERROR,
    Kind.AUTOPILOT_SILENT: Severity.ERROR,
    Kind.LOW_BATTERY: Severity.WARNING,
    Kind.ASTRAY: Severity.WARNING,
    Kind.STUCK: Severity.WARNING,
    Kind.CLOCK_SKEW: Severity.WARNING,
    Kind.PILOT: Severity.WARNING,
    Kind.REFUSED: Severity.WARNING,
    Kind.SUSPECT: Severity.NOTICE,
}

ADVICE: Mapping[Kind, tuple[str, str]] = {
    Kind.AGENT_DEAD: (
        "its autopilot's failsafe brings it home, straight, also through no-fly zones; teammates take over its ground "
        "and keep its way home clear",
        "watch it land; start its agent anew on the ground, or in the air to resume from its journal",
    ),
    Kind.OUT_OF_REACH: (
        "it goes on by itself; teammates take over its ground once they no longer hear it",
        "wait for it to come back into reach; move the antenna; if it was called home it will land there",
    ),
    Kind.DUPLICATE: (
        "nothing: each of the two believes to lead the vehicle",
        "stop one of the two programs that use this vehicle's name, or give one another name",
    ),
    Kind.DUPLICATE_ID: (
        "an agent that hears both refuses to fly; one in flight cannot tell them apart",
        "give each autopilot a system id of its own; if it is one vehicle heard by two ways, mute this (m)",
    ),
    Kind.AUTOPILOT_SILENT: (
        "its agent gives no orders; the autopilot, if it lives, is under its own failsafe",
        "check the cable or the MAVLink port; take over with the remote control",
    ),
    Kind.LOW_BATTERY: (
        "a vehicle at work turns home by itself when its reserve demands it; one that holds does not",
        "call it home (b), or land it where it is (L)",
    ),
    Kind.ASTRAY: (
        "its agent keeps ordering the leg anew",
        "look for wind or a pilot; hold it (h) or call it home (b)",
    ),
    Kind.STUCK: (
        "it waits for a free way; teammates go on",
        "send it somewhere else (o), or call it home (b)",
    ),
    Kind.CLOCK_SKEW: (
        "maps still merge, but who saw ground first is judged by wrong times",
        "check the GPS time of this vehicle",
    ),
    Kind.PILOT: (
        "its agent watches and gives no orders until the mode is guided again",
        "hand the vehicle back with the mode switch, or resume it (r)",
    ),
    Kind.REFUSED: (
        "it stays on the ground; the others share its work",
        "read its last event, mend the cause, start its agent anew",
    ),
    Kind.SUSPECT: ("nothing yet", "wait a moment"),
}


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that is wrong now."""

    kind: Kind
    severity: Severity
    text: str


@dataclass(frozen=True, slots=True)
class Trouble:
    """A finding that lasts.

    Attributes
    ----------
    since_s
        Station time at which it began.
    acknowledged
        The operator has seen it.
    """

    vehicle: str
    kind: Kind
    severity: Severity
    text: str
    since_s: float
    acknowledged: bool = False

    @property
    def fleet_does(self) -> str:
        return ADVICE[self.kind][0]

    @property
    def operator_can(self) -> str:
        return ADVICE[self.kind][1]


@dataclass(frozen=True, slots=True)
class Moment:
    """What judging needs to know beside the vehicle.

    Attributes
    ----------
    now_s
        Station time.
    pace
        Vehicle seconds per station second.
    clock_ms
        Median of what the vehicles' clocks would show now; None with fewer than two running clocks.
    """

    now_s: float
    pace: float
    clock_ms: float | None


def moment_of(vehicles: tuple[VehiclePicture, ...], now_s: float, pace: float) -> Moment:
    clocks = [clock for vehicle in vehicles if (clock := clock_ms(vehicle, now_s, pace)) is not None]
    return Moment(now_s, pace, statistics.median(clocks) if len(clocks) > 1 else None)


def clock_ms(vehicle: VehiclePicture, now_s: float, pace: float) -> float | None:
    """What a live vehicle's clock would show now, Unix milliseconds; None when it stands or is not heard."""
    status, silence_s = vehicle.status, vehicle.age_s(now_s)
    if status is None or silence_s is None or vehicle.condition is not Condition.LIVE or vehicle.evidence.repeats:
        return None
    return status.stamp_ms + 1_000 * pace * silence_s


def findings(vehicle: VehiclePicture, plan: MissionPlan, moment: Moment) -> list[Finding]:
    """Everything that is wrong with a vehicle now, worst first."""
    found = [*_link_findings(vehicle, moment)]
    status = vehicle.status
    if status is not None and vehicle.condition in (Condition.LIVE, Condition.SUSPECT):
        found += _clock_findings(vehicle, moment)
        if status.stage in FLYING:
            found += _flight_findings(vehicle, status, plan)
        if status.stage is Stage.YIELDED:
            found.append(_finding(Kind.PILOT, status.why))
        if status.stage is Stage.REFUSED:
            found.append(_finding(Kind.REFUSED, status.why or "its agent will not fly"))
    return sorted(found, key=lambda one: (one.severity, list(Kind).index(one.kind)))


def _finding(kind: Kind, text: str, severity: Severity | None = None) -> Finding:
    return Finding(kind, severity or SEVERITIES[kind], text)


def _link_findings(vehicle: VehiclePicture, moment: Moment) -> list[Finding]:
    found = []
    if vehicle.condition is Condition.LOST:
        if agent_died(vehicle):
            found.append(_finding(Kind.AGENT_DEAD, f"its agent is gone{autopilot_words(vehicle, moment.now_s)}"))
        else:
            silent = f"silent for longer than its link's lease{autopilot_words(vehicle, moment.now_s)}"
            found.append(_finding(Kind.OUT_OF_REACH, silent))
    elif vehicle.condition is Condition.SUSPECT:
        found.append(_finding(Kind.SUSPECT, "its status is overdue"))
    rivals = [at_s for at_s in vehicle.evidence.rivals_s if moment.now_s - at_s <= RIVAL_WINDOW_S]
    if len(rivals) > 1:
        found.append(_finding(Kind.DUPLICATE, f"two programs speak as {vehicle.name} in turn"))
    sources = vehicle.autopilot.sources if vehicle.autopilot is not None else ()
    fresh = sorted(name for name, heard_s in sources if moment.now_s - heard_s <= HEARTBEAT_S)
    if len(fresh) > 1:
        found.append(_finding(Kind.DUPLICATE_ID, f"autopilots with its system id speak at {' and '.join(fresh)}"))
    return found


def _clock_findings(vehicle: VehiclePicture, moment: Moment) -> list[Finding]:
    evidence = vehicle.evidence
    stood_s = moment.now_s - evidence.stamp_grew_s
    if evidence.repeats > 1 and stood_s > SILENT_AUTOPILOT_S:
        return [_finding(Kind.AUTOPILOT_SILENT, f"its agent speaks, its autopilot has not for {age(stood_s)}")]
    own_ms = clock_ms(vehicle, moment.now_s, moment.pace)
    if own_ms is None or moment.clock_ms is None:
        return []
    skew_s = (own_ms - moment.clock_ms) / 1_000
    if abs(skew_s) <= SKEW_S * max(1.0, moment.pace):
        return []
    return [_finding(Kind.CLOCK_SKEW, f"its clock is {age(abs(skew_s))} {'ahead' if skew_s > 0 else 'behind'}")]


def _flight_findings(vehicle: VehiclePicture, status: Status, plan: MissionPlan) -> list[Finding]:
    evidence = vehicle.evidence
    found = []
    at_rest_s = (status.stamp_ms - evidence.rest_since_ms) / 1_000
    if at_rest_s > STUCK_S:
        found.append(_finding(Kind.STUCK, f"has not got on for {age(at_rest_s)}: {status.why}"))
    astray_s = (status.stamp_ms - evidence.astray_since_ms) / 1_000
    if evidence.astray_since_ms and astray_s > ASTRAY_S and status.stage is not Stage.TAKING_OFF:
        found.append(_finding(Kind.ASTRAY, f"far from its leg for {age(astray_s)}"))
    drain_per_s = evidence.drain_per_s(status)
    if drain_per_s is not None:
        found += _battery_findings(vehicle, status, plan, drain_per_s)
    return found


def _battery_findings(vehicle: VehiclePicture, status: Status, plan: MissionPlan, drain_per_s: float) -> list[Finding]:
    away_m = math.dist(status.position_cm[:2], status.home_cm[:2]) / 100
    way_s = away_m / plan.mission.vehicles[vehicle.index].speed_m_s
    left, needed = status.battery_permille, drain_per_s * way_s
    text = f"{left / 10:.0f} % left, the way home of {away_m:.0f} m needs {max(1.0, needed / 10):.0f} %"
    if left < needed:
        return [_finding(Kind.LOW_BATTERY, text, Severity.ERROR)]
    spare = left - DETOUR * needed - 1_000 * plan.mission.stop.battery_reserve
    return [_finding(Kind.LOW_BATTERY, text)] if spare < 0 and status.stage is not Stage.RETURNING else []


def astray_limit_m(plan: MissionPlan, index: int) -> float:
    """How far from its leg a vehicle may be in a wide turn."""
    return max(30.0, 4.0 * plan.mission.vehicles[index].speed_m_s)
