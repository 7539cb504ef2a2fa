"""What a vehicle knows of its teammates: who is heard, where they fly, and what the silent ones may be doing."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from vehicle_agent.behaviour.goal_claim import heard_lanes
from vehicle_agent.behaviour.intent import Line, Whereabouts
from vehicle_agent.behaviour.leg import resting_place, swing
from vehicle_agent.behaviour.units import to_metres
from vehicle_agent.planning.constraints import Reservation
from vehicle_agent.planning.interface import AnnouncedTour, Teammate
from vehicle_agent.ports import FlightMode
from vehicle_agent.wire.messages import Claim, Stage, Status

HAZARD_S = 600.0
"""The way home of a silent vehicle is kept clear for no longer than this."""
FAILSAFE_S = 60.0
"""Until a silent vehicle's failsafe acts, and for its last metres to the ground."""
OVER_HOME_M = 5.0
"""A way home that ends so near to home goes on from there to the ground."""
ON_GROUND_FOR_GOOD = (Stage.DONE, Stage.REFUSED)
SETS_OUT = (Stage.CONNECTING, Stage.CONFIGURING, Stage.ARMING, Stage.TAKING_OFF)
UNSTOPPABLE = (Stage.TAKING_OFF, Stage.LANDING)
SLOWEST_RETURN_M_S, SLOWEST_CLIMB_M_S = 4.0, 1.0
"""No slower is a vehicle under its failsafe taken to fly home, and to climb and sink."""


@dataclass(slots=True)
class Heard:
    """The last words of one teammate and when they came, in this vehicle's time."""

    status: Status
    heard_at_s: float
    claim: Claim | None = None
    lost: bool = False


class TeamPicture:
    """Teammates by name."""

    def __init__(self, own_name: str, team: tuple[str, ...], silence_s: float) -> None:
        self._own_name = own_name
        self._team = team
        self._silence_s = silence_s
        self._heard: dict[str, Heard] = {}

    def hear_status(self, status: Status, now_s: float) -> bool:
        """Take a teammate's status; True when it had been lost and is back."""
        if status.sender == self._own_name or status.sender not in self._team:
            return False
        known = self._heard.get(status.sender)
        if known is None:
            self._heard[status.sender] = Heard(status, now_s)
            return False
        if status.boot_id == known.status.boot_id and status.sequence <= known.status.sequence:
            return False
        was_lost = known.lost
        known.status, known.heard_at_s, known.lost = status, now_s, False
        return was_lost

    def hear_of(self, name: str, now_s: float) -> None:
        """A teammate of which a status is known has been heard otherwise: it is still there."""
        if (known := self._heard.get(name)) is not None:
            known.heard_at_s = now_s

    def hear_claim(self, claim: Claim) -> None:
        known = self._heard.get(claim.sender)
        if known is None:
            return
        newer = known.claim is None or known.claim.boot_id != claim.boot_id or claim.sequence > known.claim.sequence
        if newer:
            known.claim = claim

    def newly_lost(self, now_s: float) -> list[str]:
        """Names of teammates that have just been silent for too long (once per silence)."""
        lost = []
        for name, known in self._heard.items():
            if not known.lost and now_s - known.heard_at_s > self._silence_s:
                known.lost = True
                lost.append(name)
        return lost

    def release(self, name: str) -> None:
        """Count a teammate as lost before its silence shows it."""
        self._heard[name].lost = True

    def knows(self, name: str) -> bool:
        """A teammate that has been heard, whether it still is or not."""
        return name in self._heard

    def living(self) -> list[str]:
        """Names of teammates that are heard, in team order."""
        return [name for name in self._team if name in self._heard and not self._heard[name].lost]

    def teammates(self) -> tuple[Teammate, ...]:
        """Living teammates that work, with what they claim."""
        working = []
        for name in self.living():
            known = self._heard[name]
            if known.status.stage not in (Stage.TAKING_OFF, Stage.WORKING, Stage.HOLDING):
                continue
            claim = known.claim if known.claim is not None and known.claim.active else None
            working.append(
                Teammate(
                    self._team.index(name),
                    to_metres(known.status.position_cm),
                    to_metres(claim.goal_cm) if claim else None,
                    float(claim.cost_m) if claim else 0.0,
                    AnnouncedTour(claim.tour_number, claim.tour) if claim and claim.tour else None,
                    heard_lanes(claim.lanes) if claim else None,
                )
            )
        return tuple(working)

    def reservations(self, now_s: float) -> tuple[Reservation, ...]:
        """Legs to keep clear of: those told by the living, and the way home of the silent and of who returns unled.

        Who rests disarmed is in nobody's way.
        """
        legs: list[Reservation] = []
        for name, known in self._heard.items():
            if not known.status.armed:
                continue
            index = self._team.index(name)
            if not known.lost:
                legs.extend(_told_legs(known.status, index))
            if known.lost or known.status.mode == FlightMode.RETURN.value:
                way = _way_home(known.status, index)
                if now_s - known.heard_at_s < min(HAZARD_S, FAILSAFE_S + _slowest_s(way)):
                    legs.extend(way)
        return tuple(legs)

    def whereabouts(self, now_s: float, speeds_m_s: Sequence[float]) -> tuple[Whereabouts, ...]:
        """Where the living who fly or may set out are by their last words; speeds by team index."""
        known = [(self._team.index(name), self._heard[name]) for name in self.living()]
        return tuple(
            Whereabouts(
                index,
                heard.status.stamp_ms,
                heard.heard_at_s,
                _lines(heard.status, index),
                speeds_m_s[index] * self._age_s(heard, now_s),
                heard.status.stage in SETS_OUT,
            )
            for index, heard in known
            if heard.status.armed or heard.status.stage not in ON_GROUND_FOR_GOOD
        )

    def _age_s(self, heard: Heard, now_s: float) -> float:
        """Since a teammate said its last words; a clock that differs by more than a silence is not believed."""
        return min(max(0.0, now_s - min(heard.heard_at_s, heard.status.stamp_ms / 1000.0)), self._silence_s)

    def passages(self, now_s: float) -> tuple[Reservation, ...]:
        """Where teammates must pass that cannot go elsewhere, so that nobody rests there who works.

        Besides the legs of those that cannot stop: up and down over the homes of who sets out and who comes back, and
        the straight way home of who comes back and is held up.
        """
        ways = [leg for leg in self.reservations(now_s) if leg.has_way]
        for name in self.living():
            status = self._heard[name].status
            here, leg_end, home = (to_metres(p) for p in (status.position_cm, status.leg_end_cm, status.home_cm))
            if status.stage is Stage.ARMING:
                ways.append(Reservation(here, leg_end, self._team.index(name)))
            elif status.stage is Stage.RETURNING:
                up = max(here[2], leg_end[2], key=lambda up_m: abs(up_m - home[2]))
                ways.append(Reservation((home[0], home[1], up), home, self._team.index(name)))
                if math.dist(here, leg_end) <= OVER_HOME_M and math.dist(here[:2], home[:2]) > OVER_HOME_M:
                    ways.append(Reservation(here, (home[0], home[1], here[2]), self._team.index(name)))
        return tuple(ways)


