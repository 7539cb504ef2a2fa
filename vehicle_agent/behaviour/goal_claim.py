"""Tells teammates which goal a vehicle goes for, and lets it go."""

from __future__ import annotations

import math

from vehicle_agent.behaviour.units import to_centimetres
from vehicle_agent.behaviour.voice import Voice
from vehicle_agent.domain.frames import Point
from vehicle_agent.planning.interface import Waypoint
from vehicle_agent.wire.messages import Claim

SAME_GOAL_M = 1.0


class GoalClaim:
    """One vehicle's claim, said when it changes."""

    def __init__(self, voice: Voice) -> None:
        self._voice = voice
        self._claimed: Point | None = None

    def follow(self, waypoint: Waypoint | None) -> None:
        """Claim the goal of what is flown now; without a goal let the last one go."""
        if waypoint is None or waypoint.goal_enu_m is None:
            self.release()
        elif self._claimed is None or math.dist(self._claimed, waypoint.goal_enu_m) > SAME_GOAL_M:
            self._claimed = waypoint.goal_enu_m
            goal_cm, cost_m = to_centimetres(self._claimed), round(waypoint.goal_cost_m)
            self._voice.say(Claim, active=True, goal_cm=goal_cm, cost_m=cost_m)

    def release(self) -> None:
        if self._claimed is not None:
            self._voice.say(Claim, active=False, goal_cm=to_centimetres(self._claimed), cost_m=0)
            self._claimed = None
