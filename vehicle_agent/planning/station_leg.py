"""The next leg towards a place in the air: straight where that is allowed, higher or around where not."""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.domain.frames import Point
from vehicle_agent.planning.constraints import Constraints
from vehicle_agent.planning.travel import next_leg

HEIGHTS_TRIED = 12


def leg_to_station(here: Point, there: Point, constraints: Constraints) -> Point | None:
    """End of the next admissible leg; None when there is none now.

    The straight line first; then higher and higher over its end; then the way around by known ground.
    """
    away_m = math.dist(here, there)
    part = min(1.0, constraints.reach_m / away_m) if away_m > 0.0 else 1.0
    east, north, up = (h + part * (t - h) for h, t in zip(here, there, strict=True))
    ends = np.empty((HEIGHTS_TRIED, 3))
    ends[:, 0], ends[:, 1] = east, north
    ends[:, 2] = up + np.linspace(0.0, 1.0, HEIGHTS_TRIED) ** 2 * constraints.reach_m
    admissible = constraints.admissible(here, ends)
    if admissible.any():
        best = ends[int(np.argmax(admissible))]
        return (float(best[0]), float(best[1]), float(best[2]))
    return next_leg(here, (there[0], there[1]), constraints)
