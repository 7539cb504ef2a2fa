"""Decentralised exploration among buildings: the team shares the ground plan out as tours and looks into every corner.

The ground plan is divided into square patches. Each vehicle, from the team's voxel map and its teammates' places and
claims alone, computes the whole team's tours over the patches that still show frontiers (unknown voxels beside known
free ones) or are untouched, and goes for the first patch of its own tour. In a patch it flies to the place from which
most that is unknown comes into view per way to go, through known free voxels only; a frontier voxel counts when a ray
of its sensor reaches it through known free voxels, so that every such visit makes something known.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.ray_fan import RayFan, count_seen, first_with_view, unknown_met
from vehicle_agent.domain.tours import share_out
from vehicle_agent.domain.voxel_paths import UNIT, UNREACHED, trace_voxels, voxel_distances
from vehicle_agent.domain.voxels import UNKNOWN
from vehicle_agent.planning.voxel_picture import VoxelPicture

Voxel = tuple[int, int, int]
MOST_COMPARED, SPARSE = 24, 16
"""Places of which the whole view is estimated, and every how manyth ray is followed for that."""


@dataclass(frozen=True, slots=True)
class VoxelTeammate:
    """Where a vehicle of the team is, and the patch that it goes for (None when for none)."""

    index: int
    voxel: Voxel
    patch: int | None = None


@dataclass(frozen=True, slots=True)
class VoxelRoute:
    """Where to fly: flat indices of voxels from the present one to a viewpoint, and why."""

    voxels: IndexArray
    why: str


@dataclass(frozen=True, slots=True)
class VoxelExplorerParams:
    """How patches are shared and viewpoints weighed; lengths in voxels.

    Attributes
    ----------
    patch
        Edge of a patch.
    service
        Way that looking through a whole patch costs in a tour.
    full_patch
        Surface expected at the frontiers of a patch that takes the whole service, in voxels.
    untouched_share
        A patch of which less than this share is known is untouched.
    detour
        How much further than to the nearest place with a view the search for a better one goes.
    at_once
        Way that counts as nothing when gains per way are weighed.
    sampled
        At most so many frontier voxels of a patch are tried.
    passes
        Rounds of improvement of the tours.
    likely
        Chance of being surface from which on a frontier voxel alone is worth a way.
    least
        Surface expected at the frontiers of a patch below which it is left until nothing better is left.
    remaining
        Share of what a route was chosen for below which it is chosen anew.
    above_ground
        Chance that an unknown voxel behind the frontier is surface, where it is not the ground.
    volume
        Weight of what may lie behind the frontier against what is seen of the frontier for sure.
    """

    patch: int = 12
    service: float = 12.0
    full_patch: int = 80
    untouched_share: float = 0.1
    detour: float = 15.0
    at_once: float = 4.0
    sampled: int = 120
    passes: int = 20
    likely: float = 0.1
    least: float = 0.02
    remaining: float = 0.0
    above_ground: float = 0.1
    volume: float = 1.0

    def __post_init__(self) -> None:
        if self.patch < 1 or self.sampled < 1 or self.full_patch < 1:
            raise ValueError("patch, sampled and full_patch must be at least 1")


class _Search:
    """Ways from a vehicle's place, searched as far as needed."""

    def __init__(self, picture: VoxelPicture, voxel: Voxel) -> None:
        self.picture = picture
        self.start = int(np.ravel_multi_index(voxel, picture.states.shape))
        self._everywhere: tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]] | None = None

    def around(self, goals: BoolArray, further: int) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
        """Distances and parents up to `further` units beyond the nearest of the goals."""
        if self._everywhere is not None:
            distances, parents = self._everywhere
            nearest = distances[goals].min(initial=UNREACHED)
            return np.where(distances <= np.int64(nearest) + further, distances, UNREACHED), parents
        return voxel_distances(self.picture.passable, self.start, goals, further)

    def everywhere(self) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
        """Distances and parents of all voxels within reach."""
        if self._everywhere is None:
            nowhere = np.empty(0, dtype=np.bool_)
            self._everywhere = voxel_distances(self.picture.passable, self.start, nowhere, 0)
        return self._everywhere


