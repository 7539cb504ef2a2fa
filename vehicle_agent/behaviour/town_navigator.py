"""From voxel routes to legs: leads a vehicle between buildings, through known air only, and home again.

A route is flown in straight legs, each as far as the straight line stays in air that is known to be clear with room
around it, and kept clear of teammates and of the legs that they have reserved. A leg that a teammate might cross is
told first and flown once that teammate was heard after it; where a way turns, the leg after the turn is told while the
one before it is flown. Where a way ends, the vehicle looks around; what it went for and still does not see stays out of
sight from there and is left alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vehicle_agent.behaviour.goal_lease import GoalLeases
from vehicle_agent.behaviour.guide import Arrived, Surroundings
from vehicle_agent.behaviour.intent import Intent, Line, awaited, within_reach_m
from vehicle_agent.behaviour.leg import Leg, speed_m_s, stopping_point
from vehicle_agent.behaviour.navigator import allowed_cells
from vehicle_agent.behaviour.town_legs import ARRIVED_M, SLOW_M_S, is_clear, is_flown, leads_to, turns
from vehicle_agent.behaviour.town_ways import way_aside, way_to
from vehicle_agent.behaviour.vain_looks import VainLooks
from vehicle_agent.behaviour.voxel_share import VoxelShare
from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.planning.constraints import Reservation, Traffic
from vehicle_agent.planning.interface import Finished, Waypoint
from vehicle_agent.planning.voxel_explorer import Voxel, VoxelExplorer, VoxelTeammate
from vehicle_agent.planning.voxel_picture import VoxelPicture, without_traffic
from vehicle_agent.ports import VehicleState

ROOM_M = 0.5
"""Beyond the separation that routes keep from teammates."""
CHECK_PERIOD_S = 0.5
WAIT_S = 1.0
PATIENCE = 3
"""Waits for a way to become clear before another is sought."""
WORTH_STOPPING_M = 2.0
"""A leg that goes on for so much beyond the braking distance, to what need not be looked at any more, is broken off."""
SCAN_WITHIN_S = 5.0


class TownNavigator:
    """A `Guide` through a town; what the end of a leg is flown for is told only when teammates should leave it."""

    has_sector = False

    def __init__(self, plan: MissionPlan, index: int, shared: VoxelShare) -> None:
        self._plan, self._index, self._shared = plan, index, shared
        self._grid = shared.team_map.grid
        self._explorer = VoxelExplorer(index, shared.fan)
        self._allowed, self._area = allowed_cells(plan), plan.area_cells
        self._vain_looks = VainLooks(self._grid.shape)
        self._within_m = plan.mission.safety.separation_m + plan.mission.task.step_m
        self._within_of_setting_out_m = within_reach_m(plan)
        self._way: IndexArray = np.empty(0, dtype=np.int64)
        self._way_after_intent: IndexArray = self._way
        self._goal: Point | None = None
        self._arrived: tuple[int, float] | None = None
        self._blocked = 0
        self._leases = GoalLeases()
        self._reconsidered_at = -1
        self._next_check_s = -math.inf
        self._not_before_s = -math.inf
        self._braking = self._makes_way = self._leg_is_stale = False
        self.leg: Leg | None = None
        self.intent: Intent | None = None
        self.waypoint: Waypoint | None = None
        self.why = ""
        self.is_idle = False

    def work(self, around: Surroundings) -> Point | Finished | None:
        """Next target to fly to, Finished when nothing more can be seen, or None to carry on."""
        if around.now_s < self._not_before_s or not self._is_time(around):
            return None
        if self.intent is not None:
            return self._carry_on(around, self.intent)
        picture = self._picture(around)
        if self._is_under_way(around.state):
            if (rest := self._make_room(around)) is not None:
                return rest
            if self._braking:
                return None
            if self._goes_on(around, picture):
                return self._fly_on(around, picture)
        elif (aside := self.make_way(around)) is not None:
            return aside
        elif len(self._way) == 0 and self._expects_any and not self._has_looked(around):
            return None
        elif len(self._way) and self._goes_on(around, picture) and self._is_passable(picture):
            return self._fly_on(around, picture)
        return self._choose(around, picture)

    def go_to(self, around: Surroundings, place_en_m: tuple[float, float]) -> Point | Arrived | None:
        """Next target on the way to a place, None to carry on, or Arrived as near to it as known air lets."""
        return self._travel(around, place_en_m, "place, ordered by the operator")

    def go_home(self, around: Surroundings, home_enu_m: Point) -> Point | None:
        """Next target on the way home, or None to carry on."""
        target = self._travel(around, (home_enu_m[0], home_enu_m[1]), "home")
        return None if isinstance(target, Arrived) else target

    def is_over_home(self, state: VehicleState, home_enu_m: Point) -> bool:
        near = math.dist(state.position_enu_m[:2], home_enu_m[:2]) <= 2.0 * ARRIVED_M
        return near and speed_m_s(state) <= SLOW_M_S

    def limit(self, allowed: BoolArray, area_cells: BoolArray, sector_cells: BoolArray | None) -> None:
        """Fly only over `allowed` cells, see only over `area_cells`: (columns, rows) bool. No sector goes first."""
        self._allowed, self._area = allowed, area_cells

    def make_way(self, around: Surroundings) -> Point | None:
        """Leave a place where a teammate must pass; None where nobody must, or there is no way out now."""
        here = around.state.position_enu_m
        if self.intent is not None:
            return self._carry_on(around, self.intent) if self._is_time(around) else None
        if self._is_under_way(around.state):
            return self._make_room(around) if self._is_time(around) else None
        traffic = Traffic(around.reservations, self._plan.mission.safety.separation_m)
        passages = [p for p in around.passages if traffic.blocks(p.start_enu_m, p.end_enu_m, here)]
        if not passages or around.now_s < self._not_before_s:
            return None
        picture = self._picture(around)
        legs = [(passage.start_enu_m, passage.end_enu_m) for passage in passages]
        keep_m = self._plan.mission.safety.separation_m + ROOM_M
        way = way_aside(picture.passable, self._grid, self._start(around.state), legs, keep_m)
        if len(way) == 0:
            self._not_before_s = around.now_s + WAIT_S
            return None
        self._way, self._goal, self._makes_way = way, None, True
        self.why = f"makes way for {self._plan.vehicle_names[passages[0].owner_index]}"
        return self._fly_on(around, picture)

    def stay(self, around: Surroundings, why: str) -> Point:
        """Give up the present way and come to rest."""
        self._way = self._way[:0]
        self._arrived = None
        return self._brake(around, why)

    def forget(self, why: str) -> None:
        """Nothing is flown any more: somebody else steers, or the vehicle is down."""
        self.leg = self.intent = self.waypoint = self._arrived = None
        self._way = self._way[:0]
        self.why = why

    # Deciding

    @property
    def _expects_any(self) -> bool:
        """Whether something is to be looked at from the end of the present way."""
        return self._explorer.expects_any and not self._makes_way

    def _goes_on(self, around: Surroundings, picture: VoxelPicture) -> bool:
        """Whether the present way is still worth flying, and this vehicle's to fly."""
        if self._makes_way:
            return True
        if self._explorer.is_taken(self._voxel_here(around.state), self._mates(around)):
            self._explorer.let_go()
            return False
        return self._explorer.still_worth(picture)

    def _mates(self, around: Surroundings) -> list[VoxelTeammate]:
        return [
            VoxelTeammate(
                mate.index,
                self._voxel_at(mate.position_enu_m),
                None if mate.goal_enu_m is None else self._voxel_at(mate.goal_enu_m),
            )
            for mate in around.teammates
        ]

    def _choose(self, around: Surroundings, picture: VoxelPicture) -> Point | Finished | None:
        """Ask for a new route; without one wait for teammates that still work, then try all again, then be done."""
        here = self._voxel_here(around.state)
        self._arrived, self._makes_way = None, False
        route = self._explorer.ask(picture, here, self._mates(around))
        self.is_idle = route is None
        if route is not None:
            self._way, self.why = route.voxels[1:], route.why
            self._goal = None if self._explorer.goal is None else self._grid.centre_of(self._explorer.goal)
            self._blocked = 0
            self._leg_is_stale = True
            return self._fly_on(around, picture) if len(self._way) else None
        self._way, self._goal = self._way[:0], None
        if self._leases.any_holds(around.teammates, around.now_s):
            return self._wait(around, "nothing to be seen from here while teammates look", 2.0 * WAIT_S)
        known = int(np.count_nonzero(picture.states))
        if known != self._reconsidered_at:
            self._reconsidered_at = known
            self._vain_looks.try_again()
            self._explorer.reconsider()
            return self._wait(around, "tries again what was out of sight", WAIT_S)
        return Finished(self._farewell())

    def _farewell(self) -> str:
        left = int(np.count_nonzero(self._shared.picture.frontier & self._area[:, :, None]))
        hidden = f"; {left} voxels beside known air stay out of sight" if left else ""
        return f"everything observable is observed{hidden}"

    def _fly_on(self, around: Surroundings, picture: VoxelPicture) -> Point | None:
        """The next leg along the way, as far as can be flown straight; None to carry on with the present one."""
        state, under_way = around.state, self._is_under_way(around.state)
        place = self._furthest(around, picture, state.position_enu_m)
        if self.leg is not None and under_way:
            end = None if place is None else self._centre(int(self._way[place]))
            if end is None or turns(state, end) or leads_to(self.leg, end):
                rest = None
                if self._leg_is_stale and end is not None and not leads_to(self.leg, end):
                    rest = self._stop_short(around)
                self._look_ahead(around, picture, rest or self.leg.end_enu_m)
                return rest
        if place is not None:
            self._blocked = 0
            return self._commit(around, self._centre(int(self._way[place])), self._way[place + 1 :])
        self._blocked += 1
        if self._blocked >= PATIENCE:
            self._way = self._way[:0]
            self._explorer.let_go()
        return self._wait(around, "the way is taken", WAIT_S)

    def _stop_short(self, around: Surroundings) -> Point | None:
        """Brake where the present leg goes on to nothing; None where that would hardly save any way."""
        assert self.leg is not None
        saved_m = math.dist(stopping_point(around.state), self.leg.end_enu_m)
        return self._brake(around, self.why) if saved_m >= WORTH_STOPPING_M else None

    def _look_ahead(self, around: Surroundings, picture: VoxelPicture, turn_enu_m: Point) -> None:
        """Tell the leg from where the present one ends, so that teammates' words come while that is flown."""
        place = self._furthest(around, picture, turn_enu_m)
        if place is not None:
            intent = self._intent_to(around, self._centre(int(self._way[place])), self._way[place + 1 :])
            if math.dist(turn_enu_m, intent.leg.end_enu_m) >= ARRIVED_M and self._awaited(around, intent):
                self.intent, self._way_after_intent = intent, self._way[place + 1 :]

    def _furthest(self, around: Surroundings, picture: VoxelPicture, start_enu_m: Point) -> int | None:
        """Which voxel of the way is the last that a leg from a place may lead to; None when there is none."""
        traffic = Traffic(around.reservations, self._plan.mission.safety.separation_m)
        for place in range(len(self._way) - 1, -1, -1):
            end = self._centre(int(self._way[place]))
            near = math.dist(start_enu_m, end) <= self._plan.mission.task.step_m
            if not near or not is_clear(picture.passable, self._grid, start_enu_m, end):
                continue
            if traffic.conflict(start_enu_m, end) is None:
                return place
        return None

    def _commit(self, around: Surroundings, end: Point, way_after: IndexArray) -> Point | None:
        """Fly to a place, or mean to once teammates have been heard."""
        intent = self._intent_to(around, end, way_after)
        if self._awaited(around, intent):
            self.intent, self._way_after_intent = intent, way_after
            return None
        return self._set_off(intent, way_after)

    def _intent_to(self, around: Surroundings, end: Point, way_after: IndexArray) -> Intent:
        waypoint = None
        if self._goal is not None:
            corners = tuple(self._centre(int(voxel)) for voxel in way_after[:: max(1, len(way_after) // 10)][:11])
            waypoint = Waypoint(end, self.why, self._goal, float(len(way_after)) * self._grid.voxel_m, corners)
        return Intent(Leg(end, self.why), waypoint, around.state.stamp_ms, around.now_s)

    def _set_off(self, intent: Intent, way_after: IndexArray) -> Point:
        self._braking, self._arrived, self.intent = False, None, None
        self._leg_is_stale = False
        self._way = way_after
        self.leg, self.waypoint, self.why = intent.leg, intent.waypoint, intent.leg.why
        return intent.leg.end_enu_m

    def _awaited(self, around: Surroundings, intent: Intent) -> list[int]:
        """Teammates who might have reserved a leg across an intended one, wherever on the present leg it begins."""
        here, end = around.state.position_enu_m, intent.leg.end_enu_m
        lines: tuple[Line, ...] = ((here, end), (here if self.leg is None else self.leg.end_enu_m, end))
        patience_s = self._plan.mission.safety.teammate_silence_s
        return [
            index
            for mate in around.whereabouts
            for index in awaited(
                lines,
                intent.since_ms,
                intent.since_s,
                (mate,),
                self._within_of_setting_out_m if mate.sets_out else self._within_m,
                patience_s,
            )
        ]

    def _carry_on(self, around: Surroundings, intent: Intent) -> Point | None:
        """Make room on the present leg, or set off on the intended one once teammates have been heard."""
        under_way, end = self._is_under_way(around.state), intent.leg.end_enu_m
        if under_way and (rest := self._make_room(around)) is not None:
            return rest
        if not self._is_still_wanted(around):
            self._drop(intent)
        elif mates := self._awaited(around, intent):
            if not under_way:
                self.why = f"waits to hear {self._plan.vehicle_names[mates[0]]}: {intent.leg.why}"
        elif not (under_way and turns(around.state, end)):
            if self._is_still_clear(around, intent):
                return self._set_off(intent, self._way_after_intent)
            self._drop(intent)
        return None

    def _is_still_wanted(self, around: Surroundings) -> bool:
        """Whether what an intended leg is flown for is still worth it; what is flown for no goal always is."""
        return self._goal is None or self._goes_on(around, self._shared.picture)

    def _is_still_clear(self, around: Surroundings, intent: Intent) -> bool:
        """Whether an intended leg may be flown from here by what was heard and seen since it was chosen."""
        here, end = around.state.position_enu_m, intent.leg.end_enu_m
        rivals = tuple(leg for leg in around.reservations if leg.precedes_intent(intent.since_ms, self._index))
        if Traffic(rivals, self._plan.mission.safety.separation_m).conflict(here, end) is not None:
            return False
        return is_clear(self._passable(around, rivals), self._grid, here, end)

    def _drop(self, intent: Intent) -> None:
        """Mean an intended leg no longer, but look for another."""
        self.intent, self.why = None, intent.leg.why

    def _wait(self, around: Surroundings, why: str, seconds: float) -> Point | None:
        self._not_before_s = around.now_s + seconds
        self.why, self.waypoint = why, None
        return self._brake(around, why) if self.leg is None else None

    def _has_looked(self, around: Surroundings) -> bool:
        """Whether a scan was taken since the vehicle came to rest; what it still does not show is out of sight."""
        if self._arrived is None:
            self._arrived = (around.state.stamp_ms, around.now_s)
        arrived_ms, arrived_s = self._arrived
        if self._shared.last_scan_ms <= arrived_ms and around.now_s - arrived_s < SCAN_WITHIN_S:
            return False
        self._vain_looks.note(self._explorer.expected, self._shared.picture.states)
        return True

    def _travel(self, around: Surroundings, place_en_m: tuple[float, float], why: str) -> Point | Arrived | None:
        if around.now_s < self._not_before_s or not self._is_time(around):
            return None
        if self.intent is not None:
            return self._carry_on(around, self.intent)
        picture, state = self._picture(around), around.state
        if self._is_under_way(state):
            rest = self._make_room(around)
            return rest if rest is not None or self._braking or len(self._way) == 0 else self._fly_on(around, picture)
        away_m = math.dist(state.position_enu_m[:2], place_en_m)
        if away_m <= ARRIVED_M:
            return Arrived()
        self._goal, self.why = None, f"{why}, {away_m:.0f} m"
        if len(self._way) == 0 or not self._is_passable(picture):
            self._way = way_to(picture.passable, self._grid, self._start(state), place_en_m)
        if len(self._way) == 0:
            over = (place_en_m[0], place_en_m[1], state.position_enu_m[2])
            near = away_m <= 2.0 * self._grid.voxel_m
            if near and is_clear(picture.passable, self._grid, state.position_enu_m, over):
                return self._commit(around, over, self._way)
            taken = f"{why}, {away_m:.0f} m: the way is taken"
            return self.make_way(around) or self._wait(around, taken, WAIT_S)
        return self._fly_on(around, picture)

    # What is in the way

    def _make_room(self, around: Surroundings) -> Point | None:
        """Stop on a leg that has become unsafe: something in it, a teammate with the older right, or one who rests.

        Who only means to fly makes room.
        """
        if self.leg is None or self._braking:
            return None
        here, end = around.state.position_enu_m, self.leg.end_enu_m
        rivals = tuple(leg for leg in around.reservations if not leg.since_ms)
        traffic = Traffic(rivals, self._plan.mission.safety.separation_m)
        for rival in traffic.conflicts(here, end):
            if rival.precedes(self._index) or traffic.blocks(here, end, rival.end_enu_m):
                return self._brake(around, "making room for a teammate")
        if not is_clear(self._passable(around, rivals), self._grid, here, end):
            return self._brake(around, "something is in the way")
        return None

    def _brake(self, around: Surroundings, why: str) -> Point:
        rest = stopping_point(around.state)
        self._braking = True
        self.intent = self.waypoint = None
        self.why = why
        self.leg = Leg(rest, why)
        return rest

    def _is_passable(self, picture: VoxelPicture) -> bool:
        return bool(picture.passable.ravel()[self._way].all())

    def _picture(self, around: Surroundings) -> VoxelPicture:
        """The map with what this vehicle may not enter and need not see left out."""
        shown = self._shared.picture
        frontier = shown.frontier & self._area[:, :, None] & ~self._vain_looks.out_of_sight
        return replace(shown, passable=self._passable(around, around.reservations), frontier=frontier)

    def _passable(self, around: Surroundings, reservations: Sequence[Reservation]) -> BoolArray:
        """Voxels that this vehicle may fly through beside what teammates have reserved: (U, V, W) bool."""
        passable = self._shared.picture.passable & self._allowed[:, :, None]
        legs = [(leg.start_enu_m, leg.end_enu_m) for leg in reservations]
        keep_m = self._plan.mission.safety.separation_m + ROOM_M
        return without_traffic(passable, self._grid, legs, around.state.position_enu_m, keep_m)

    # Where it is

    def _is_time(self, around: Surroundings) -> bool:
        """Under way only now and then."""
        if not self._is_under_way(around.state):
            return True
        if around.now_s < self._next_check_s:
            return False
        self._next_check_s = around.now_s + CHECK_PERIOD_S
        return True

    def _is_under_way(self, state: VehicleState) -> bool:
        return self.leg is not None and not is_flown(self.leg, state)

    def _voxel_here(self, state: VehicleState) -> Voxel:
        column, row, layer = self._grid.clamped(self._grid.voxel_of(state.position_enu_m))
        return (column, row, min(layer, self._shared.ceiling))

    def _start(self, state: VehicleState) -> int:
        """Flat index of the voxel where ways begin."""
        return self._grid.flat_of(self._voxel_here(state))

    def _centre(self, flat: int) -> Point:
        east_m, north_m, up_m = self._grid.centres_of(np.array([flat]))[0].tolist()
        return (east_m, north_m, up_m)

    def _voxel_at(self, point_enu_m: Point) -> Voxel:
        return self._grid.clamped(self._grid.voxel_of(point_enu_m))
