"""Decentralised exploration among buildings: the team shares the town out as tours and looks into every corner.

The town is divided into patches, stacked in columns, so that a street is flown along and not up and down. Each vehicle,
from the team's voxel map and its teammates' places and goals alone, computes the whole team's tours over the patches
that still show frontiers (unknown voxels beside known free ones) and over untouched columns, by the ways through known
air, and goes for the first patch of its own tour. For a patch it flies to the place from which most that is unknown
comes into view per way to go, through known free voxels only; a frontier voxel counts when a ray of its sensor reaches
it through known free voxels, so that every such visit makes something known. Places on the way to the tour's next
patch cost less than those that lead away from it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.ray_fan import RayFan, count_seen, first_with_view, unknown_met
from vehicle_agent.domain.tours import share_out
from vehicle_agent.domain.voxel_paths import UNIT, UNREACHED, trace_voxels, voxel_distances
from vehicle_agent.domain.voxels import UNKNOWN
from vehicle_agent.planning.voxel_patches import FrontierWork, VoxelPatches, ways_between
from vehicle_agent.planning.voxel_picture import VoxelPicture

Voxel = tuple[int, int, int]
MOST_COMPARED, SPARSE = 24, 16
"""Places of which the whole view is estimated, and every how manyth ray is followed for that."""


@dataclass(frozen=True, slots=True)
class VoxelTeammate:
    """Where a vehicle of the team is, and the middle of what it goes for (None when for nothing)."""

    index: int
    voxel: Voxel
    goal: Voxel | None = None


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
    patch, storey
        Edge of a patch along the ground, and its height.
    service
        Way that looking through a whole patch costs in a tour.
    full_patch
        Surface expected at the frontiers of a patch that takes the whole service, in voxels.
    untouched_service
        Way that looking through an untouched column costs in a tour.
    seen_from
        How near stops must be to each other for half of the way between them to be saved in a tour: much of a patch
        is seen from its neighbours. Above 0.
    untouched_layer
        Where in an untouched column tours are taken to pass.
    untouched_share
        A column of which less than this share is known is untouched, unless something in it can be looked at.
    detour
        How much further than to the nearest place with a view the search for a better one goes.
    at_once
        Way that counts as nothing when gains per way are weighed.
    onward
        Weight of the detour that a place is on the way to the tour's next patch, beside the way to the place.
    sampled
        At most so many frontier voxels of a patch are tried.
    passes
        Rounds of improvement of the tours.
    much_nearer
        A goal is left to a vehicle that is nearer to it by so much than the one that went for it.
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
    storey: int = 9
    service: float = 6.0
    full_patch: int = 60
    untouched_service: float = 12.0
    seen_from: float = 20.0
    untouched_layer: int = 12
    untouched_share: float = 0.1
    detour: float = 15.0
    at_once: float = 4.0
    onward: float = 1.0
    sampled: int = 120
    passes: int = 20
    much_nearer: float = 10.0
    likely: float = 0.1
    least: float = 0.02
    remaining: float = 0.0
    above_ground: float = 0.1
    volume: float = 1.0

    def __post_init__(self) -> None:
        if min(self.patch, self.storey, self.sampled, self.full_patch) < 1:
            raise ValueError("patch, storey, sampled and full_patch must be at least 1")
        if self.seen_from <= 0.0:
            raise ValueError("seen_from must be positive")


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
        self._patch: int | None = None
        self._division: VoxelPatches | None = None
        self._afterwards: IndexArray | None = None
        self._is_spare = False
        self.goal: Voxel | None = None

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

    def is_taken(self, voxel: Voxel, teammates: list[VoxelTeammate]) -> bool:
        """Whether a teammate that is much nearer goes for the same patch, and there was something else to do."""
        if self.goal is None or self._division is None or self._is_spare:
            return False
        goals = _goals(teammates)
        same = self._division.patch_of(np.array([mate.goal for mate in goals]).reshape(-1, 3)) == self._patch
        me = VoxelTeammate(self._index, voxel, self.goal)
        return any(self._is_much_nearer(goals[place].voxel, me) for place in np.flatnonzero(same))

    def let_go(self) -> None:
        """Leave the present patch: the way there is taken, or a teammate has taken the patch."""
        self._patch = self.goal = None

    def reconsider(self) -> None:
        """Try again what was given up."""
        self._given_up.clear()

    def ask(self, picture: VoxelPicture, voxel: Voxel, teammates: list[VoxelTeammate]) -> VoxelRoute | None:
        """Choose a route from here; None when nothing unknown can be seen from anywhere within reach.

        Patches from which nothing more can be seen are given up until more is known around them.
        """
        division = self._division = VoxelPatches(picture.states.shape, self._params.patch, self._params.storey)
        work = FrontierWork.of(picture, division)
        known = division.known_per_column(picture)
        around = division.sums_around(known)[division.columns()]
        self._given_up = {(all_, p): k for (all_, p), k in self._given_up.items() if around[p] == k}
        search = _Search(picture, voxel)
        everything = False
        while True:
            open_patches = work.expected > (0.0 if everything else self._params.least)
            open_patches[[patch for all_, patch in self._given_up if all_ == everything]] = False
            if not open_patches.any():
                if not everything:
                    everything = True
                    continue
                self.let_go()
                return None
            if self._patch is not None and open_patches[self._patch]:
                chosen = self._patch
            else:
                untouched = self._untouched(picture, division, work.centres[open_patches], known)
                chosen, self._afterwards = self._choose(
                    picture, voxel, teammates, division, work, open_patches, untouched
                )
            wanted = work.patches == chosen
            route = self._route_to_view(search, np.ascontiguousarray(work.voxels[wanted]), work.worth[wanted])
            if route is not None:
                if chosen != self._patch:
                    self._patch, self.goal = chosen, _voxel(work.centres[chosen])
                return route
            self._given_up[everything, chosen] = int(around[chosen])

    def _untouched(
        self, picture: VoxelPicture, division: VoxelPatches, open_places: IndexArray, known: IndexArray
    ) -> IndexArray:
        """Where tours pass through columns of which next to nothing is known or can be looked at: (C, 3) int64."""
        bare = known < self._params.untouched_share * self._params.patch**2 * (picture.ceiling + 1)
        bare[division.column_of(open_places)] = False
        return division.column_middles(min(self._params.untouched_layer, picture.ceiling))[bare]

    def _choose(
        self, picture: VoxelPicture, voxel: Voxel, teammates: list[VoxelTeammate], division: VoxelPatches,
        work: FrontierWork, open_patches: BoolArray, untouched: IndexArray,
    ) -> tuple[int, IndexArray | None]:  # fmt: skip
        """First patch of the own tour, and the (3,) voxel where the tour goes on, None where it ends.

        For an untouched column that is the open patch that is best on the way there; the tour goes on to the column.
        """
        params = self._params
        teammates = [replace(mate, goal=None) if self._is_much_nearer(voxel, mate) else mate for mate in teammates]
        goals = np.array([mate.goal for mate in _goals(teammates)], dtype=np.int64).reshape(-1, 3)
        stops = open_patches.copy()
        stops[division.patch_of(goals)] = False
        self._is_spare = not stops.any()
        numbers = np.flatnonzero(open_patches if self._is_spare else stops)
        service = params.service * np.minimum(1.0, work.expected[numbers] / params.full_patch)
        service = np.concatenate((service, np.full(len(untouched), params.untouched_service)))
        team = sorted((VoxelTeammate(self._index, voxel), *teammates), key=lambda member: member.index)
        starts = np.array([member.voxel if member.goal is None else member.goal for member in team], dtype=np.int64)
        ahead: FloatArray = np.linalg.norm(starts - np.array([member.voxel for member in team]), axis=1)
        places = np.concatenate((work.centres[numbers], untouched))
        ways = ways_between(picture, np.concatenate((starts, places)))
        # Beside each other most stops are seen in passing: only long ways between them are flown as they are.
        flown = ways * ways / (ways + params.seen_from)
        tours, lengths = share_out(flown, ahead, service, params.passes)
        mine = [member.index for member in team].index(self._index)
        from_here, between = ways[mine, len(team) :], ways[len(team) :, len(team) :]
        own = tours[mine, : lengths[mine]]
        first = int(own[0]) if len(own) else int(np.argmin(from_here[: len(numbers)]))
        if first >= len(numbers):
            on_the_way = int(np.argmin(between[first, : len(numbers)] + 0.5 * from_here[: len(numbers)]))
            return int(numbers[on_the_way]), places[first]
        return int(numbers[first]), places[own[1]] if len(own) > 1 else None

    def _is_much_nearer(self, voxel: Voxel, mate: VoxelTeammate) -> bool:
        """Whether a place is so much nearer to a vehicle's goal than the vehicle that the goal is no longer its own."""
        if mate.goal is None:
            return False
        return math.dist(voxel, mate.goal) + self._params.much_nearer < math.dist(mate.voxel, mate.goal)

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
            best = self._best_view(search, spots, tried, weights, distances[places])
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
        self, search: _Search, spots: IndexArray, wanted: IndexArray, worth: FloatArray,
        distances: npt.NDArray[np.int32],
    ) -> int | None:  # fmt: skip
        fan, params, picture = self._fan, self._params, search.picture
        seen = count_seen(picture.states, fan.steps, fan.firsts, fan.ray_to, spots, wanted, worth, np.inf)
        ways = distances / UNIT
        cost = ways + params.at_once
        if self._afterwards is not None:
            here = np.array(np.unravel_index(search.start, picture.states.shape))
            straight = float(np.linalg.norm(self._afterwards - here))
            cost += params.onward * np.maximum(0.0, ways + np.linalg.norm(spots - self._afterwards, axis=1) - straight)
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


def _goals(teammates: list[VoxelTeammate]) -> list[VoxelTeammate]:
    """Those that go for something."""
    return [mate for mate in teammates if mate.goal is not None]


def _voxel(place: IndexArray) -> Voxel:
    column, row, layer = place.tolist()
    return (column, row, layer)
