"""The mending of a plan of lanes, a part at a time, so that who plans still hears and speaks."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.lane_trials import Ways
from vehicle_agent.domain.shared_lanes import Annealing, LaneCosts, mend_lanes
from vehicle_agent.planning.lane_ground import Outlook


@dataclass(frozen=True, slots=True)
class LaneMending:
    """A plan that is being mended.

    Attributes
    ----------
    number
        Of the plan that will come of it.
    vehicles
        Team indices of those planned for.
    place_enu_m
        From where its vehicle decides.
    outlook, costs
        What the ways are for, and what makes them dear.
    ways
        Where the annealing has come to, in blocks of the outlook's window; those to be flown when it is done.
    annealing
        How far it is.
    rng
        Of what is tried.
    """

    number: int
    vehicles: tuple[int, ...]
    place_enu_m: Point
    outlook: Outlook
    costs: LaneCosts
    ways: Ways
    annealing: Annealing
    rng: np.random.Generator

    def is_for(self, vehicles: tuple[int, ...], place_enu_m: Point, within_m: float) -> bool:
        """Whether it is for these vehicles, and for a decision made about there."""
        return self.vehicles == vehicles and math.dist(self.place_enu_m[:2], place_enu_m[:2]) < within_m

    def go_on(self, most: int) -> bool:
        """Try so many changes more at most; True when all were tried."""
        window, sight = self.outlook.window, self.outlook.sight
        return mend_lanes(self.ways, self.annealing, sight, window.unseen, self.costs, most, self.rng)

    def finished_ways(self) -> list[FloatArray]:
        """Try what is left, and return all ways: (bends, 2) float64 each, blocks of the whole ground."""
        self.go_on(self.annealing.trials)
        corner = self.outlook.window.corner
        return [bends[1:count] + corner for bends, count in zip(self.ways.bends, self.ways.counts, strict=True)]
