"""The way up and down over a vehicle's home: whether teammates leave it free.

Homes may lie nearer to each other than teammates keep apart in flight. So two vehicles that go straight up or down over
their homes are not in each other's way; whoever flies or hovers there is.
"""

from __future__ import annotations

import math

from vehicle_agent.behaviour.guide import Surroundings
from vehicle_agent.domain.frames import Point
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.planning.constraints import Reservation, Traffic

AT_HOME_M = 5.0
"""A vehicle that goes straight down so near to its start goes home."""
STRAIGHT_M = 1.0
"""A leg that goes no further sideways is straight up or down."""


class HomeColumn:
    """One vehicle's way between its home and where it works."""

    def __init__(self, plan: MissionPlan, index: int) -> None:
        self._plan, self._index = plan, index

    def rival(self, around: Surroundings, end_enu_m: Point, since_ms: int = 0) -> str:
        """Name of a teammate in the way from where the vehicle is to above or below there; empty when there is none.

        Of those who only mean to pass, who said so later than `since_ms` is not in the way.
        """
        traffic = Traffic(around.reservations, self._plan.mission.safety.separation_m)
        for rival in traffic.conflicts(around.state.position_enu_m, end_enu_m):
            if rival.precedes_intent(since_ms, self._index) and not self._goes_straight_home(rival):
                return self._plan.vehicle_names[rival.owner_index]
        return ""

    def _goes_straight_home(self, rival: Reservation) -> bool:
        """Whether a teammate goes up or down over its own home and cannot do otherwise."""
        start_en_m = self._plan.mission.vehicles[rival.owner_index].start_enu_m[:2]
        return (
            rival.has_way
            and math.dist(rival.start_enu_m[:2], rival.end_enu_m[:2]) <= STRAIGHT_M
            and math.dist(rival.start_enu_m[:2], start_en_m) <= AT_HOME_M
        )
