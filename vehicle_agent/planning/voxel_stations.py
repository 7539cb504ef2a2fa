"""Stations among buildings: places from which a team sees most faces of walls, roofs and ground at once.

The team agrees as by `Stations`: each vehicle claims the place where it will stay, and keeps proposing better ones to
itself, weighed by the faces that no teammate's place sees, as the team's voxel map predicts them. What nobody knows yet
is taken for air over level ground, but within buildings for solid, so that a promising place is flown to and looked at.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.ray_fan import RayFan
from vehicle_agent.domain.voxel_evidence import ByteArray
from vehicle_agent.domain.voxel_faces import best_faces, open_faces, seen_faces
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.domain.voxel_paths import UNREACHED, trace_voxels, voxel_distances, with_clearance
from vehicle_agent.domain.voxels import FREE, OCCUPIED, UNKNOWN
from vehicle_agent.planning.frontier_travel import bearing_word
from vehicle_agent.planning.interface import Finished, Wait
from vehicle_agent.planning.settling import Settling, SettlingParams
from vehicle_agent.planning.voxel_explorer import Voxel, VoxelRoute
from vehicle_agent.planning.voxel_picture import VoxelPicture
from vehicle_agent.planning.voxel_situation import VoxelSituation

UNBUILT_WORTH = 2
"""Faces that a place may have of which nothing is known, in a town."""
VAIN_WAITS = 6
"""Decisions as near to a station as can be reached after which it is let go."""
HIDDEN_VOXELS = 4
"""What is not known within so many voxels of a station that could not be reached is taken for solid."""


@dataclass(frozen=True, slots=True)
class VoxelStationsParams(SettlingParams):
    """How stations among buildings are chosen.

    Attributes
    ----------
    apart_m
        Distance between any two stations, metres.
    """

    local_scales: tuple[float, ...] = (0.08, 0.2, 0.5)
    heated_decisions: int = 60
    apart_m: float = 3.0


@dataclass(frozen=True, slots=True)
class _Estimate:
    """What a map lets suppose.

    Attributes
    ----------
    states : (U, V, W) uint8, what it was worked out from.
    solid : (U, V, W) bool, known surface, and what nobody knows below it, behind its walls or on the ground.
    faces : (U, V, W) uint8, its faces that touch air.
    open_air : (U, V, W) bool, where a vehicle may hope to be: nothing is known to be within a voxel of it.
    worth : (U, V) int64, what a face counts; more where nothing stands yet, for what may.
    """

    states: ByteArray
    solid: BoolArray
    faces: ByteArray
    open_air: BoolArray
    worth: IndexArray

    @classmethod
    def of(cls, picture: VoxelPicture, out_of_reach: BoolArray) -> _Estimate:
        """Estimate from a map, and from where (U, V, W) what is not known could not be reached either."""
        occupied, unknown = picture.states == OCCUPIED, picture.states == UNKNOWN
        below_roofs = np.logical_or.accumulate(occupied[:, :, ::-1], axis=2)[:, :, ::-1]
        solid: BoolArray = occupied | (unknown & (below_roofs | out_of_reach | _walled_in(picture.states)))
        solid[:, :, 0] |= unknown[:, :, 0]
        worth = np.where(below_roofs[:, :, 0], 1, UNBUILT_WORTH)
        open_air = with_clearance(~solid)
        open_air[:, :, picture.ceiling + 1 :] = False
        return cls(picture.states, solid, open_faces(solid), open_air, worth)


def _walled_in(states: ByteArray) -> BoolArray:
    """What known walls cut off from all known air of its layer, as the inside of buildings: (U, V, W) bool."""
    level = np.zeros((3, 3, 3), dtype=np.bool_)
    level[:, 1, 1] = level[1, :, 1] = True
    rooms, count = label(states != OCCUPIED, level)
    has_air = np.zeros(count + 1, dtype=np.bool_)
    has_air[rooms[states == FREE]] = True
    walled_in: BoolArray = ~has_air[rooms]
    return walled_in


class VoxelStations:
    """One vehicle's part in the team's stations.

    Attributes
    ----------
    station_enu_m
        Where it means to stay; None before it was asked.
    revises_under_way
        True: a better station may be found at any time.
    """

    revises_under_way = True

    def __init__(
        self, index: int, grid: VoxelGrid, fan: RayFan, rng: np.random.Generator, params: VoxelStationsParams
    ) -> None:
        self._index, self._grid, self._fan, self._rng, self._params = index, grid, fan, rng, params
        self._settling = Settling(params)
        self._estimate: _Estimate | None = None
        self._station: Voxel | None = None
        self._out_of_reach = np.zeros(grid.shape, dtype=np.bool_)
        self._vain_waits = 0
        self._seen: tuple[list[Point], ByteArray] | None = None

    @property
    def station_enu_m(self) -> Point | None:
        return None if self._station is None else self._grid.centre_of(self._station)

    def ask(self, situation: VoxelSituation) -> VoxelRoute | Wait | Finished:
        """Revise the station and say how to get there."""
        here = self._voxel_at(situation.position_enu_m, situation.picture)
        station = self._station or here
        if self._settling.meet(situation.teammates):
            self._seen = None
        estimate = self._estimate_for(situation.picture)
        if self._settling.looks_on:
            station = self._revised(estimate, situation, station)
        self._settling.decisions += 1
        self._station = station
        return self._way(situation, here, station)

    def _voxel_at(self, position_enu_m: Point, picture: VoxelPicture) -> Voxel:
        column, row, layer = self._grid.clamped(self._grid.voxel_of(position_enu_m))
        return (column, row, min(layer, picture.ceiling))

    def _estimate_for(self, picture: VoxelPicture) -> _Estimate:
        """The present estimate; a map that shows other surface is worth looking for stations again."""
        if self._estimate is None or self._estimate.states is not picture.states:
            before = self._estimate
            self._estimate = _Estimate.of(picture, self._out_of_reach)
            if before is None or not np.array_equal(before.solid, self._estimate.solid):
                self._seen = None
                self._settling.look_again()
        return self._estimate

    def _revised(self, estimate: _Estimate, situation: VoxelSituation, station: Voxel) -> Voxel:
        """The proposal of the greatest noisy gain; the present station where none is better."""
        places = self._settling.places(situation.teammates, self._grid.voxel_m)
        taken = self._taken(estimate, places)
        proposals = self._proposals(estimate, situation, station, taken)
        proposals = self._admissible(estimate, situation.allowed, proposals, places)
        bonuses, cooled = np.zeros(len(proposals)), self._settling.cooled
        if cooled < 1.0:
            noise = self._params.heat * math.pi * self._fan.reach**2 * (1.0 - cooled)
            bonuses = noise * self._rng.gumbel(size=len(proposals))
        fan = self._fan
        best, gain, own_gain = best_faces(
            estimate.solid, fan.steps, fan.firsts, proposals, estimate.worth * situation.wanted, taken, bonuses
        )
        if cooled >= 1.0 and gain <= own_gain:
            self._settling.found(better=False)
            return station
        if best != 0:
            self._settling.found(better=True)
        column, row, layer = proposals[best].tolist()
        return (column, row, layer)

    def _taken(self, estimate: _Estimate, places: list[Point]) -> ByteArray:
        """Faces that teammates see from where they will stay."""
        if self._seen is None or self._seen[0] != places:
            voxels = np.array([self._grid.clamped(self._grid.voxel_of(place)) for place in places], dtype=np.int64)
            self._seen = (places, seen_faces(estimate.solid, self._fan, voxels.reshape(-1, 3)))
        return self._seen[1]

    def _proposals(
        self, estimate: _Estimate, situation: VoxelSituation, station: Voxel, taken: ByteArray
    ) -> IndexArray:
        """The present station first, then places around it and around faces that nobody would see: (M, 3) int64."""
        params, rng, reach = self._params, self._rng, self._fan.reach
        scales = params.local_scales[:-1] if self._settling.is_cold else params.local_scales
        spread = np.array((1.0, 1.0, 0.5)) * reach
        choices: list[FloatArray] = [np.array([station], dtype=np.float64)]
        choices += [station + rng.standard_normal((params.per_scale, 3)) * spread * scale for scale in scales]
        unseen = np.argwhere((estimate.faces & ~taken != 0) & situation.wanted[:, :, None])
        count = params.far // 3 if self._settling.is_cold else params.far
        if count and len(unseen):
            around = rng.standard_normal((count, 3)) * 0.5 * reach
            around[:, 2] = rng.uniform(1.0, 0.6 * reach, count)
            choices.append(unseen[rng.integers(len(unseen), size=count)] + around)
        proposals = np.rint(np.concatenate(choices)).astype(np.int64)
        highest = np.array(self._grid.shape) - 1
        highest[2] = situation.picture.ceiling
        return proposals.clip(0, highest)

    def _admissible(
        self, estimate: _Estimate, allowed: BoolArray, proposals: IndexArray, places: list[Point]
    ) -> IndexArray:
        """Proposals in open air, apart from teammates' stations."""
        columns, rows, layers = proposals.T
        keep = estimate.open_air[columns, rows, layers] & allowed[columns, rows]
        if places:
            centres = self._grid.corner_enu_m + (proposals + 0.5) * self._grid.voxel_m
            apart_m = np.linalg.norm(centres[:, None, :] - np.array(places)[None, :, :], axis=2)
            keep &= (apart_m >= self._params.apart_m).all(axis=1)
        keep[0] = True
        return np.ascontiguousarray(proposals[keep])

    def _way(self, situation: VoxelSituation, here: Voxel, station: Voxel) -> VoxelRoute | Wait | Finished:
        position_enu_m, there = situation.position_enu_m, self._grid.centre_of(station)
        voxel_m = self._grid.voxel_m
        away_m = math.dist(position_enu_m, there)
        self._settling.count(self._index, position_enu_m, there, situation.teammates, voxel_m, situation.periods)
        if self._settling.is_done:
            return Finished("covered: nobody knows a place from where the team would see more")
        if away_m <= voxel_m:
            self._settling.arrive()
            looking = not self._settling.is_cold or self._settling.looks_on
            return Wait("on its station, looking for a better one" if looking else "on its station")
        voxels = self._voxels_towards(situation.picture, here, station)
        self._vain_waits = 0 if len(voxels) > 1 else self._vain_waits + 1
        if self._settling.is_stuck or self._vain_waits >= VAIN_WAITS:
            self._let_go(station, here)
            return Wait("its station cannot be reached: looking for another from here")
        if len(voxels) < 2:
            return Wait("no way to its station is known yet")
        return VoxelRoute(voxels, f"station {away_m:.0f} m {bearing_word(position_enu_m[:2], there[:2])}")

    def _let_go(self, station: Voxel, here: Voxel) -> None:
        """Choose anew, and take what hides around the station for solid."""
        column, row, layer = (slice(max(0, place - HIDDEN_VOXELS), place + HIDDEN_VOXELS + 1) for place in station)
        self._out_of_reach[column, row, layer] = True
        self._estimate, self._station, self._vain_waits = None, here, 0
        self._settling.arrive()
        self._settling.look_again()

    def _voxels_towards(self, picture: VoxelPicture, here: Voxel, station: Voxel) -> IndexArray:
        """Shortest way to the station, or to the nearest place that can be reached: (N,) int64 flat indices.

        A place below it is no use while there is another: sensors never look up.
        """
        goals = np.zeros(self._grid.voxels, dtype=np.bool_)
        goal = self._grid.flat_of(station)
        goals[goal] = True
        distances, parents = voxel_distances(picture.passable, self._grid.flat_of(here), goals, 0)
        if distances[goal] == UNREACHED:
            reached = np.flatnonzero(distances != UNREACHED)
            away = np.column_stack(np.unravel_index(reached, self._grid.shape)) - np.array(station)
            goal = int(reached[np.lexsort(((away**2).sum(axis=1), away[:, 2] < 0))[0]])
        return trace_voxels(parents, goal)
