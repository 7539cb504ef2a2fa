"""From decisions to legs: builds the constraints, asks the planner, flies leg after leg and leads the vehicle home."""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.behaviour.guide import Arrived, Surroundings
from vehicle_agent.behaviour.intent import Intent, Line, awaited, may_cross, within_reach_m
from vehicle_agent.behaviour.leg import (
    Leg,
    braking_distance_m,
    is_ending,
    is_flown,
    stopping_point,
    swing,
    turns_sharply,
    will_end_soon,
)
from vehicle_agent.domain.elevation import ElevationMap
from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.paths import assumed_surface
from vehicle_agent.domain.polygon import BoolArray, distance_to_border_m
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.mission.tasks import CoverTask
from vehicle_agent.planning.constraints import Constraints
from vehicle_agent.planning.interface import (
    Decision,
    Finished,
    Observation,
    Planner,
    Situation,
    Wait,
    Waypoint,
    has_thought,
)
from vehicle_agent.planning.travel import next_leg, way_length_m
from vehicle_agent.planning.way_aside import way_aside
from vehicle_agent.ports import VehicleState

SHADOW_RINGS = 2
STEEPEST_SLOPE = 1.5
"""Unknown cells beside known ground are taken to rise at most so."""
CHECK_PERIOD_S = 1.0
WAIT_S = 1.0
OVER_HOME_M = 3.0
LAST_CELLS = 3.0
"""So near to home, in cells, a vehicle may leave the ground where it may fly by map."""
SAME_PLACE_M = 0.5
"""A leg that ends so near to the last one needs no new order."""
TOO_LOW = 0.6
"""Share of the least height above ground below which a leg is broken off."""