class VoxelExplorer:
    """One vehicle's part."""

    def __init__(self, index: int, fan: RayFan, params: VoxelExplorerParams | None = None) -> None:
        self._index = index
        self._fan = fan
        self._params = params or VoxelExplorerParams()
        self._given_up: dict[tuple[bool, int], int] = {}
        self._expected: IndexArray = np.empty(0, dtype=np.int64)
        self.patch: int | None = None

    def still_worth(self, picture: VoxelPicture) -> bool:
        """Whether enough of what the present route was chosen for is still unknown."""
        unknown = np.count_nonzero(picture.states.ravel()[self._expected] == UNKNOWN)
        return bool(unknown > self._params.remaining * len(self._expected))

    @property
    def expected(self) -> IndexArray:
        """Flat indices of the voxels for which the present route was chosen: (N,) int64."""
        return self._expected

    @property
    def expects_any(self) -> bool:
        return len(self._expected) > 0

    def let_go(self) -> None:
        """Leave the present patch: the way there is taken."""
        self.patch = None

    def reconsider(self) -> None:
        """Try again what was given up."""
        self._given_up.clear()

    def patch_of(self, voxel: Voxel, shape: tuple[int, ...]) -> int:
        """Number of the patch that a voxel belongs to."""
        return int(self._patch_of(np.array([voxel], dtype=np.int64), shape)[0])

    def middle_of(self, patch: int, shape: tuple[int, ...]) -> tuple[int, int]:
        """Column and row in the middle of a patch; they may lie beyond the grid's border."""
        column, row = self._patches(shape)[patch]
        return (int(column), int(row))

    def ask(self, picture: VoxelPicture, voxel: Voxel, teammates: list[VoxelTeammate]) -> VoxelRoute | None:
        """Choose a route from here; None when nothing unknown can be seen from anywhere within reach.

        Patches from which nothing more can be seen are given up until more is known around them.
        """
        frontier = np.argwhere(picture.frontier)
        patches = self._patches(picture.states.shape)
        of_frontier = self._patch_of(frontier, picture.states.shape)
        worth = picture.worth[tuple(frontier.T)].astype(np.float64)
        counts: FloatArray = np.bincount(of_frontier, weights=worth, minlength=len(patches)).astype(np.float64)
        known = self._known_per_patch(picture)
        around = _window_sums(known, self._grid_of_patches(picture.states.shape))
        self._given_up = {(all_, p): k for (all_, p), k in self._given_up.items() if around[p] == k}
        search = _Search(picture, voxel)
        everything = False
        while True:
            open_patches = counts > (0.0 if everything else self._params.least)
            open_patches[[patch for all_, patch in self._given_up if all_ == everything]] = False
            if not open_patches.any():
                if not everything:
                    everything = True
                    continue
                self.patch = None
                return None
            if self.patch is not None and open_patches[self.patch]:
                chosen = self.patch
            else:
                chosen = self._choose(voxel, teammates, patches, counts, open_patches, known, picture)
            wanted = of_frontier == chosen
            route = self._route_to_view(search, np.ascontiguousarray(frontier[wanted]), worth[wanted])
            if route is not None:
                self.patch = chosen
                return route
            self._given_up[everything, chosen] = int(around[chosen])

    def _choose(
        self, voxel: Voxel, teammates: list[VoxelTeammate], patches: FloatArray, counts: FloatArray,
        open_patches: BoolArray, known: IndexArray, picture: VoxelPicture,
    ) -> int:  # fmt: skip
        """First patch of the own tour; for an untouched patch without frontier the open one nearest to it."""
        params = self._params
        volume = params.patch**2 * (picture.ceiling + 1)
        untouched = ~open_patches & (known < params.untouched_share * volume)
        claimed = [mate.patch for mate in teammates if mate.patch is not None]
        stops = open_patches | untouched
        stops[claimed] = False
        if not (stops & open_patches).any():
            stops = open_patches
        numbers = np.flatnonzero(stops)
        service = params.service * np.minimum(1.0, counts[numbers] / params.full_patch)
        service[untouched[numbers]] = params.service
        team = sorted(
            [(self._index, np.array(voxel[:2], dtype=np.float64)), *((m.index, _start(m, patches)) for m in teammates)],
            key=lambda member: member[0],
        )
        starts = np.array([place for _, place in team])
        tours, lengths = share_out(starts, starts, patches[numbers], service, 0.0, params.passes)
        mine = [index for index, _ in team].index(self._index)
        here = np.array(voxel[:2])
        if lengths[mine] == 0:
            first = int(numbers[np.argmin(np.hypot(*(patches[numbers] - here).T))])
        else:
            first = int(numbers[tours[mine, 0]])
        if open_patches[first]:
            return first
        choices = np.flatnonzero(open_patches)
        way = np.hypot(*(patches[choices] - patches[first]).T) + 0.5 * np.hypot(*(patches[choices] - here).T)
        return int(choices[np.argmin(way)])

    def _route_to_view(self, search: _Search, wanted: IndexArray, worth: FloatArray) -> VoxelRoute | None:
        """Fly where most comes into view per way; None when nothing wanted can be seen from any place within reach.

        First some of the wanted voxels are tried from places not far beyond the nearest; then all from everywhere.
        """
        picture, reach = search.picture, self._fan.reach
        low = np.maximum(wanted.min(axis=0) - reach, 0)
        high = wanted.max(axis=0) + reach + 1
        near = np.zeros(picture.states.shape, dtype=np.bool_)
        box = (slice(low[0], high[0]), slice(low[1], high[1]), slice(int(wanted[:, 2].min()), high[2]))
        near[box] = picture.passable[box]
        stride = max(1, len(wanted) // self._params.sampled)
        some = (np.ascontiguousarray(wanted[::stride]), stride * worth[::stride])
        for (tried, weights), everywhere in ((some, False), ((wanted, worth), True)):
            if everywhere:
                distances, parents = search.everywhere()
            else:
                distances, parents = search.around(near.ravel(), round(self._params.detour * UNIT))
            places = np.flatnonzero(near.ravel() & (distances != UNREACHED))
            spots = np.column_stack(np.unravel_index(places, picture.states.shape))
            if not everywhere:
                kept = (spots % 2 == 0).all(axis=1) | (places == search.start)
                places, spots = places[kept], spots[kept]
            best = self._best_view(picture, spots, tried, weights, distances[places])
            if best is not None:
                self._expected = self._sure(picture, spots[best], tried, weights)
                way = trace_voxels(parents, int(places[best]))
                return VoxelRoute(way, f"looks at {len(self._expected)} frontier voxels from {len(way)} voxels away")
        return self._nearest_glimpse(search, wanted, near.ravel())

    def _nearest_glimpse(self, search: _Search, wanted: IndexArray, near: BoolArray) -> VoxelRoute | None:
        """Fly to the nearest of some places from which any ray at all reaches a wanted voxel; None without one."""
        if len(wanted) == 0:
            return None
        fan, picture = self._fan, search.picture
        distances, parents = search.everywhere()
        places = np.flatnonzero(near & (distances != UNREACHED))
        places = places[np.argsort(distances[places], kind="stable")]
        spots = np.column_stack(np.unravel_index(places, picture.states.shape))
        place, seen = first_with_view(
            picture.states, fan.steps, fan.firsts, fan.reach,
            fan.crossings.firsts, fan.crossings.rays, fan.crossings.steps, spots, wanted,
        )  # fmt: skip
        if place < 0:
            return None
        self._expected = np.array([np.ravel_multi_index(tuple(wanted[seen]), picture.states.shape)], dtype=np.int64)
        return VoxelRoute(trace_voxels(parents, int(places[place])), "has a glimpse of one hidden frontier voxel")

    def _best_view(
        self,
        picture: VoxelPicture,
        spots: IndexArray,
        wanted: IndexArray,
        worth: FloatArray,
        distances: npt.NDArray[np.int32],
    ) -> int | None:
        fan, params = self._fan, self._params
        seen = count_seen(picture.states, fan.steps, fan.firsts, fan.ray_to, spots, wanted, worth, np.inf)
        cost = distances / UNIT + params.at_once
        rate = seen / cost
        candidates = np.argsort(-rate, kind="stable")[:MOST_COMPARED]
        candidates = candidates[seen[candidates] > 0]
        if len(candidates) == 0:
            return None
        met = unknown_met(picture.states, fan.steps, fan.firsts, spots[candidates], SPARSE, params.above_ground)
        gains = params.volume * SPARSE * met + seen[candidates]
        return int(candidates[np.argmax(gains / cost[candidates])])

    def _sure(self, picture: VoxelPicture, spot: IndexArray, wanted: IndexArray, worth: FloatArray) -> IndexArray:
        """Flat indices of the wanted voxels that are seen for sure from a spot: the likely ones where there are any."""
        fan = self._fan
        one = np.ones(1)
        seen = [
            count_seen(picture.states, fan.steps, fan.firsts, fan.ray_to, spot[None], wanted[i : i + 1], one, 1.0)[0]
            > 0
            for i in range(len(wanted))
        ]
        chosen = np.array(seen)
        if (worth[chosen] >= self._params.likely).any():
            chosen &= worth >= self._params.likely
        flat = np.ravel_multi_index(tuple(wanted[chosen].T), picture.states.shape)
        return np.asarray(flat, dtype=np.int64)

    def _grid_of_patches(self, shape: tuple[int, ...]) -> tuple[int, int]:
        return (-(-shape[0] // self._params.patch), -(-shape[1] // self._params.patch))

    def _patches(self, shape: tuple[int, ...]) -> FloatArray:
        """Middles of all patches: (P, 2) float64, in voxels."""
        columns, rows = self._grid_of_patches(shape)
        across, along = np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij")
        corners = np.column_stack((across.ravel(), along.ravel())).astype(np.float64)
        return (corners + 0.5) * self._params.patch

    def _patch_of(self, voxels: IndexArray, shape: tuple[int, ...]) -> IndexArray:
        rows = self._grid_of_patches(shape)[1]
        return voxels[:, 0] // self._params.patch * rows + voxels[:, 1] // self._params.patch

    def _known_per_patch(self, picture: VoxelPicture) -> IndexArray:
        """Known voxels up to the ceiling: (P,) int64."""
        patch = self._params.patch
        known = np.count_nonzero(picture.states[:, :, : picture.ceiling + 1], axis=2)
        sums = np.add.reduceat(
            np.add.reduceat(known, np.arange(0, known.shape[0], patch), axis=0),
            np.arange(0, known.shape[1], patch),
            axis=1,
        )
        return np.asarray(sums, dtype=np.int64).ravel()


def _start(mate: VoxelTeammate, patches: FloatArray) -> FloatArray:
    if mate.patch is None:
        return np.array(mate.voxel[:2], dtype=np.float64)
    middle: FloatArray = patches[mate.patch].astype(np.float64)
    return middle


def _window_sums(values: IndexArray, shape: tuple[int, int]) -> IndexArray:
    """Sum over each patch and those up to two away: (P,) int64."""
    padded = np.pad(values.reshape(shape), 2)
    windows = np.lib.stride_tricks.sliding_window_view(padded, (5, 5))
    sums: IndexArray = windows.sum(axis=(2, 3)).ravel()
    return sums
