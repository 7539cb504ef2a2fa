"""From stations to legs: leads a vehicle to where it sees most of a town that no teammate sees, and keeps it there.

Ways, legs and traffic are those of the vehicle that explores; only what it goes for differs.
"""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.behaviour.guide import Surroundings
from vehicle_agent.behaviour.town_navigator import ROOM_M, WAIT_S, TownNavigator
from vehicle_agent.behaviour.voxel_share import VoxelShare
from vehicle_agent.domain.frames import Point
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.mission.tasks import CoverTask
from vehicle_agent.planning.interface import Finished, Wait, Waypoint
from vehicle_agent.planning.voxel_cao import VoxelCao
from vehicle_agent.planning.voxel_picture import VoxelPicture
from vehicle_agent.planning.voxel_situation import VoxelSituation
from vehicle_agent.planning.voxel_stations import VoxelStations, VoxelStationsParams

DECIDE_PERIOD_S = 1.0


class TownWatch(TownNavigator):
    """One vehicle's way to its station; where the mission says so, it explores the town before."""

    def __init__(
        self, plan: MissionPlan, index: int, shared: VoxelShare, task: CoverTask, rng: np.random.Generator
    ) -> None:
        super().__init__(plan, index, shared)
        grid, fan = shared.team_map.grid, shared.fan
        self._planner: VoxelStations | VoxelCao
        match task.planner:
            case "stations":
                apart_m = plan.mission.safety.separation_m + ROOM_M
                params = VoxelStationsParams(hold=max(1, round(task.hold_s / DECIDE_PERIOD_S)), apart_m=apart_m)
                self._planner = VoxelStations(index, grid, fan, rng, params)
            case "cao":
                self._planner = VoxelCao(grid, fan, task.step_m, rng)
        self._explores, self._has_explored = task.explore_first, False
        self._decide_at_s = -math.inf
        self._is_due = True

    def work(self, around: Surroundings) -> Point | Finished | None:
        """Next target to fly to, Finished when the team has stayed long enough, or None to carry on."""
        self._is_due = around.now_s >= self._decide_at_s
        return super().work(around)

    @property
    def _expects_any(self) -> bool:
        return self._explores and super()._expects_any

    def _goes_on(self, around: Surroundings, picture: VoxelPicture) -> bool:
        """The present way is flown until the next decision."""
        if self._explores:
            return super()._goes_on(around, picture)
        return self._makes_way or not self._is_due or not self._planner.revises_under_way

    def _is_still_wanted(self, around: Surroundings) -> bool:
        """A leg towards a station is flown though the planner may know a better one by then."""
        return not self._explores or super()._is_still_wanted(around)

    def _choose(self, around: Surroundings, picture: VoxelPicture) -> Point | Finished | None:
        if self._explores:
            enough = self._shared.known_fraction(self._area) >= self._plan.mission.stop.observed_fraction
            target = Finished("enough is known") if enough else super()._choose(around, picture)
            self._has_explored = self._has_explored or not self.is_idle
            if not (isinstance(target, Finished) or (self._has_explored and self.is_idle)):
                return target
            self._explores = False  # what teammates still find is heard of from its station, too
        late_s = max(0.0, around.now_s - self._decide_at_s) if math.isfinite(self._decide_at_s) else 0.0
        self._decide_at_s = around.now_s + DECIDE_PERIOD_S
        self._arrived, self._makes_way, self.is_idle = None, False, False
        here_enu_m = around.state.position_enu_m
        periods = 1 + int(late_s / DECIDE_PERIOD_S)
        decision = self._planner.ask(
            VoxelSituation(picture, self._allowed, self._area, here_enu_m, around.teammates, periods)
        )
        if isinstance(decision, Finished):
            return decision
        self._goal = self._planner.station_enu_m
        if isinstance(decision, Wait):
            self._way = self._way[:0]
            return self._wait(around, decision.why, WAIT_S)
        self._way, self.why = decision.voxels[1:], decision.why
        target = self._fly_on(around, picture)
        if target is None and self.leg is not None and self.waypoint is not None:  # it turns at the end of its leg
            self.waypoint = Waypoint(self.leg.end_enu_m, self.why, self._goal)
        return target
