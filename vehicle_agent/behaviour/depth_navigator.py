"""From decisions to legs under water: keeps one depth, comes up for a position fix when that pays, leads home again.

Vehicles of a team keep depths of their own, so that their ways cross without meeting.
"""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.behaviour.drift import Drift
from vehicle_agent.behaviour.guide import Arrived, Surroundings
from vehicle_agent.behaviour.intent import Intent
from vehicle_agent.behaviour.landmark_share import LandmarkShare
from vehicle_agent.behaviour.landmark_talk import LandmarkTalk
from vehicle_agent.behaviour.leg import Leg, stopping_point
from vehicle_agent.behaviour.navigator import allowed_cells
from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.mission.sounding import beam_of
from vehicle_agent.mission.tasks import MapTask
from vehicle_agent.planning.constraints import Traffic
from vehicle_agent.planning.interface import Finished, Wait, Waypoint
from vehicle_agent.planning.mapping.interface import HeightBand, MappingPlanner, MappingSituation
from vehicle_agent.planning.travel import way_length_m
from vehicle_agent.ports import VehicleState

ARRIVED_M = 1.5
OVER_HOME_M = 2.0
WAIT_S = 2.0
SURFACED_M = 0.1
"""Depth that is asked for when it comes up."""
LEAST_DEPTH_M = 0.6
RISE_M = 1.0
NEAR_DEPTH_M = 0.4
"""So near to its working depth a vehicle counts as at it."""
MENDED_M = 0.5
"""A target is sent again once the position is mended by more than this."""
LONGEST_FIX_S = 60.0
"""Longer at the surface without a fix, and it goes on without."""