def _told_legs(status: Status, index: int) -> list[Reservation]:
    """The leg that a living vehicle tells; that of one who returns goes on from over its home to the ground."""
    here, leg_end, home = (to_metres(p) for p in (status.position_cm, status.leg_end_cm, status.home_cm))
    if status.stage is Stage.ARMING:
        leg_end = here
    legs = [Reservation(here, leg_end, index, status.stage in UNSTOPPABLE), *_next_legs(status, index)]
    rest = resting_place(here, to_metres(status.velocity_cm_s))
    legs.extend(Reservation(*line, index) for line in swing(here, rest, leg_end))
    if status.stage is Stage.RETURNING and math.dist(leg_end[:2], home[:2]) <= OVER_HOME_M:
        legs.append(Reservation(leg_end, home, index))
    return legs


def _next_legs(status: Status, index: int) -> list[Reservation]:
    """The leg that a vehicle means to fly next: from where it is, or from where its present leg ends."""
    if status.next_end_cm is None:
        return []
    here, leg_end, next_end, home = (
        to_metres(p) for p in (status.position_cm, status.leg_end_cm, status.next_end_cm, status.home_cm)
    )
    starts = [here] if status.stage is Stage.ARMING else [here, leg_end]
    since_ms = max(1, status.stamp_ms - status.next_told_ms)
    legs = [Reservation(start, next_end, index, since_ms=since_ms) for start in starts]
    if status.stage is Stage.RETURNING and math.dist(next_end[:2], home[:2]) <= OVER_HOME_M:
        legs.append(Reservation(next_end, home, index, since_ms=since_ms))
    return legs


def _lines(status: Status, index: int) -> tuple[Line, ...]:
    """All that a vehicle has told of where it flies."""
    lines = [(leg.start_enu_m, leg.end_enu_m) for leg in _told_legs(status, index)]
    if status.stage is Stage.RETURNING:
        here, home = to_metres(status.position_cm), to_metres(status.home_cm)
        lines.append(((home[0], home[1], here[2]), home))
    return tuple(lines)


def _way_home(status: Status, index: int) -> list[Reservation]:
    """The leg it was on, and its autopilot's own return: up, across, down."""
    here, leg_end, home = (to_metres(p) for p in (status.position_cm, status.leg_end_cm, status.home_cm))
    above_here = (leg_end[0], leg_end[1], max(status.return_up_cm * 0.01, leg_end[2]))
    above_home = (home[0], home[1], above_here[2])
    corners = (here, leg_end, above_here, above_home, home)
    return [Reservation(start, end, index, has_way=True) for start, end in pairwise(corners)]


def _slowest_s(way: list[Reservation]) -> float:
    """Time that a vehicle needs at most for a way that it flies under its failsafe."""
    return sum(
        math.dist(leg.start_enu_m[:2], leg.end_enu_m[:2]) / SLOWEST_RETURN_M_S
        + abs(leg.end_enu_m[2] - leg.start_enu_m[2]) / SLOWEST_CLIMB_M_S
        for leg in way
    )
