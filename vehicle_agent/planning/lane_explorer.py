"""Lanes: decentralised exploration along ways that the team makes shorter together as it flies.

Every vehicle knows the team's plan: for each vehicle a way of straight lanes that together are expected to show all
that is unseen. Whoever decides takes the latest plan it heard of, drops what has been flown, tries some changes by what
the team's map shows now, and tells the plan that came of it. Nobody is in the middle, and no trial is lost: the plan is
annealed by the whole team. Over wide ground it is a plan for the part that lies nearest to the team. Ground in cells
too wide for lanes, what lanes cannot lead to, and what one vehicle alone is sent to see is left to tours.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.planning.constraints import Constraints
from vehicle_agent.planning.frontier_travel import bearing_word
from vehicle_agent.planning.interface import Decision, Observation, Situation, Waypoint
from vehicle_agent.planning.own_way import OwnWay
from vehicle_agent.planning.team_lanes import LanesParams, TeamLanes
from vehicle_agent.planning.tour_explorer import TourExplorer
from vehicle_agent.planning.travel import WHOLE_STEP, EastNorth, beyond, next_leg

PLAN_HOLDS, LARGE_TEAM_HOLDS = 0.75, 1.0
"""A plan is followed for so many sensing ranges before it is mended again; longer where so many others mend it, too."""
LEAST_PROGRESS, PROGRESS_OVER = 0.02, 6
"""Where over so many steps the team sees less than so many squared sensing ranges per vehicle and step, tours lead."""
MOST_TOLD = 12
"""Bends in the route that an operator sees."""
THOUGHT = 5_000
"""Changes to the plan that are tried in one go while the vehicle flies: some fiftieths of a second."""
ARRIVED = 0.6
"""A bend, or the end of a step, is reached within so many steps."""


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
        self._ahead: list[_Step] = []
        self._steps_left = 0
        self._steps = 0
        self._unseen_at: tuple[int, float] = (0, math.inf)
        self._without_lanes = False
        self._area: BoolArray | None = None
        self._area_cells = self._most_cells = 0

    def tell(self, observation: Observation) -> None:
        """Nothing is learned from measurements beyond the map."""

    def think(self, situation: Situation, place_enu_m: Point) -> bool:
        lanes = self._lanes_over(situation)
        if self._is_led_by_tours(situation) or self._steps_left > 1:
            return True
        if lanes.ground.unseen_ranges2(situation) <= 0.0:
            return True
        lanes.begin(situation, place_enu_m)
        return lanes.go_on(THOUGHT)

    def ask(self, situation: Situation) -> Decision:
        lanes = self._lanes_over(situation)
        if self._is_led_by_tours(situation):
            self._ahead, self._steps_left = [], 0
            return self._tours.ask(situation)
        self._steps += 1
        self._steps_left -= 1
        step = self._fly_on(situation, lanes)
        if step is not None:
            return step
        self._ahead = []
        if self._steps_left <= 0 and not self._mend(situation, lanes):
            return self._tours.ask(situation)
        return self._follow(situation, lanes)

    def _lanes_over(self, situation: Situation) -> TeamLanes:
        if self._lanes is None:
            self._lanes = TeamLanes(situation, self._home_en_m, self._params)
            self._without_lanes = self._lanes.ground.is_too_wide
        return self._lanes

    def _is_led_by_tours(self, situation: Situation) -> bool:
        return self._has_less_to_see(situation.area_cells) or self._without_lanes

    def _fly_on(self, situation: Situation, lanes: TeamLanes) -> Waypoint | None:
        """The next of the steps decided on before; None where there is none, or it is barred by now."""
        here, ahead, constraints = situation.position_enu_m, self._ahead, situation.constraints
        arrived_m = ARRIVED * constraints.reach_m
        while ahead and math.dist(ahead[0].end_enu_m[:2], here[:2]) < arrived_m:  # if not flown, it is decided on again
            del ahead[0]
        if self._steps_left <= 0 or not ahead:
            return None
        lanes.own = lanes.own.passing(here, arrived_m)
        step = constraints.fit(here, ahead[0].end_enu_m[:2])
        if step is None or math.dist(step, here) < WHOLE_STEP * constraints.reach_m:
            return None
        if lanes.own.left and ahead[0].bends_left != lanes.own.bends_left:  # a bend came earlier or later than expected
            self._ahead = ahead = _foretell(here, [each.end_enu_m for each in ahead], lanes, arrived_m)
        told = ahead[0].told
        return Waypoint(step, told.why, told.goal_enu_m, told.goal_cost_m, told.route_enu_m, None, told.lanes)

    def _has_less_to_see(self, area_cells: BoolArray) -> bool:
        """Whether this is a part only of what there was to see: a plan for it would lead teammates there, too."""
        if area_cells is not self._area:
            self._area, self._area_cells = area_cells, int(np.count_nonzero(area_cells))
            self._most_cells = max(self._most_cells, self._area_cells)
        return self._area_cells < self._most_cells

    def _mend(self, situation: Situation, lanes: TeamLanes) -> bool:
        """Make the plan better; False when the ground is not one for lanes."""
        team = 1 + len(situation.teammates)
        ranges2_each = lanes.ground.unseen_ranges2(situation) / team
        since, before = self._unseen_at
        if self._steps - since >= PROGRESS_OVER:
            self._without_lanes |= before - ranges2_each < LEAST_PROGRESS * (self._steps - since)
            self._unseen_at = (self._steps, ranges2_each)
        if self._without_lanes or ranges2_each <= 0.0:
            lanes.drop()
            return False
        holds_m = (LARGE_TEAM_HOLDS if team > self._params.large_team else PLAN_HOLDS) * situation.range_m
        holds = max(1, round(holds_m / situation.constraints.reach_m))
        self._steps_left = holds
        if not lanes.has_plan:  # teammates mend the plan by turns
            self._steps_left -= situation.index % holds
        lanes.mend(situation)
        return True

    def _follow(self, situation: Situation, lanes: TeamLanes) -> Decision:
        """The next step of the own way; where none is left of it or it is barred, tours lead."""
        constraints, here = situation.constraints, situation.position_enu_m
        arrived_m = ARRIVED * constraints.reach_m
        lanes.own = lanes.own.passing(here, arrived_m)
        ends = _steps_along(here, lanes.own.bends_en_m(), max(1, self._steps_left), constraints)
        if not ends:
            decision = self._tours.ask(situation)
            return dataclasses.replace(decision, lanes=lanes.plan) if isinstance(decision, Waypoint) else decision
        self._ahead = _foretell(here, ends, lanes, arrived_m)
        return self._ahead[0].told


@dataclass(frozen=True, slots=True)
class _Step:
    """A step decided on.

    Attributes
    ----------
    end_enu_m
        Where it ends.
    bends_left
        Bends in the own way at its beginning.
    told
        What is told then: of several steps to the same bend, the first of them.
    """

    end_enu_m: Point
    bends_left: int
    told: Waypoint


def _foretell(here_enu_m: Point, ends_enu_m: list[Point], lanes: TeamLanes, arrived_m: float) -> list[_Step]:
    """What will be told at each step, so that nothing but the step is left to decide then."""
    own, begin, told = lanes.own, here_enu_m, _told(here_enu_m, ends_enu_m[0], lanes, lanes.own)
    steps: list[_Step] = []
    for end in ends_enu_m:
        passed = own.passing(begin, arrived_m)
        if passed is not own and passed.left:
            told = _told(begin, end, lanes, passed)
        own = passed
        steps.append(_Step(end, own.bends_left, told))
        begin = end
    return steps


def _told(here_enu_m: Point, step_enu_m: Point, lanes: TeamLanes, own: OwnWay) -> Waypoint:
    """A step as it is told where so much is left of the own way."""
    bends = own.bends_en_m(MOST_TOLD)
    away_m = math.dist(bends[0], here_enu_m[:2])
    route = tuple((east_m, north_m, step_enu_m[2]) for east_m, north_m in bends)
    why = f"lane {away_m:.0f} m {bearing_word(here_enu_m[:2], bends[0])}, first of {own.bends_left} in its way"
    return Waypoint(step_enu_m, why, route[0], away_m, route, None, lanes.plan_with(own))


def _steps_along(start_enu_m: Point, bends_en_m: list[EastNorth], steps: int, constraints: Constraints) -> list[Point]:
    """The ends of so many steps along a way; fewer where it ends or is barred."""
    reach_m, place, bends = constraints.reach_m, start_enu_m, list(bends_en_m)
    ends: list[Point] = []
    while bends and len(ends) < steps:
        away_m = math.dist(bends[0], place[:2])
        if away_m < ARRIVED * reach_m:
            del bends[0]
            continue
        round_bend = away_m < reach_m and len(bends) > 1
        target = beyond(bends[0], bends[1], reach_m - away_m) if round_bend else bends[0]
        end = next_leg(place, target, constraints)
        if end is None:
            break
        ends.append(end)
        place = end
    return ends
