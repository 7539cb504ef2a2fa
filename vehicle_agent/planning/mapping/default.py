"""Our planner of map missions: every vehicle alone chooses its next work site some visits ahead, and how to fly there.

Landmarks are gathered in cells. Of each cell the planner knows how much is left to do, from where, and how long that
takes by the sensor's equation. It looks several visits ahead for the most work in the least time, leaves to teammates
what they go for and most of what they are nearer to, and takes what lies beside its way when that is worth the time.
Vehicles keep company in small groups: a group's first goes where it likes within the group's own part of the area, the
others work where they still hear it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.planning.interface import Decision, Finished, Teammate, Wait, Waypoint
from vehicle_agent.planning.mapping.interface import MappingSituation
from vehicle_agent.planning.mapping.work_sites import ViewpointParams, WorkSites

_MISSED_STEPS = 15
"""So long a teammate that is not heard is looked for where it was heard last; then it counts as lost."""
_PATIENT_STEPS, _PROGRESS = 4, 0.2
"""So long, and twice what its work should take, a vehicle stays where not even this part of a landmark gets done."""
_PULLED_STEPS, _YIELDED_STEPS = 6, 30
"""So long a mate may go for what is far from this vehicle's goal before this one yields, and how long it yields."""


class ViewpointPlanner:
    """Decides for one vehicle of a team; without dice, so that the same situations give the same decisions."""

    def __init__(self, vehicles: int, params: ViewpointParams | None = None) -> None:
        self._vehicles = vehicles
        self._params = params or ViewpointParams()
        self._sites: WorkSites | None = None
        self._directions = _ways()
        self._goal: int | None = None
        self._tired: set[int] = set()
        self._worth = 1.0
        self._stay, self._left = 0, 0.0
        self._last_heard: dict[int, Teammate] = {}
        self._silent: dict[int, int] = {}
        self._pulled = self._yields = 0

    def ask(self, situation: MappingSituation) -> Decision:
        """Where to go next; `Finished` when nothing that is known to this vehicle is left to do."""
        if self._sites is None:
            self._sites = WorkSites(situation, self._params, self._vehicles)
        sites = self._sites
        sites.update(situation)
        if not sites.work.any():
            return Finished("every landmark is accurate or given up")
        goal, why = self._choose(situation, sites)
        end = self._step(situation, sites, goal)
        if end is None:
            return Wait("no way is open from here")
        return Waypoint(end, why, goal, math.dist(situation.position_enu_m, goal))

    def _choose(self, situation: MappingSituation, sites: WorkSites) -> tuple[Point, str]:
        """The viewpoint to go for."""
        here = np.array(situation.position_enu_m)
        leader = self._leader(situation)
        usable = sites.work > 0.0
        values = sites.values()
        if self._tired:
            rested = usable.copy()
            rested[list(self._tired)] = False
            if rested.any():
                usable = rested
            else:
                self._tired.clear()
        if leader is None:
            values = values * sites.preference[self._group(situation.index)]
        for mate in situation.teammates:
            if mate.goal_enu_m is not None and (leader is not None or mate.index < situation.index):
                usable[sites.lattice.cell_of(mate.goal_enu_m[0], mate.goal_enu_m[1])] = False
        if leader is not None:
            anchor = np.array(leader.goal_enu_m if leader.goal_enu_m is not None else leader.position_enu_m)
            near = np.linalg.norm(sites.viewpoints - anchor, axis=1) <= self._params.company * situation.radio_range_m
            if not np.any(usable & near):
                return _point(anchor), f"keeps near vehicle {leader.index}"
            usable &= near
        if not usable.any():
            usable = sites.work > 0.0
        site = sites.best_first(here, usable, values, situation.reach_m, self._goal)
        self._note(site, sites, here, situation)
        return _point(sites.viewpoints[site]), f"{int(sites.work[site])} landmarks to estimate there"

    def _note(self, site: int, sites: WorkSites, here: FloatArray, situation: MappingSituation) -> None:
        """Lose patience with a site that stays as it is though the vehicle has been there for long."""
        at_site = math.dist(sites.viewpoints[site, :2], here[:2]) <= 1.5 * situation.reach_m
        left = sites.left_at(site)
        if not at_site or site != self._goal or left <= self._left - _PROGRESS:
            self._stay, self._left = 0, left
        else:
            self._stay += 1
        if self._stay > _PATIENT_STEPS + 2 * sites.visits[site]:
            self._tired.add(site)
            self._stay = 0
        self._goal = site

    def _leader(self, situation: MappingSituation) -> Teammate | None:
        """Whom to keep near; None for who leads, and where the radio reaches everywhere or nobody is heard."""
        if math.isinf(situation.radio_range_m):
            return None
        self._silent = {index: silent + 1 for index, silent in self._silent.items()}
        for mate in situation.teammates:
            self._last_heard[mate.index], self._silent[mate.index] = mate, 0
        group = self._group(situation.index)
        mates = [
            mate
            for index, mate in self._last_heard.items()
            if self._group(index) == group and self._silent[index] <= _MISSED_STEPS
        ]
        if not mates and not situation.teammates:
            return None
        first = min(mates or situation.teammates, key=lambda mate: mate.index)
        if first.index < situation.index or not mates:
            return first
        if situation.index == 2 * group:
            return None  # nobody in the group goes before it
        return self._stronger(mates, situation.radio_range_m)

    def _stronger(self, mates: Sequence[Teammate], radio_range_m: float) -> Teammate | None:
        """A mate that keeps near somebody else, whom this vehicle does not hear: both would pull it until all stand.

        It tells itself by going for what is far from this vehicle's goal. It is followed for a while.
        """
        if self._yields > 0:
            self._yields -= 1
            return min(mates, key=lambda mate: mate.index)
        assert self._sites is not None
        own = None if self._goal is None else self._sites.viewpoints[self._goal]
        goals = [mate.goal_enu_m for mate in mates if mate.goal_enu_m is not None]
        away = own is not None and any(math.dist(goal, own) > self._params.company * radio_range_m for goal in goals)
        self._pulled = self._pulled + 1 if away else 0
        if self._pulled < _PULLED_STEPS:
            return None
        self._pulled, self._yields = 0, _YIELDED_STEPS
        return min(mates, key=lambda mate: mate.index)

    def _group(self, index: int) -> int:
        """Groups of two, the last of three where the number is odd."""
        return min(index // 2, max(self._vehicles // 2 - 1, 0))

    def _step(self, situation: MappingSituation, sites: WorkSites, goal: Point) -> Point | None:
        """The admissible leg that gains most: what is measured at its end, and the time it brings the goal nearer."""
        here = np.array(situation.position_enu_m)
        ends = here + situation.reach_m * self._directions
        ends[:, 2] = np.clip(ends[:, 2], situation.band.lowest_m, situation.band.highest_m)
        ends = ends[np.linalg.norm(ends - here, axis=1) <= situation.reach_m * (1.0 + 1e-9)]
        if len(ends) == 0:
            return None
        ends = ends[situation.admissible(ends)]
        if len(ends) == 0:
            return None
        gains = sites.gains(ends, situation)
        sites.ways_to(goal, situation)
        nearer = (sites.cost_to_go(here[None], goal)[0] - sites.cost_to_go(ends, goal)) / situation.reach_m
        scores = gains + self._worth * nearer
        best = int(np.argmax(scores))
        if nearer[best] < 0.05 and gains[best] < 0.2 * self._worth:
            best = int(np.argmax(ends[:, 2]))  # what is in the way is not where it was supposed: look from above
        self._worth = max(0.95 * self._worth + 0.05 * float(gains[best]), 0.3)
        sites.expect(ends[best])
        return _point(ends[best])


def _ways() -> FloatArray:
    """Directions of a leg, evenly over the sphere, whole and half, and to stay: (97, 3)."""
    count = 64
    up = 1.0 - 2.0 * (np.arange(count) + 0.5) / count
    turn = math.pi * (1.0 + math.sqrt(5.0)) * np.arange(count)
    flat = np.sqrt(1.0 - up**2)
    sphere = np.column_stack((flat * np.cos(turn), flat * np.sin(turn), up))
    return np.vstack((np.zeros((1, 3)), sphere, 0.5 * sphere[::2]))


def _point(place: FloatArray) -> Point:
    return (float(place[0]), float(place[1]), float(place[2]))
