"""Tells teammates which goal a vehicle goes for, and lets it go."""

from __future__ import annotations

import math

from vehicle_agent.behaviour.units import to_centimetres
from vehicle_agent.behaviour.voice import Voice
from vehicle_agent.domain.frames import Point
from vehicle_agent.planning.interface import AnnouncedLanes, AnnouncedTour, Waypoint
from vehicle_agent.wire.messages import Claim, LanePlan

SAME_GOAL_M = 1.0


class GoalClaim:
    """One vehicle's claim, said when it changes."""

    def __init__(self, voice: Voice) -> None:
        self._voice = voice
        self._claimed: Point | None = None
        self._tour: AnnouncedTour | None = None
        self._lanes: AnnouncedLanes | None = None

    def follow(self, waypoint: Waypoint | None) -> None:
        """Claim the goal and the tour of what is flown now; without a goal let the last ones go."""
        if waypoint is None or waypoint.goal_enu_m is None:
            self.release()
            return
        same_goal = self._claimed is not None and math.dist(self._claimed, waypoint.goal_enu_m) <= SAME_GOAL_M
        if same_goal and (waypoint.tour, waypoint.lanes) == (self._tour, self._lanes):
            return
        self._claimed, self._tour, self._lanes = waypoint.goal_enu_m, waypoint.tour, waypoint.lanes
        self._voice.say(
            Claim,
            active=True,
            goal_cm=to_centimetres(self._claimed),
            cost_m=round(waypoint.goal_cost_m),
            tour_number=self._tour.number if self._tour else 0,
            tour=self._tour.patches if self._tour else (),
            lanes=told_lanes(self._lanes),
        )

    def release(self) -> None:
        if self._claimed is not None:
            self._voice.say(Claim, active=False, goal_cm=to_centimetres(self._claimed), cost_m=0)
            self._claimed = self._tour = self._lanes = None


def told_lanes(lanes: AnnouncedLanes | None) -> LanePlan | None:
    """A plan of lanes as it is told."""
    if lanes is None:
        return None
    return LanePlan(lanes.number, lanes.by, lanes.vehicles, lanes.ways, lanes.flown)


def heard_lanes(lanes: LanePlan | None) -> AnnouncedLanes | None:
    """A plan of lanes as it was heard."""
    if lanes is None:
        return None
    return AnnouncedLanes(lanes.number, lanes.by, lanes.vehicles, lanes.ways, lanes.flown)
