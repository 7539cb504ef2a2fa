"""Going for a chosen frontier: what every frontier planner does once it has chosen."""

from __future__ import annotations

import math

from vehicle_agent.planning.given_up import GivenUp
from vehicle_agent.planning.interface import Decision, Situation, Wait, Waypoint
from vehicle_agent.planning.travel import next_leg, way_length_m

_COMPASS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")


def bearing_word(from_en_m: tuple[float, float], to_en_m: tuple[float, float]) -> str:
    """Eight-point compass word of a direction."""
    angle = math.degrees(math.atan2(to_en_m[0] - from_en_m[0], to_en_m[1] - from_en_m[1])) % 360.0
    return _COMPASS[round(angle / 45.0) % 8]


def go_for(
    situation: Situation, goal_en_m: tuple[float, float], cell_index: int, given_up: GivenUp, remark: str
) -> Decision:
    """The next leg to a chosen frontier cell, with the words that explain it."""
    here = situation.position_enu_m
    away_m = way_length_m(here, goal_en_m)
    what = f"frontier {away_m:.0f} m {bearing_word(here[:2], goal_en_m)}"
    end = next_leg(here, goal_en_m, situation.constraints)
    let_go = given_up.waited(cell_index) if end is None else given_up.chose(cell_index, away_m)
    if let_go:
        return Wait(f"gave up {what}: no way to see beyond it")
    if end is None:
        return Wait(f"{what}: the way is taken")
    goal = (goal_en_m[0], goal_en_m[1], end[2])
    return Waypoint(end, f"{what}, {remark}", goal, away_m, (goal,))
