"""One team in one town, second by second: vehicles fly through what they know, look down, tell, until all is seen.

What is seen in a second is told at its end and known to all in the next: the lag of the exploration bench, whose steps
are as long. Lost and late messages are tried in missions.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from sim_bridge.observable import Observable
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.ray_fan import RayFan, rays_until
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.domain.voxels import OCCUPIED, VoxelMap, newly_decided
from vehicle_agent.planning.voxel_explorer import Voxel, VoxelExplorer, VoxelTeammate
from vehicle_agent.planning.voxel_picture import VoxelPicture
from vehicle_agent.wire.voxel_blob import pack_voxels

IDLE_S = 4
"""A vehicle with nothing to do asks again after so many seconds, when the map has changed."""


@dataclass(frozen=True, slots=True)
class UrbanParams:
    """What the vehicles can do.

    Attributes
    ----------
    range_m, speed_m_s, separation_m
        Of sensing, of flight, and between any two vehicles.
    ceiling_m
        Highest flight above the ground; the air there is clear.
    limit_s
        When to give up.
    """

    range_m: float = 20.0
    speed_m_s: float = 2.0
    separation_m: float = 2.0
    ceiling_m: float = 26.5
    limit_s: int = 1_500


@dataclass(slots=True)
class UrbanRun:
    """What a run left behind.

    Attributes
    ----------
    observed_share : per second, share of the observable surface on the team's map.
    positions_enu_m : (T, N, 3) float64.
    finished_s : when everything observable was observed; None when it never was.
    closest_m : smallest distance between two vehicles at any second.
    bytes_told : what all vehicles together would have sent of the map, packed as for the radio.
    idle_s, held_up_s : vehicle-seconds of all together before the end: without a goal, and with one but held up.
    """

    observed_share: list[float]
    positions_enu_m: FloatArray
    finished_s: int | None
    closest_m: float
    bytes_told: int
    idle_s: int
    held_up_s: int

    def seen_s(self, share: float) -> int | None:
        """When so much of the observable surface was observed; None when it never was."""
        return next((second for second, seen in enumerate(self.observed_share) if seen >= share), None)


@dataclass(slots=True)
class _Flyer:
    voxel: Voxel
    explorer: VoxelExplorer
    way: IndexArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    budget_m: float = 0.0
    idle: bool = False
    idle_since_known: int = -1


class UrbanExploration:
    """A team in a town."""

    def __init__(
        self,
        grid: VoxelGrid,
        solid: BoolArray,
        truth: Observable,
        starts: list[Voxel],
        fan: RayFan,
        params: UrbanParams,
    ) -> None:
        self._grid, self._solid, self._truth, self._fan, self._params = grid, solid, truth, fan, params
        self._map = VoxelMap(grid)
        self._ceiling = grid.voxel_of((grid.west_m, grid.south_m, params.ceiling_m))[2]
        self._flyers = [_Flyer(start, VoxelExplorer(index, fan)) for index, start in enumerate(starts)]
        self._now_s = 0
        self._reconsidered_at = -1
        self._told = np.zeros((len(starts), grid.voxels), dtype=np.uint8)
        self._bytes_told = self._idle_s = self._held_up_s = 0

    def run(self) -> UrbanRun:
        shares: list[float] = []
        track: list[list[tuple[float, float, float]]] = []
        while True:
            for index in range(len(self._flyers)):
                self._scan(index)
                self._tell(index)
            picture = VoxelPicture.of(self._map.states(), self._ceiling)
            shares.append(self._share(picture))
            track.append([self._grid.centre_of(flyer.voxel) for flyer in self._flyers])
            if shares[-1] >= 1.0 or self._now_s >= self._params.limit_s:
                break
            self._now_s += 1
            for index in range(len(self._flyers)):
                self._move(index, picture)
                self._count_losses(index, track[-1][index])
            if all(flyer.idle for flyer in self._flyers) and not self._reconsider(picture):
                break
        positions = np.array(track)
        finished = self._now_s if shares[-1] >= 1.0 else None
        return UrbanRun(
            shares, positions, finished, _closest_m(positions), self._bytes_told, self._idle_s, self._held_up_s
        )

    def _count_losses(self, index: int, was_at_enu_m: tuple[float, float, float]) -> None:
        flyer = self._flyers[index]
        if flyer.idle:
            self._idle_s += 1
        elif self._grid.centre_of(flyer.voxel) == was_at_enu_m:
            self._held_up_s += 1

    @property
    def missing(self) -> IndexArray:
        """(N, 3) voxels of the observable surface that nobody observed."""
        return np.argwhere(self._truth.surface & (self._map.states() != OCCUPIED))

    def _reconsider(self, picture: VoxelPicture) -> bool:
        """Once all are idle, let all try again what they gave up, perhaps for a teammate in the way; once per map."""
        known = int(np.count_nonzero(picture.states))
        if known == self._reconsidered_at:
            return False
        self._reconsidered_at = known
        for flyer in self._flyers:
            flyer.explorer.reconsider()
            flyer.idle = False
        return True

    def _share(self, picture: VoxelPicture) -> float:
        seen = (picture.states == OCCUPIED) & self._truth.surface
        return float(seen.sum() / self._truth.surface.sum())

    def _scan(self, index: int) -> None:
        flyer, fan = self._flyers[index], self._fan
        last, met, counts = rays_until(self._solid, fan.steps, fan.firsts, *flyer.voxel)
        centre = np.array(self._grid.centre_of(flyer.voxel))
        ends = fan.ends(centre, last, self._grid.voxel_m)
        sensor = (float(centre[0]), float(centre[1]), float(centre[2]))
        self._map.insert(
            index, sensor, ends[counts], self._params.range_m + self._grid.voxel_m, 1000 * self._now_s, met[counts]
        )

    def _tell(self, index: int) -> None:
        """Count what a vehicle would tell now: voxels of which its own evidence decides for the first time, or anew."""
        news = newly_decided(self._map.take_untold(index), self._told[index])
        self._bytes_told += len(pack_voxels(news))

    def _move(self, index: int, picture: VoxelPicture) -> None:
        flyer = self._flyers[index]
        known = int(np.count_nonzero(picture.states))
        if flyer.idle and (flyer.idle_since_known == known or self._now_s % IDLE_S != 0):
            return
        mates = [
            VoxelTeammate(other, mate.voxel, mate.explorer.goal)
            for other, mate in enumerate(self._flyers)
            if other != index
        ]
        if flyer.explorer.is_taken(flyer.voxel, mates):
            flyer.explorer.let_go()
            flyer.way = flyer.way[:0]
        if len(flyer.way) < 2 or not flyer.explorer.still_worth(picture) or not self._clear(index, picture):
            own = self._without_others(index, picture)
            route = flyer.explorer.ask(own, flyer.voxel, mates)
            flyer.idle, flyer.idle_since_known = route is None, known
            flyer.way = route.voxels if route is not None else np.empty(0, dtype=np.int64)
        flyer.budget_m += self._params.speed_m_s
        while len(flyer.way) > 1:
            following = self._voxel(int(flyer.way[1]))
            length_m = self._grid.voxel_m * float(np.linalg.norm(np.subtract(following, flyer.voxel)))
            if flyer.budget_m < length_m:
                return
            if self._too_near(index, following):
                flyer.way = flyer.way[:0]
                break
            flyer.voxel, flyer.way = following, flyer.way[1:]
            flyer.budget_m -= length_m
        flyer.budget_m = min(flyer.budget_m, self._grid.voxel_m)

    def _voxel(self, flat: int) -> Voxel:
        column, row, layer = np.unravel_index(flat, self._grid.shape)
        return (int(column), int(row), int(layer))

    def _clear(self, index: int, picture: VoxelPicture) -> bool:
        return bool(picture.passable.ravel()[self._flyers[index].way[1:]].all())

    def _too_near(self, index: int, voxel: Voxel) -> bool:
        keep_m = self._params.separation_m + self._grid.voxel_m
        return any(
            self._grid.voxel_m * float(np.linalg.norm(np.subtract(voxel, mate.voxel))) < keep_m
            for other, mate in enumerate(self._flyers)
            if other != index
        )

    def _without_others(self, index: int, picture: VoxelPicture) -> VoxelPicture:
        """The picture with the space around teammates impassable."""
        passable = picture.passable.copy()
        keep = self._params.separation_m / self._grid.voxel_m + 1.0
        reach = int(np.ceil(keep))
        for other, mate in enumerate(self._flyers):
            if other == index:
                continue
            low = [max(0, place - reach) for place in mate.voxel]
            box = tuple(slice(first, place + reach + 1) for first, place in zip(low, mate.voxel, strict=True))
            around = np.indices(passable[box].shape)
            away = [around[axis] + low[axis] - mate.voxel[axis] for axis in range(3)]
            passable[box] &= away[0] ** 2 + away[1] ** 2 + away[2] ** 2 >= keep**2
        return replace(picture, passable=passable)


def _closest_m(positions_enu_m: FloatArray) -> float:
    vehicles = positions_enu_m.shape[1]
    closest = np.inf
    for one in range(vehicles):
        for other in range(one + 1, vehicles):
            away = np.linalg.norm(positions_enu_m[:, one] - positions_enu_m[:, other], axis=1)
            closest = min(closest, float(away.min()))
    return closest