class Navigator:
    """A `Guide` over an elevation map."""

    is_idle = False

    def __init__(self, plan: MissionPlan, index: int, planner: Planner, team_map: ElevationMap) -> None:
        vehicle = plan.mission.vehicles[index]
        self._plan, self._index, self._planner, self._map = plan, index, planner, team_map
        self._min_above_m, self._max_above_m = vehicle.min_above_terrain_m, vehicle.max_above_terrain_m
        self._range_m = vehicle.sensor.range_m
        self._allowed = allowed_cells(plan)
        self._area: BoolArray = plan.area_cells
        self._sector: BoolArray | None = None
        self._covers = isinstance(plan.mission.task, CoverTask)
        self._has_asked = False
        self._surface: FloatArray = np.full(plan.grid.shape, np.nan)
        self._surface_version = -1
        self._next_check_s = -math.inf
        self._not_before_s = -math.inf
        self._braking = False
        self._within_m, self._patience_s = within_reach_m(plan), plan.mission.safety.teammate_silence_s
        self.leg: Leg | None = None
        self.intent: Intent | None = None
        self.waypoint: Waypoint | None = None
        self.why = ""

    def work(self, around: Surroundings) -> Point | Finished | None:
        """Next target to fly to, Finished when the planner has nothing left, or None to carry on."""
        if not self._may_decide(around):
            if self.leg is not None and self.intent is None and will_end_soon(self.leg, around.state):
                self._has_thought(around, self.leg.end_enu_m)
            return self._carry_on(around)
        if (aside := self.make_way(around)) is not None:
            return aside
        state = around.state
        if not self._has_thought(around, state.position_enu_m):
            return self._carry_on(around)
        self._planner.tell(Observation(state.position_enu_m, around.objective))
        decision = self._decide(around)
        if isinstance(decision, Finished):
            why = decision.why if self._covers else "everything observable is observed"
            return Finished(f"{why}{self._left_unseen()}")
        if isinstance(decision, Wait):
            return self._wait(around, decision.why)
        return self._commit(around, decision.position_enu_m, decision.why, decision)

    def _left_unseen(self) -> str:
        """What the vehicle leaves without having seen it, in words."""
        unseen = np.argwhere(self._area & ~self._map.observed)
        if len(unseen) == 0:
            return ""
        column, row = np.median(unseen, axis=0).astype(int).tolist()
        east_m, north_m = self._plan.grid.centre_of(column, row)
        return f"; {len(unseen)} cells stay unseen, most around E {east_m:.0f} N {north_m:.0f} m"

    def limit(self, allowed: BoolArray, area_cells: BoolArray, sector_cells: BoolArray | None) -> None:
        """Fly only over `allowed` cells, see only `area_cells`, and `sector_cells` first: (columns, rows) bool."""
        self._allowed, self._area, self._sector = allowed, area_cells, sector_cells
        self._surface_version = -1

    @property
    def has_sector(self) -> bool:
        return self._sector is not None

    def _decide(self, around: Surroundings) -> Decision:
        """Ask the planner for the sector first, then for the whole area."""
        # Planners size their work by the area of their first question: it is always the mission's whole one.
        areas = [self._first_area]
        if self._has_asked and self._sector is not None:
            areas.insert(0, self._area & self._sector)
        self._has_asked = True
        decision: Decision = Finished("nothing is to be seen")
        for area_cells in areas:
            if self._covers or (area_cells & ~self._map.observed).any():
                decision = self._planner.ask(self._situation(around, area_cells))
            if not isinstance(decision, Finished):
                break
            self._sector = None
        return decision

    @property
    def _first_area(self) -> BoolArray:
        return self._area if self._has_asked else self._plan.area_cells

    def _has_thought(self, around: Surroundings, place_enu_m: Point) -> bool:
        """Think a little of what to decide at a place; True when that can be decided at once. A sector is soon done."""
        if self._sector is not None:
            return True
        return has_thought(self._planner, self._situation(around, self._first_area), place_enu_m)

    def _situation(self, around: Surroundings, area_cells: BoolArray) -> Situation:
        return Situation(
            self._index,
            around.state.position_enu_m,
            self._map,
            area_cells,
            self._range_m,
            self._constraints(around),
            around.teammates,
        )

    def go_to(self, around: Surroundings, place_en_m: tuple[float, float]) -> Point | Arrived | None:
        """Next target on the way to a place, None to carry on, or Arrived as near to it as known ground lets."""
        if not self._may_decide(around):
            return self._carry_on(around)
        here, constraints = around.state.position_enu_m, self._constraints(around)
        away_m = way_length_m(here, place_en_m)
        if away_m <= max(OVER_HOME_M, self._plan.grid.cell_m):
            return Arrived()
        end = next_leg(here, place_en_m, constraints)
        if end is None:
            return self.make_way(around) or self._wait(around, f"place {away_m:.0f} m: the way is taken")
        no_nearer = way_length_m(end, place_en_m) > away_m - 0.1 * self._plan.grid.cell_m
        if no_nearer and math.dist(end[:2], here[:2]) < self._plan.grid.cell_m and end[2] <= here[2] + OVER_HOME_M:
            return Arrived()
        return self._commit(around, end, f"place {away_m:.0f} m, ordered by the operator", None)

    def go_home(self, around: Surroundings, home_enu_m: Point) -> Point | None:
        """Next target on the way home, or None to carry on."""
        if not self._may_decide(around):
            return self._carry_on(around)
        here, constraints = around.state.position_enu_m, self._constraints(around)
        away_m = way_length_m(here, home_enu_m[:2])
        end = self._last_leg(here, home_enu_m, constraints) or next_leg(here, home_enu_m[:2], constraints)
        if end is None:
            return self.make_way(around) or self._wait(around, f"home {away_m:.0f} m: the way is taken")
        return self._commit(around, end, f"home {away_m:.0f} m", None)

    def _last_leg(self, here: Point, home_enu_m: Point, constraints: Constraints) -> Point | None:
        """Level to a nearby home on ground where the map lets nobody fly: it came up there, so it may go back."""
        near = way_length_m(here, home_enu_m[:2]) <= LAST_CELLS * self._plan.grid.cell_m
        if not (near and math.isnan(constraints.ground_m(*home_enu_m[:2]))):
            return None
        over_home = (home_enu_m[0], home_enu_m[1], here[2])
        too_low = constraints.clearance_m(over_home, here) < TOO_LOW * self._min_above_m
        return None if too_low or constraints.conflict(here, over_home) else over_home

    def is_over_home(self, state: VehicleState, home_enu_m: Point) -> bool:
        return way_length_m(state.position_enu_m, home_enu_m[:2]) <= OVER_HOME_M and braking_distance_m(state) < 1.0

    def make_way(self, around: Surroundings) -> Point | None:
        """Leave a place where a teammate must pass; None where nobody must, or there is no way out now."""
        if not self._may_decide(around):
            return self._carry_on(around)
        here, constraints = around.state.position_enu_m, self._constraints(around)
        passages = [p for p in around.passages if constraints.blocks(p.start_enu_m, p.end_enu_m, here)]
        end = way_aside(here, passages, constraints) if passages else None
        if end is None:
            return None
        return self._commit(around, end, f"makes way for {self._plan.vehicle_names[passages[0].owner_index]}", None)

    def stay(self, around: Surroundings, why: str) -> Point:
        """Give up the present leg and come to rest, no further than where it ends."""
        rest = stopping_point(around.state)
        self.intent = None
        if self.leg is not None and is_ending(self.leg, around.state):
            rest = self.leg.end_enu_m
        self._braking = True
        self.waypoint = None
        self.why = why
        self.leg = Leg(rest, why)
        return rest

    def forget(self, why: str) -> None:
        """Nothing is flown any more: somebody else steers, or the vehicle is down."""
        self.leg = self.intent = self.waypoint = None
        self.why = why

    def _may_decide(self, around: Surroundings) -> bool:
        if self.intent is not None or around.now_s < self._not_before_s:
            return False
        if self.leg is None or is_flown(self.leg, around.state):
            return True
        return not self._braking and is_ending(self.leg, around.state)

    def _commit(self, around: Surroundings, end: Point, why: str, waypoint: Waypoint | None) -> Point | None:
        if self.leg is None and turns_sharply(around.state, end):
            return self.stay(around, why)
        ending = self.leg is not None and not is_flown(self.leg, around.state)
        if ending and (turns_sharply(around.state, end) or self._swings_near(around, end)):
            self._braking = True
            return None
        intent = Intent(Leg(end, why), waypoint, around.state.stamp_ms, around.now_s)
        if not self._ends_at(end) and (mates := self._awaited(around, intent)):
            self.intent, self.why = intent, f"waits to hear {self._plan.vehicle_names[mates[0]]}: {why}"
            return None
        return self._set_off(intent)

    def _ends_at(self, place: Point) -> bool:
        """Whether the present leg leads there already."""
        return self.leg is not None and math.dist(self.leg.end_enu_m, place) < SAME_PLACE_M

    def _set_off(self, intent: Intent) -> Point | None:
        end, there_already = intent.leg.end_enu_m, self._ends_at(intent.leg.end_enu_m)
        self._braking, self.intent = False, None
        self.leg, self.waypoint, self.why = intent.leg, intent.waypoint, intent.leg.why
        return None if there_already else end

    def _awaited(self, around: Surroundings, intent: Intent) -> list[int]:
        """Teammates who might have reserved a leg across an intended one, wherever on the present leg it begins."""
        here, end = around.state.position_enu_m, intent.leg.end_enu_m
        lines: tuple[Line, ...] = ((here, end), (here if self.leg is None else self.leg.end_enu_m, end))
        mates = around.whereabouts
        return awaited(lines, intent.since_ms, intent.since_s, mates, self._within_m, self._patience_s)

    def _carry_on(self, around: Surroundings) -> Point | None:
        """Make room on the present leg, or set off on the intended one once teammates have been heard."""
        rest = self._make_room(around)
        intent = self.intent
        if rest is not None or intent is None or self._awaited(around, intent):
            return rest
        end = intent.leg.end_enu_m
        if turns_sharply(around.state, end) or self._swings_near(around, end):
            return None  # it slows down towards the end of its present leg
        if not self._is_still_clear(around, intent):
            self.intent = None
            return None
        return self._set_off(intent)

    def _swings_near(self, around: Surroundings, end: Point) -> bool:
        """Whether turning into a leg in flight would carry the vehicle too near to what a teammate has reserved."""
        lines = swing(around.state.position_enu_m, stopping_point(around.state), end)
        theirs = [(rival.start_enu_m, rival.end_enu_m) for rival in around.reservations]
        return may_cross(lines, theirs, self._plan.mission.safety.separation_m)

    def _is_still_clear(self, around: Surroundings, intent: Intent) -> bool:
        """Whether an intended leg may be flown from here by what was heard and seen since it was chosen."""
        here, end, constraints = around.state.position_enu_m, intent.leg.end_enu_m, self._constraints(around)
        if any(rival.precedes_intent(intent.since_ms, self._index) for rival in constraints.conflicts(here, end)):
            return False
        least_m = min(self._min_above_m, constraints.clearance_m(here, here) - SAME_PLACE_M)
        return constraints.clearance_m(here, end) >= TOO_LOW * least_m

    def _wait(self, around: Surroundings, why: str) -> Point | None:
        self._not_before_s = around.now_s + WAIT_S
        self.why, self.waypoint = why, None
        if self.leg is None:
            return self.stay(around, why)
        return None

    def _make_room(self, around: Surroundings) -> Point | None:
        """Stop on a leg that has become unsafe: new ground in it, a teammate with the older right, or one who rests."""
        if self.leg is None or self._braking or around.now_s < self._next_check_s:
            return None
        self._next_check_s = around.now_s + CHECK_PERIOD_S
        constraints = self._constraints(around)
        here, end = around.state.position_enu_m, self.leg.end_enu_m
        for rival in constraints.conflicts(here, end):
            if rival.since_ms:
                continue  # who only means to fly makes room
            if rival.precedes(self._index) or constraints.blocks(here, end, rival.end_enu_m):
                return self.stay(around, "making room for a teammate")
        if not constraints.clearance_m(here, end) >= TOO_LOW * self._min_above_m:
            return self.stay(around, "rising ground ahead")
        return None

    def _constraints(self, around: Surroundings) -> Constraints:
        if around.map_version != self._surface_version:
            self._surface = assumed_surface(
                self._map.elevation_m, self._allowed, self._plan.grid.cell_m, SHADOW_RINGS, STEEPEST_SLOPE
            )
            self._surface_version = around.map_version
        return Constraints(
            self._plan.grid,
            self._surface,
            self._min_above_m,
            self._max_above_m,
            self._plan.mission.task.step_m,
            self._plan.mission.safety.separation_m,
            around.reservations,
        )


def allowed_cells(plan: MissionPlan) -> BoolArray:
    """Cells whose centre keeps the margin from the fence: (columns, rows) bool."""
    east, north = np.meshgrid(plan.grid.centres_east_m(), plan.grid.centres_north_m(), indexing="ij")
    points = np.column_stack((east.ravel(), north.ravel()))
    margin_m = plan.mission.area.fence_margin_m
    far_enough = distance_to_border_m(points, plan.fence_en_m).reshape(plan.grid.shape) >= margin_m - 1e-6
    allowed: BoolArray = plan.area_cells & far_enough
    return allowed
