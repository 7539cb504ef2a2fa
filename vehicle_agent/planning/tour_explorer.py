"""Tours: decentralised exploration in which the team shares the unseen ground out as tours of equal length.

The unseen ground is divided into patches as wide as a sensor sweeps. Each vehicle, from the team's map and its
teammates' positions alone, computes the whole team's tours (the longest made as short as it can) and flies its own.
Because the computation has no dice, vehicles with the same knowledge agree; where knowledge lags, a teammate's claim
settles who goes. Tours are computed anew when the patch ahead is seen, when a teammate takes it, or after a while.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.tours import share_out
from vehicle_agent.planning.frontier_travel import bearing_word
from vehicle_agent.planning.interface import Decision, Finished, Observation, Situation, Wait, Waypoint
from vehicle_agent.planning.patches import PatchDivision, Patches
from vehicle_agent.planning.travel import next_leg, way_length_m

EastNorth = tuple[float, float]


@dataclass(frozen=True, slots=True)
class ToursParams:
    """How the ground is shared out.

    Attributes
    ----------
    patch_width
        Width of a patch in sensing ranges.
    service
        Extra way that a wholly unseen patch costs, in patch widths.
    look_closer_after
        Fruitless decisions after which a patch is approached at its nearest unseen cell, no more at the middle of them.
    remnant_share, seen_beside
        A patch with less than this share unseen is no stop of its own when a stop lies within `seen_beside` sensing
        ranges of it: whoever goes there sees it in passing.
    patience
        Fruitless decisions, neither nearer nor seeing more, after which a patch is given up; when nothing else is left
        those given up are tried once more, since what stood in the way may have gone.
    keep_for
        Decisions after which tours are computed anew in any case.
    passes
        Most rounds of improvement of the tours.
    way_back
        Weight of the way home in a tour, for a vehicle that has a home.
    """

    patch_width: float = 1.5
    service: float = 0.3
    look_closer_after: int = 2
    remnant_share: float = 0.35
    seen_beside: float = 0.85
    patience: int = 6
    keep_for: int = 3
    passes: int = 30
    way_back: float = 1.0


TO_AND_FRO = 4
"""A patch may be approached again from afar for so many times the patience."""


@dataclass(slots=True)
class _Effort:
    """What has been tried for one patch.

    Attributes
    ----------
    unseen, nearest_m
        The least so far.
    last_m
        Distance at the last decision.
    fruitless
        Decisions in a row that brought the vehicle no nearer and showed no more of it.
    without_best
        Decisions since the last that was better than all before: going to and fro comes to an end by it.
    """

    unseen: float = math.inf
    nearest_m: float = math.inf
    last_m: float = math.inf
    fruitless: int = 0
    without_best: int = 0

    def note(self, unseen: int, away_m: float, step_m: float) -> None:
        more_seen = unseen < self.unseen
        self.fruitless = 0 if more_seen or away_m < self.last_m - step_m else self.fruitless + 1
        self.without_best = 0 if more_seen or away_m < self.nearest_m - step_m else self.without_best + 1
        self.unseen, self.nearest_m = min(unseen, self.unseen), min(away_m, self.nearest_m)
        self.last_m = away_m


class TourExplorer:
    """One vehicle's part in the team's tours."""

    def __init__(self, home_en_m: EastNorth | None, range_m: float, params: ToursParams | None = None) -> None:
        self._params = params or ToursParams()
        self._home_en_m = home_en_m
        self._range_m = range_m
        self._division: PatchDivision | None = None
        self._tour_en_m: list[EastNorth] = []
        self._patch: int | None = None
        self._unseen_when_chosen = 0
        self._decisions = 0
        self._given_up: set[int] = set()
        self._tried_again = False
        self._efforts: dict[int, _Effort] = {}

    def tell(self, observation: Observation) -> None:
        """Nothing is learned from measurements beyond the map."""

    def ask(self, situation: Situation) -> Decision:
        if self._division is None:
            width_m = self._params.patch_width * self._range_m
            self._division = PatchDivision(situation.team_map.grid, situation.area_cells, width_m)
        self._decisions += 1
        if self._must_share_out(situation, self._division) and not self._share_out(situation, self._division):
            return Finished("nothing unseen is left within reach")
        assert self._patch is not None
        target = self._target_in(situation, self._division, self._patch)
        if self._is_fruitless(situation, self._division, self._patch, target):
            self._given_up.add(self._patch)
            self._patch = None
            return Wait("gave up a patch: no way to see the rest of it")
        end = next_leg(situation.position_enu_m, target, situation.constraints)
        here = situation.position_enu_m
        away_m = way_length_m(here, target)
        what = f"unseen patch {away_m:.0f} m {bearing_word(here[:2], target)}"
        if end is None:
            return Wait(f"{what}: the way is taken")
        route = [(target[0], target[1], end[2]), *((e, n, end[2]) for e, n in self._tour_en_m)]
        why = f"{what}, first of {len(self._tour_en_m) + 1} in its tour"
        return Waypoint(end, why, route[0], away_m, tuple(route[:12]))

    def _must_share_out(self, situation: Situation, division: PatchDivision) -> bool:
        if self._patch is None or self._decisions >= self._params.keep_for:
            return True
        cells = division.cells_of(self._patch)
        unseen = int((situation.area_cells[cells] & ~situation.team_map.observed[cells]).sum())
        return unseen == 0 or unseen < self._params.remnant_share * self._unseen_when_chosen

    def _share_out(self, situation: Situation, division: PatchDivision) -> bool:
        """Compute the team's tours and take the own one; False when nothing is left."""
        params = self._params
        patches = division.with_unseen(situation.area_cells & ~situation.team_map.observed)
        untried = ~np.isin(patches.numbers, list(self._given_up))
        if not untried.any() and not self._tried_again:
            self._tried_again = True
            self._given_up.clear()
            self._efforts.clear()
            untried[:] = True
        patches = patches.only(untried)
        whole = division.size_cells[0] * division.size_cells[1]
        patches = patches.only(_stops(patches, params.remnant_share * whole, params.seen_beside * self._range_m))
        if len(patches) == 0:
            return False
        self._decisions = 0
        team = sorted(
            [(situation.index, situation.position_enu_m), *((t.index, t.position_enu_m) for t in situation.teammates)]
        )
        starts = np.array([position[:2] for _, position in team])
        width_m = params.patch_width * self._range_m
        service = params.service * width_m * np.minimum(1.0, patches.unseen / whole)
        ends = starts if self._home_en_m is None else np.tile(np.array(self._home_en_m), (len(team), 1))
        way_back = 0.0 if self._home_en_m is None else params.way_back
        tours, lengths = share_out(starts, ends, patches.centroids_en_m, service, way_back, params.passes)
        mine = [index for index, _ in team].index(situation.index)
        own = tours[mine, : lengths[mine]]
        if len(own) == 0:
            own = _nearest(patches.centroids_en_m, situation.position_enu_m)
        number = int(patches.numbers[own[0]])
        self._patch = number
        self._unseen_when_chosen = int(patches.unseen[own[0]])
        self._tour_en_m = [(float(e), float(n)) for e, n in patches.centroids_en_m[own[1:]]]
        return True

    def _target_in(self, situation: Situation, division: PatchDivision, patch: int) -> EastNorth:
        """Where to go for a patch: the middle of its unseen cells, or the nearest when that has not helped."""
        columns, rows = division.cells_of(patch)
        unseen = situation.area_cells[columns, rows] & ~situation.team_map.observed[columns, rows]
        across, along = np.nonzero(unseen)
        grid = situation.team_map.grid
        points = grid.centres_of((across + columns.start) * grid.rows + along + rows.start)
        here = np.array(situation.position_enu_m[:2])
        if self._efforts.get(patch, _Effort()).fruitless < self._params.look_closer_after:
            middle = points.mean(axis=0)
            return (float(middle[0]), float(middle[1]))
        nearest = points[int(np.argmin(np.hypot(*(points - here).T)))]
        return (float(nearest[0]), float(nearest[1]))

    def _is_fruitless(self, situation: Situation, division: PatchDivision, patch: int, target: EastNorth) -> bool:
        """Note a decision for a patch; True when too many brought the vehicle no nearer and showed no more of it."""
        cells = division.cells_of(patch)
        unseen = int((situation.area_cells[cells] & ~situation.team_map.observed[cells]).sum())
        away_m = way_length_m(situation.position_enu_m, target)
        effort = self._efforts.setdefault(patch, _Effort())
        effort.note(unseen, away_m, 0.25 * situation.team_map.grid.cell_m)
        return max(effort.fruitless, effort.without_best / TO_AND_FRO) >= self._params.patience


def _nearest(points_en_m: FloatArray, position_enu_m: Point) -> IndexArray:
    return np.array([np.argmin(np.hypot(*(points_en_m - np.array(position_enu_m[:2])).T))], dtype=np.int64)


def _stops(patches: Patches, remnant_cells: float, beside_m: float) -> BoolArray:
    """Which patches need a stop of their own, the fullest first: (P,) bool."""
    points = patches.centroids_en_m
    stops = np.zeros(len(patches), dtype=np.bool_)
    for index in np.argsort(-patches.unseen, kind="stable"):
        beside = np.hypot(*(points[stops] - points[index]).T) < beside_m
        stops[index] = patches.unseen[index] >= remnant_cells or not beside.any()
    return stops
