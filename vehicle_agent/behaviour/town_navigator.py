"""From voxel routes to legs: leads a vehicle between buildings, through known air only, and home again.

A route is flown in straight legs, each as far as the straight line stays in air that is known to be clear with room
around it, and kept clear of teammates and of the legs that they have reserved. Where it ends, the vehicle looks around;
what it went for and still does not see stays out of sight from there and is left alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vehicle_agent.behaviour.guide import Arrived, Surroundings
from vehicle_agent.behaviour.intent import Intent
from vehicle_agent.behaviour.leg import Leg, braking_distance_m, speed_m_s, stopping_point
from vehicle_agent.behaviour.navigator import allowed_cells
from vehicle_agent.behaviour.voxel_share import VoxelShare
from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.voxel_paths import UNREACHED, trace_voxels, voxel_distances
from vehicle_agent.domain.voxels import UNKNOWN
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.planning.constraints import Reservation, Traffic
from vehicle_agent.planning.interface import Finished, Waypoint
from vehicle_agent.planning.voxel_explorer import Voxel, VoxelExplorer, VoxelTeammate
from vehicle_agent.planning.voxel_picture import VoxelPicture, without_traffic
from vehicle_agent.ports import VehicleState

ARRIVED_M, SLOW_M_S = 0.5, 0.6
"""Near enough to the end of a leg between buildings, and slow enough to turn to any side."""
SIDEWAYS_M_S = 0.8
"""Speed across a new leg with which it may be begun in flight: the vehicle overshoots it by some decimetres."""
ROOM_M = 0.5
"""Beyond the separation that routes keep from teammates."""
CHECK_PERIOD_S = 0.5
WAIT_S = 1.0
PATIENCE = 3
"""Waits for a way to become clear before another is sought."""
LOOKED_AT_MOST = 2
"""A voxel that is not seen from where it should be so many times is left alone for good."""
SCAN_WITHIN_S = 5.0
SAMPLES_PER_VOXEL = 4


class TownNavigator:
    """A `Guide` through a town; what the end of a leg is flown for is told only when teammates should leave it."""

    has_sector = False
    intent: Intent | None = None

    def __init__(self, plan: MissionPlan, index: int, shared: VoxelShare) -> None:
        self._plan, self._index, self._shared = plan, index, shared
        self._grid = shared.team_map.grid
        self._explorer = VoxelExplorer(index, shared.fan)
        self._allowed, self._area = allowed_cells(plan), plan.area_cells
        self._vain_looks = np.zeros(self._grid.shape, dtype=np.uint8)
        self._out_of_sight = np.zeros(self._grid.shape, dtype=np.bool_)
        self._way: IndexArray = np.empty(0, dtype=np.int64)
        self._goal: Point | None = None
        self._arrived: tuple[int, float] | None = None
        self._blocked = 0
        self._reconsidered_at = -1
        self._next_check_s = -math.inf
        self._not_before_s = -math.inf
        self._braking = self._makes_way = False
        self.leg: Leg | None = None
        self.waypoint: Waypoint | None = None
        self.why = ""
        self.is_idle = False

    def work(self, around: Surroundings) -> Point | Finished | None:
        """Next target to fly to, Finished when nothing more can be seen, or None to carry on."""
        if around.now_s < self._not_before_s or not self._is_time(around):
            return None
        picture = self._picture(around)
        if self.leg is not None and not self._is_flown(around.state):
            if (rest := self._make_room(around, picture)) is not None:
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
        if self.leg is not None and not self._is_flown(around.state):
            return self._make_room(around, self._picture(around)) if self._is_time(around) else None
        traffic = Traffic(around.reservations, self._plan.mission.safety.separation_m)
        passages = [p for p in around.passages if traffic.blocks(p.start_enu_m, p.end_enu_m, here)]
        if not passages or around.now_s < self._not_before_s:
            return None
        picture = self._picture(around)
        way = self._way_aside(picture, around.state, passages)
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
        self.leg = self.waypoint = self._arrived = None
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
            return self._fly_on(around, picture) if len(self._way) else None
        self._way, self._goal = self._way[:0], None
        if any(mate.goal_enu_m is not None for mate in around.teammates):
            return self._wait(around, "nothing to be seen from here while teammates look", 2.0 * WAIT_S)
        known = int(np.count_nonzero(picture.states))
        if known != self._reconsidered_at:
            self._reconsidered_at = known
            self._out_of_sight = self._vain_looks >= LOOKED_AT_MOST
            self._explorer.reconsider()
            return self._wait(around, "tries again what was out of sight", WAIT_S)
        return Finished(self._farewell())

    def _farewell(self) -> str:
        left = int(np.count_nonzero(self._shared.picture.frontier & self._area[:, :, None]))
        hidden = f"; {left} voxels beside known air stay out of sight" if left else ""
        return f"everything observable is observed{hidden}"

    def _fly_on(self, around: Surroundings, picture: VoxelPicture) -> Point | None:
        """The next leg along the way, as far as can be flown straight; None to carry on with the present one."""
        here = around.state.position_enu_m
        traffic = Traffic(around.reservations, self._plan.mission.safety.separation_m)
        under_way = self.leg is not None and not self._is_flown(around.state)
        for place in range(len(self._way) - 1, -1, -1):
            end = self._centre(int(self._way[place]))
            if math.dist(here, end) > self._plan.mission.task.step_m or not self._is_clear(picture, here, end):
                continue
            if under_way and (self._turns(around.state, end) or self._is_end_of_leg(end)):
                return None
            if traffic.conflict(here, end) is not None:
                continue
            self._way = self._way[place + 1 :]
            self._blocked = 0
            return self._commit(around, end)
        if under_way:
            return None
        self._blocked += 1
        if self._blocked >= PATIENCE:
            self._way = self._way[:0]
            self._explorer.let_go()
        return self._wait(around, "the way is taken", WAIT_S)

    def _commit(self, around: Surroundings, end: Point) -> Point:
        corners = tuple(self._centre(int(voxel)) for voxel in self._way[:: max(1, len(self._way) // 10)][:11])
        self._braking = False
        self._arrived = None
        self.leg = Leg(end, self.why)
        self.waypoint = None
        if self._goal is not None:
            self.waypoint = Waypoint(end, self.why, self._goal, float(len(self._way)) * self._grid.voxel_m, corners)
        return end

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
        expected = self._explorer.expected
        vain = expected[self._shared.picture.states.ravel()[expected] == UNKNOWN]
        self._vain_looks.ravel()[vain] = np.minimum(self._vain_looks.ravel()[vain] + 1, LOOKED_AT_MOST)
        self._out_of_sight.ravel()[vain] = True
        return True

    def _travel(self, around: Surroundings, place_en_m: tuple[float, float], why: str) -> Point | Arrived | None:
        if around.now_s < self._not_before_s or not self._is_time(around):
            return None
        picture, state = self._picture(around), around.state
        if self.leg is not None and not self._is_flown(state):
            rest = self._make_room(around, picture)
            return rest if rest is not None or self._braking or len(self._way) == 0 else self._fly_on(around, picture)
        away_m = math.dist(state.position_enu_m[:2], place_en_m)
        if away_m <= ARRIVED_M:
            return Arrived()
        self._goal, self.why = None, f"{why}, {away_m:.0f} m"
        if len(self._way) == 0 or not self._is_passable(picture):
            self._way = self._way_to(picture, state, place_en_m)
        if len(self._way) == 0:
            over = (place_en_m[0], place_en_m[1], state.position_enu_m[2])
            if away_m <= 2.0 * self._grid.voxel_m and self._is_clear(picture, state.position_enu_m, over):
                return self._commit(around, over)
            taken = f"{why}, {away_m:.0f} m: the way is taken"
            return self.make_way(around) or self._wait(around, taken, WAIT_S)
        return self._fly_on(around, picture)

    def _way_to(self, picture: VoxelPicture, state: VehicleState, place_en_m: tuple[float, float]) -> IndexArray:
        """Voxels to the nearest place that can be reached, as high as the vehicle flies over a point."""
        goal = np.array(self._grid.clamped(self._grid.voxel_of((*place_en_m, 0.0)))[:2])
        start = self._grid.flat_of(self._voxel_here(state))
        nowhere = np.empty(0, dtype=np.bool_)
        distances, parents = voxel_distances(picture.passable, start, nowhere, 0)
        reached = np.flatnonzero(distances != UNREACHED)
        columns, rows, layers = np.unravel_index(reached, self._grid.shape)
        beside = np.hypot(columns - goal[0], rows - goal[1])
        best = np.lexsort((-layers, beside))[0]
        return trace_voxels(parents, int(reached[best]))[1:]

    def _way_aside(self, picture: VoxelPicture, state: VehicleState, passages: Sequence[Reservation]) -> IndexArray:
        """Voxels to the nearest place with room beside passages; empty when there is none."""
        nowhere = np.empty(0, dtype=np.bool_)
        distances, parents = voxel_distances(picture.passable, self._grid.flat_of(self._voxel_here(state)), nowhere, 0)
        legs = [(passage.start_enu_m, passage.end_enu_m) for passage in passages]
        keep_m = self._plan.mission.safety.separation_m + ROOM_M
        reached = (distances != UNREACHED).reshape(self._grid.shape)
        places = np.flatnonzero(without_traffic(reached, self._grid, legs, None, keep_m))
        if len(places) == 0:
            return self._way[:0]
        return trace_voxels(parents, int(places[np.argmin(distances[places])]))[1:]

    # What is in the way

    def _make_room(self, around: Surroundings, picture: VoxelPicture) -> Point | None:
        """Stop on a leg that has become unsafe: something in it, a teammate with the older right, or one who rests."""
        if self.leg is None or self._braking:
            return None
        here, end = around.state.position_enu_m, self.leg.end_enu_m
        traffic = Traffic(around.reservations, self._plan.mission.safety.separation_m)
        for rival in traffic.conflicts(here, end):
            if rival.precedes(self._index) or traffic.blocks(here, end, rival.end_enu_m):
                return self._brake(around, "making room for a teammate")
        if not self._is_clear(picture, here, end):
            return self._brake(around, "something is in the way")
        return None

    def _brake(self, around: Surroundings, why: str) -> Point:
        rest = stopping_point(around.state)
        self._braking = True
        self.waypoint = None
        self.why = why
        self.leg = Leg(rest, why)
        return rest

    def _is_clear(self, picture: VoxelPicture, start: Point, end: Point) -> bool:
        """Whether a straight line runs through air with room around it; where the vehicle is now does not count."""
        away = np.subtract(end, start)
        length = float(np.linalg.norm(away)) / self._grid.voxel_m
        if length == 0.0:
            return True
        places = np.arange(0.0, length, 1.0 / SAMPLES_PER_VOXEL)
        places = np.append(places[places > 1.5], length)
        points = np.array(start) + places[:, None] / length * away
        voxels = np.floor((points - self._grid.corner_enu_m) / self._grid.voxel_m).astype(np.int64)
        if (voxels < 0).any() or (voxels >= np.array(self._grid.shape)).any():
            return False
        return bool(picture.passable[tuple(voxels.T)].all())

    def _is_passable(self, picture: VoxelPicture) -> bool:
        return bool(picture.passable.ravel()[self._way].all())

    def _picture(self, around: Surroundings) -> VoxelPicture:
        """The map with what this vehicle may not enter and need not see left out."""
        shown = self._shared.picture
        passable = shown.passable & self._allowed[:, :, None]
        frontier = shown.frontier & self._area[:, :, None] & ~self._out_of_sight
        legs = [(leg.start_enu_m, leg.end_enu_m) for leg in around.reservations]
        keep_m = self._plan.mission.safety.separation_m + ROOM_M
        passable = without_traffic(passable, self._grid, legs, around.state.position_enu_m, keep_m)
        return replace(shown, passable=passable, frontier=frontier)

    # Where it is

    def _is_time(self, around: Surroundings) -> bool:
        """Under way only now and then."""
        if self.leg is None or self._is_flown(around.state):
            return True
        if around.now_s < self._next_check_s:
            return False
        self._next_check_s = around.now_s + CHECK_PERIOD_S
        return True

    def _is_flown(self, state: VehicleState) -> bool:
        assert self.leg is not None
        return math.dist(self.leg.end_enu_m, state.position_enu_m) <= ARRIVED_M and speed_m_s(state) <= SLOW_M_S

    def _is_end_of_leg(self, end: Point) -> bool:
        assert self.leg is not None
        return math.dist(self.leg.end_enu_m, end) < ARRIVED_M

    def _turns(self, state: VehicleState, end: Point) -> bool:
        """Whether the vehicle would be carried beside a leg to there, or past its end."""
        velocity, away = np.array(state.velocity_enu_m_s), np.subtract(end, state.position_enu_m)
        length = float(np.linalg.norm(away))
        if length == 0.0:
            return speed_m_s(state) > SLOW_M_S
        along = float(velocity @ away) / length
        across = math.sqrt(max(0.0, float(velocity @ velocity) - along**2))
        return across > SIDEWAYS_M_S or along < -SIDEWAYS_M_S or braking_distance_m(state) > length

    def _voxel_here(self, state: VehicleState) -> Voxel:
        column, row, layer = self._grid.clamped(self._grid.voxel_of(state.position_enu_m))
        return (column, row, min(layer, self._shared.ceiling))

    def _centre(self, flat: int) -> Point:
        east_m, north_m, up_m = self._grid.centres_of(np.array([flat]))[0].tolist()
        return (east_m, north_m, up_m)

    def _voxel_at(self, point_enu_m: Point) -> Voxel:
        return self._grid.clamped(self._grid.voxel_of(point_enu_m))
