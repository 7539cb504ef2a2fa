"""Lanes: decentralised exploration along ways that the team makes shorter together as it flies.

Every vehicle knows the team's plan: for each vehicle a way of straight lanes that together are expected to show all
that is unseen. Whoever decides takes the latest plan it heard of, drops what has been flown, tries some changes by what
the team's map shows now, and tells the plan that came of it. Nobody is in the middle, and no trial is lost: the plan is
annealed by the whole team. Ground too large for lanes, what lanes cannot lead to, and what one vehicle alone is sent to
see is left to tours.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.planning.frontier_travel import bearing_word
from vehicle_agent.planning.interface import Decision, Observation, Situation, Waypoint
from vehicle_agent.planning.team_lanes import LanesParams, TeamLanes
from vehicle_agent.planning.tour_explorer import TourExplorer
from vehicle_agent.planning.travel import EastNorth, along, beyond, next_leg, next_step

PLAN_HOLDS = 0.75
"""A plan is followed for this many sensing ranges before it is mended again."""
LONGEST_WAY = 60.0
"""Lanes are planned once what is unseen fits into ways of so many sensing ranges, each 1.5 ranges wide."""
LAST_GROUND = 1.0
"""With less unseen than this many squared sensing ranges for each vehicle the plan is mended at every step."""
LEAST_PROGRESS, PROGRESS_OVER = 0.02, 6
"""Where over so many steps the team sees less than so many squared sensing ranges per vehicle and step, tours lead."""
ARRIVED = 0.6
"""A bend is reached within so many steps."""
KEPT_HEADING = math.cos(0.4)
"""A leg is flown on while the way leads on within so many radians of it (its cosine)."""


class LaneExplorer:
    """One vehicle's part in the team's lanes.

    Parameters
    ----------
    home_en_m
        Where vehicles return to; None when they need not.
    tours
        Leads where lanes do not.
    """

    def __init__(self, home_en_m: EastNorth | None, tours: TourExplorer, params: LanesParams | None = None) -> None:
        self._params = params or LanesParams()
        self._home_en_m = home_en_m
        self._tours = tours
        self._lanes: TeamLanes | None = None
        self._waypoint: Waypoint | None = None
        self._leg_end: Point = (0.0, 0.0, 0.0)
        self._steps_left = 0
        self._steps = 0
        self._unseen_at: tuple[int, float] = (0, math.inf)
        self._without_lanes = False
        self._area: BoolArray | None = None
        self._area_cells = self._most_cells = 0

    def tell(self, observation: Observation) -> None:
        """Nothing is learned from measurements beyond the map."""

    def ask(self, situation: Situation) -> Decision:
        if self._lanes is None:
            self._lanes = TeamLanes(situation, self._home_en_m, self._params)
        if self._has_less_to_see(situation.area_cells):
            self._waypoint, self._steps_left = None, 0
            return self._tours.ask(situation)
        self._lanes.adopt(situation)
        self._steps_left -= 1
        self._steps += 1
        step = self._fly_on(situation, self._lanes)
        if step is not None:
            return step
        self._waypoint = None
        if self._steps_left <= 0 and not self._mend(situation, self._lanes):
            return self._tours.ask(situation)
        return self._follow(situation, self._lanes)

    def _fly_on(self, situation: Situation, lanes: TeamLanes) -> Waypoint | None:
        """The next step of the present leg; None where it ends, or the way leads elsewhere by now."""
        here, before = situation.position_enu_m, self._waypoint
        if before is None or self._steps_left <= 0 or self._leads_elsewhere(here, lanes.first_bend_en_m):
            return None
        step = next_step(here, self._leg_end, situation.constraints)
        if step is None:
            return None
        return Waypoint(step, before.why, before.goal_enu_m, before.goal_cost_m, before.route_enu_m, None, before.lanes)

    def _has_less_to_see(self, area_cells: BoolArray) -> bool:
        """Whether this is a part only of what there was to see: a plan for it would lead teammates there, too."""
        if area_cells is not self._area:
            self._area, self._area_cells = area_cells, int(np.count_nonzero(area_cells))
            self._most_cells = max(self._most_cells, self._area_cells)
        return self._area_cells < self._most_cells

    def _mend(self, situation: Situation, lanes: TeamLanes) -> bool:
        """Make the plan better; False when the ground is not one for lanes."""
        ranges2_each = lanes.unseen_ranges2(situation) / (1 + len(situation.teammates))
        since, before = self._unseen_at
        if self._steps - since >= PROGRESS_OVER:
            self._without_lanes |= before - ranges2_each < LEAST_PROGRESS * (self._steps - since)
            self._unseen_at = (self._steps, ranges2_each)
        if self._without_lanes or not 0.0 < ranges2_each < 1.5 * LONGEST_WAY:
            lanes.drop()
            return False
        holds = max(1, round(PLAN_HOLDS * situation.range_m / situation.constraints.reach_m))
        self._steps_left = holds
        if not lanes.has_plan:  # teammates mend the plan by turns
            self._steps_left -= situation.index % holds
        if ranges2_each < LAST_GROUND:
            self._steps_left = 1
        lanes.mend(situation)
        return True

    def _leads_elsewhere(self, here_enu_m: Point, bend_en_m: EastNorth | None) -> bool:
        """Whether the own way turns off from the present leg: teammates mend it, too."""
        if bend_en_m is None:
            return True
        east_m, north_m = self._leg_end[0] - here_enu_m[0], self._leg_end[1] - here_enu_m[1]
        to_bend_east_m, to_bend_north_m = bend_en_m[0] - here_enu_m[0], bend_en_m[1] - here_enu_m[1]
        lengths_m2 = math.hypot(east_m, north_m) * math.hypot(to_bend_east_m, to_bend_north_m)
        return east_m * to_bend_east_m + north_m * to_bend_north_m < KEPT_HEADING * lengths_m2

    def _follow(self, situation: Situation, lanes: TeamLanes) -> Decision:
        """The next leg of the own way; where none is left of it or it is barred, tours lead."""
        constraints, here = situation.constraints, situation.position_enu_m
        bends = lanes.bends_en_m()
        while bends and math.dist(bends[0], here[:2]) < ARRIVED * constraints.reach_m:
            del bends[0]
            lanes.reached_first()
        end = self._leg(situation, bends) if bends else None
        if end is None:
            decision = self._tours.ask(situation)
            return dataclasses.replace(decision, lanes=lanes.plan) if isinstance(decision, Waypoint) else decision
        self._leg_end = end
        away_m = math.dist(bends[0], here[:2])
        route = tuple((east_m, north_m, end[2]) for east_m, north_m in bends[:12])
        why = f"lane {away_m:.0f} m {bearing_word(here[:2], bends[0])}, first of {len(bends)} in its way"
        step = along(here, end, constraints.reach_m)
        self._waypoint = Waypoint(step, why, route[0], away_m, route, None, lanes.plan)
        return self._waypoint

    def _leg(self, situation: Situation, bends: list[EastNorth]) -> Point | None:
        constraints, here = situation.constraints, situation.position_enu_m
        target, away_m = bends[0], math.dist(bends[0], here[:2])
        if away_m < constraints.reach_m and len(bends) > 1:
            target = beyond(target, bends[1], constraints.reach_m - away_m)
        steps = max(1, self._steps_left)
        return next_leg(here, target, constraints, steps)