class DepthNavigator:
    """A `Guide` under water."""

    has_sector = False
    intent: Intent | None = None
    is_idle = False

    def __init__(
        self,
        plan: MissionPlan,
        index: int,
        planner: MappingPlanner,
        share: LandmarkShare,
        talk: LandmarkTalk,
        drift: Drift,
    ) -> None:
        task, vehicle = plan.mission.task, plan.mission.vehicles[index]
        assert isinstance(task, MapTask)
        self._plan, self._index, self._planner = plan, index, planner
        self._share, self._talk, self._drift = share, talk, drift
        self._sensor = beam_of(plan, index)
        self._surfaces = task.surfacing and vehicle.name not in task.stays_down
        self._surface_up_m = plan.mission.simulation.water_level_m
        self._up_m = self._surface_up_m - (vehicle.depth_m or 0.0)
        self._band = HeightBand(vehicle.min_above_terrain_m, self._up_m, self._up_m)
        self._allowed = allowed_cells(plan)
        self._not_before_s = -math.inf
        self._rising_since_s: float | None = None
        self._sent_under_m = (0.0, 0.0)
        self.leg: Leg | None = None
        self.waypoint: Waypoint | None = None
        self.why = ""

    def work(self, around: Surroundings) -> Point | Finished | None:
        """Next target to sail to, Finished when the planner has nothing left, or None to carry on."""
        if self._rising_since_s is not None:
            return self._rise_on(around)
        if self._surfaces and self._drift.is_worth_a_fix() and self._is_free(around, self._surface_up_m):
            self._rising_since_s = around.now_s
            east, north, _ = around.state.position_enu_m
            text = f"up for a fix, position good to {self._drift.position_sd_m:.0f} m"
            return self._commit((east, north, self._surface_up_m - SURFACED_M), text, None)
        if self._is_too_low(around.state):
            return self._rise_from_ground(around.state)
        if self.leg is not None and not self._is_flown(around.state) and self._is_mended():
            return self._send(self.leg.end_enu_m)
        if around.now_s < self._not_before_s or not self._is_flown(around.state):
            return None
        decision = self._planner.ask(self._situation(around))
        if isinstance(decision, Finished):
            return decision
        if isinstance(decision, Wait):
            self._not_before_s, self.why = around.now_s + WAIT_S, decision.why
            return self.stay(around, decision.why) if self.leg is None else None
        return self._commit(decision.position_enu_m, decision.why, decision)

    def go_to(self, around: Surroundings, place_en_m: tuple[float, float]) -> Point | Arrived | None:
        """Next target on the way to a place, None to carry on, or Arrived."""
        return self._travel(around, place_en_m, "place, ordered by the operator")

    def go_home(self, around: Surroundings, home_enu_m: Point) -> Point | None:
        """Next target on the way home, or None to carry on."""
        target = self._travel(around, (home_enu_m[0], home_enu_m[1]), "home")
        return None if isinstance(target, Arrived) else target

    def is_over_home(self, state: VehicleState, home_enu_m: Point) -> bool:
        """Below home, in truth: near enough to come up."""
        return way_length_m(state.position_enu_m, home_enu_m[:2]) <= OVER_HOME_M

    def make_way(self, around: Surroundings) -> Point | None:
        """Nothing: teammates pass at depths of their own, and whoever comes up waits until nobody is above."""
        return None

    def stay(self, around: Surroundings, why: str) -> Point:
        """Give up the present leg and come to rest at the working depth."""
        east, north, _ = stopping_point(around.state)
        rest = (east, north, self._up_m)
        self._rising_since_s = None
        self.leg, self.waypoint, self.why = Leg(rest, why), None, why
        return self._send(rest)

    def forget(self, why: str) -> None:
        """Nothing is sailed any more: somebody else steers, or the vehicle is up."""
        self.leg = self.waypoint = self._rising_since_s = None
        self.why = why

    def limit(self, allowed: BoolArray, area_cells: BoolArray, sector_cells: BoolArray | None) -> None:
        """Sail only below `allowed` cells: (columns, rows) bool; the whole area is mapped whatever is asked first."""
        self._allowed = allowed

    def _rise_on(self, around: Surroundings) -> Point | None:
        """Wait for the fix, then go on; the next decision leads down again."""
        assert self._rising_since_s is not None
        if self._drift.has_fix or around.now_s - self._rising_since_s > LONGEST_FIX_S:
            if not self._is_free(around, self._up_m):
                return None
            self._rising_since_s = None
            east, north, _ = around.state.position_enu_m
            self.leg = None
            return self._commit((east, north, self._up_m), "down again to its depth", None)
        return None

    def _is_free(self, around: Surroundings, up_m: float) -> bool:
        """Whether no teammate is on the way straight up or down to a height."""
        east_m, north_m, _ = around.state.position_enu_m
        traffic = Traffic(around.reservations, self._plan.mission.safety.separation_m)
        return traffic.conflict(around.state.position_enu_m, (east_m, north_m, up_m)) is None

    def _is_too_low(self, state: VehicleState) -> bool:
        """Whether its own beam finds the ground nearer than it may be, and there is water above to rise into."""
        below_m = state.sounding.range_m if state.sounding is not None else None
        higher = self._up_m < self._surface_up_m - LEAST_DEPTH_M
        near_its_depth = abs(state.position_enu_m[2] - self._up_m) < NEAR_DEPTH_M
        return below_m is not None and below_m < self._band.clearance_m and higher and near_its_depth

    def _rise_from_ground(self, state: VehicleState) -> Point | None:
        """Keep a lesser depth from here on: ground that rises once may rise again."""
        self._up_m = min(self._up_m + RISE_M, self._surface_up_m - LEAST_DEPTH_M)
        self._band = HeightBand(self._band.clearance_m, self._up_m, self._up_m)
        east, north, _ = state.position_enu_m
        return self._commit((east, north, self._up_m), "rising ground: keeps a lesser depth", None)

    def _travel(self, around: Surroundings, place_en_m: tuple[float, float], why: str) -> Point | Arrived | None:
        away_m = way_length_m(around.state.position_enu_m, place_en_m)
        if away_m <= OVER_HOME_M:
            return Arrived()
        self._rising_since_s = None
        return self._commit((place_en_m[0], place_en_m[1], self._up_m), f"{why} {away_m:.0f} m", None)

    def _commit(self, end: Point, why: str, waypoint: Waypoint | None) -> Point | None:
        there_already = self.leg is not None and math.dist(self.leg.end_enu_m, end) < 0.2
        self.leg, self.waypoint, self.why = Leg(end, why), waypoint, why
        return None if there_already and not self._is_mended() else self._send(end)

    def _send(self, target: Point) -> Point:
        self._sent_under_m = self._drift.correction_m
        return target

    def _is_mended(self) -> bool:
        """Whether more is known of its position than when it was sent off, so that the target lies elsewhere for it."""
        return math.dist(self._sent_under_m, self._drift.correction_m) > MENDED_M

    def _is_flown(self, state: VehicleState) -> bool:
        return self.leg is None or math.dist(self.leg.end_enu_m, state.position_enu_m) <= ARRIVED_M

    def _situation(self, around: Surroundings) -> MappingSituation:
        mission = self._plan.mission
        return MappingSituation(
            self._index,
            around.state.position_enu_m,
            self._share.team_map.landmarks,
            self._sensor,
            self._band,
            mission.task.step_m,
            self._admissible,
            self._talk.teammates(around.now_s, mission.safety.teammate_silence_s),
            mission.radio.range_m or math.inf,
            self._drift.unfixed_s,
            around.now_s,
            self._talk.said_done,
        )

    def _admissible(self, ends_enu_m: FloatArray) -> BoolArray:
        """Ends of legs below allowed cells: (M, 3) float64 -> (M,) bool."""
        grid = self._plan.grid
        columns = np.floor((ends_enu_m[:, 0] - grid.west_m) / grid.cell_m).astype(np.int64)
        rows = np.floor((ends_enu_m[:, 1] - grid.south_m) / grid.cell_m).astype(np.int64)
        inside: BoolArray = (columns >= 0) & (columns < grid.columns) & (rows >= 0) & (rows < grid.rows)
        inside[inside] &= self._allowed[columns[inside], rows[inside]]
        return inside
