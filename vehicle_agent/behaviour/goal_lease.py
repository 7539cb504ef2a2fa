"""Which teammates still get on with what they went for: the word that one gave it up may have been lost."""

from __future__ import annotations

import math
from collections.abc import Iterable

from vehicle_agent.domain.frames import Point
from vehicle_agent.planning.interface import Teammate

LEASE_S = 30.0
"""Longer than a vehicle waits for the words of teammates on a bad radio."""
STAYS_M = 1.0
"""Within so much a vehicle counts as staying where it is."""


class GoalLeases:
    """One vehicle's view of its teammates' goals."""

    def __init__(self) -> None:
        self._last_seen: dict[int, tuple[Point, Point, float]] = {}

    def any_holds(self, teammates: Iterable[Teammate], now_s: float) -> bool:
        """Whether a teammate has a goal and has had another one, or moved, not long ago."""
        holds = [self._holds(mate, now_s) for mate in teammates]  # of all: each is noted
        return any(holds)

    def _holds(self, mate: Teammate, now_s: float) -> bool:
        if mate.goal_enu_m is None:
            return False
        goal, place, since_s = self._last_seen.get(mate.index, (None, mate.position_enu_m, now_s))
        if goal != mate.goal_enu_m or math.dist(place, mate.position_enu_m) > STAYS_M:
            place, since_s = mate.position_enu_m, now_s
        self._last_seen[mate.index] = (mate.goal_enu_m, place, since_s)
        return now_s - since_s < LEASE_S
