"""What a vehicle means to fly next, and which teammates it must hear before it does.

What teammates reserve is heard late and not always. So where a teammate might reserve a crossing leg meanwhile, a leg
is told first as an intent, and flown once that teammate has been heard with a word from after it. Of two intents that
cross, the earlier has the way. Each vehicle compares a teammate's stamps with its own intent's only: of any two that
reserve, the later one has heard of the earlier one's leg before it flies, however late words come, however many are
lost and however much clocks differ. Where nobody is near enough to cross, and so on most legs, nobody waits.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from vehicle_agent.behaviour.leg import Leg
from vehicle_agent.behaviour.preflight import take_off_height_m
from vehicle_agent.domain.frames import Point, as_array
from vehicle_agent.domain.segments import segment_distance_m
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.planning.constraints import STRETCH
from vehicle_agent.planning.interface import Waypoint

Line = tuple[Point, Point]
"""From where to where, ENU metres."""


@dataclass(frozen=True, slots=True)
class Intent:
    """A leg that is told and not yet flown.

    Attributes
    ----------
    leg, waypoint
        As they will be flown.
    since_ms
        When it was first told, Unix milliseconds by the vehicle.
    since_s
        The same in the agent's time.
    """

    leg: Leg
    waypoint: Waypoint | None
    since_ms: int
    since_s: float


@dataclass(frozen=True, slots=True)
class Whereabouts:
    """Where a teammate flies by its last word.

    Attributes
    ----------
    index
        Team index.
    stamp_ms
        When it said so, Unix milliseconds by its own clock.
    heard_at_s
        When that was heard, in the agent's time.
    lines
        What it flies and means to fly.
    strayed_m
        So far it may have gone on by now.
    sets_out
        It is still on the ground, or on its way straight up from there.
    """

    index: int
    stamp_ms: int
    heard_at_s: float
    lines: tuple[Line, ...]
    strayed_m: float = 0.0
    sets_out: bool = False


def within_reach_m(plan: MissionPlan) -> float:
    """From farther off nobody's next leg, on the way or straight up from home, leads to within the separation."""
    up_m = max(take_off_height_m(plan, index) for index in range(len(plan.mission.vehicles)))
    return plan.mission.safety.separation_m + max(STRETCH * plan.mission.task.step_m, up_m)


def may_cross(lines: Iterable[Line], theirs: Iterable[Line], within_m: float) -> bool:
    """Whether any two lines come nearer than a distance."""
    others = [(as_array(start), as_array(end)) for start, end in theirs]
    return any(
        segment_distance_m(as_array(start), as_array(end), *other) < within_m
        for start, end in lines
        for other in others
    )


def awaited(
    lines: tuple[Line, ...],
    since_ms: int,
    since_s: float,
    mates: Iterable[Whereabouts],
    within_m: float,
    patience_s: float,
) -> list[int]:
    """Team indices of those who might have reserved a leg across `lines` without its being known here.

    Parameters
    ----------
    within_m
        See `within_reach_m`.
    patience_s
        A word heard so long after the intent counts, whatever its stamp: clocks may differ.
    """
    return [
        mate.index
        for mate in mates
        if mate.stamp_ms <= since_ms
        and mate.heard_at_s < since_s + patience_s
        and may_cross(lines, mate.lines, within_m + mate.strayed_m)
    ]
