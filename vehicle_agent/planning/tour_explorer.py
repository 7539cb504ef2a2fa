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


@dataclass(frozen=True, slots=True)
class ToursParams:
    """How the ground is shared out.

    Attributes
    ----------
    patch_width
        Width of a patch in sensing ranges.
    service
        Extra way that a wholly unseen patch costs, in patch widths.
    small_share
        A patch with at most this share unseen is visited at its nearest unseen cell, a fuller one at its middle.
    remnant_share, seen_beside
        A patch with less than this share unseen is no stop of its own when a stop lies within `seen_beside` sensing
        ranges of it: whoever goes there sees it in passing.
    patience
        Decisions for a patch without seeing more of it or coming nearer before it is given up.
    keep_for
        Decisions after which tours are computed anew in any case.
    passes
        Most rounds of improvement of the tours.
    way_back
        Weight of the way home in a tour.
    """

    patch_width: float = 1.5
    service: float = 0.3
    small_share: float = 0.5
    remnant_share: float = 0.35
    seen_beside: float = 0.85
    patience: int = 6
    keep_for: int = 8
    passes: int = 30
    way_back: float = 1.0


class TourExplorer:
    """One vehicle's part in the team's tours."""

    def __init__(self, home_en_m: tuple[float, float], range_m: float, params: ToursParams | None = None) -> None:
        self._params = params or ToursParams()
        self._home_en_m = home_en_m
        self._range_m = range_m
        self._division: PatchDivision | None = None
        self._tour_en_m: list[tuple[float, float]] = []
        self._patch: int | None = None
        self._decisions = 0
        self._given_up: set[int] = set()
        self._progress = (math.inf, math.inf)
        self._fruitless = 0

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
        if self._is_fruitless(situation, target):
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
        return not (situation.area_cells[cells] & ~situation.team_map.observed[cells]).any()

    def _share_out(self, situation: Situation, division: PatchDivision) -> bool:
        """Compute the team's tours and take the own one; False when nothing is left."""
        params = self._params
        patches = division.with_unseen(situation.area_cells & ~situation.team_map.observed)
        keep = ~np.isin(patches.numbers, list(self._given_up))
        patches = patches.only(keep)
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
        ends = np.tile(np.array(self._home_en_m), (len(team), 1))
        tours, lengths = share_out(starts, ends, patches.centroids_en_m, service, params.way_back, params.passes)
        mine = [index for index, _ in team].index(situation.index)
        own = tours[mine, : lengths[mine]]
        if len(own) == 0:
            own = _nearest(patches.centroids_en_m, situation.position_enu_m)
        number = int(patches.numbers[own[0]])
        if number != self._patch:
            self._patch, self._progress, self._fruitless = number, (math.inf, math.inf), 0
        self._tour_en_m = [(float(e), float(n)) for e, n in patches.centroids_en_m[own[1:]]]
        return True

    def _target_in(self, situation: Situation, division: PatchDivision, patch: int) -> tuple[float, float]:
        """Where to go for a patch: the middle of its unseen cells, or the nearest when few are left."""
        columns, rows = division.cells_of(patch)
        unseen = situation.area_cells[columns, rows] & ~situation.team_map.observed[columns, rows]
        across, along = np.nonzero(unseen)
        grid = situation.team_map.grid
        points = grid.centres_of((across + columns.start) * grid.rows + along + rows.start)
        here = np.array(situation.position_enu_m[:2])
        if len(points) > self._params.small_share * unseen.size:
            middle = points.mean(axis=0)
            return (float(middle[0]), float(middle[1]))
        nearest = points[int(np.argmin(np.hypot(*(points - here).T)))]
        return (float(nearest[0]), float(nearest[1]))

    def _is_fruitless(self, situation: Situation, target: tuple[float, float]) -> bool:
        """Count decisions that brought the vehicle no nearer to the patch and showed no more of it."""
        assert self._patch is not None
        assert self._division is not None
        cells = self._division.cells_of(self._patch)
        unseen = float((situation.area_cells[cells] & ~situation.team_map.observed[cells]).sum())
        away_m = way_length_m(situation.position_enu_m, target)
        best_unseen, best_away_m = self._progress
        if unseen < best_unseen or away_m < best_away_m - 0.25 * situation.team_map.grid.cell_m:
            self._progress = (min(unseen, best_unseen), min(away_m, best_away_m) if unseen == best_unseen else away_m)
            self._fruitless = 0
            return False
        self._fruitless += 1
        return self._fruitless >= self._params.patience


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
