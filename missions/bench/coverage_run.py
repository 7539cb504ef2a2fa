"""One static coverage in iterations: every vehicle moves at most one step, sees, tells; all know what was told.

Vehicles decide one after the other within an iteration, as an asynchronous team does; nobody knows anything of the
terrain that nobody has seen.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from missions.bench.coverage_kernels import count_watchers, nearest_m, shares, unmarked
from vehicle_agent.domain.elevation import CellObservations, ElevationMap
from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.grid import Grid, IndexArray
from vehicle_agent.domain.paths import assumed_surface
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.visibility import eye_in_cells, seen_cells
from vehicle_agent.planning.constraints import Constraints, Reservation
from vehicle_agent.planning.interface import Finished, Observation, Planner, Situation, Teammate, Waypoint

SHADOW_RINGS = 2
STEEPEST_SLOPE = 2.0
MARGIN_M = 0.15
"""Heights are planned on a map in decimetres, with a tolerance of half of one; the limits themselves hold."""


@dataclass(frozen=True, slots=True)
class CoverageTeam:
    """What the vehicles of the bench can do.

    Attributes
    ----------
    range_m
        Sensing distance d_max.
    step_m
        Longest way per iteration, in three dimensions.
    min_above_m
        Least height above ground.
    ceiling_m
        Highest ENU z.
    separation_m
        Between any two vehicles.
    """

    range_m: float = 25.0
    step_m: float = 2.0
    min_above_m: float = 3.0
    ceiling_m: float = 50.0
    separation_m: float = 2.0


@dataclass(slots=True)
class CoverageRun:
    """What one run left behind.

    Attributes
    ----------
    positions_enu_m : (T, N, 3) float64, after each iteration, the start first; T is less than asked where all settled.
    covered_fraction : (T,) float64, share of the surface that somebody saw from there.
    ask_ms : planning time of every decision, milliseconds.
    min_separation_m : smallest distance between two vehicles at the end of any move.
    """

    positions_enu_m: FloatArray
    covered_fraction: FloatArray
    ask_ms: list[float]
    min_separation_m: float


def cover(
    grid: Grid,
    elevation_m: FloatArray,
    starts_enu_m: FloatArray,
    planners: Sequence[Planner],
    team: CoverageTeam,
    iterations: int,
) -> CoverageRun:
    """Run one team over one surface.

    Parameters
    ----------
    elevation_m : (columns, rows) float64, the true surface, ENU z.
    starts_enu_m : (N, 3) float64, admissible places.
    planners : one per vehicle.
    """
    return _Coverage(grid, elevation_m, starts_enu_m, planners, team).run(iterations)


class _Coverage:
    def __init__(
        self,
        grid: Grid,
        elevation_m: FloatArray,
        starts_enu_m: FloatArray,
        planners: Sequence[Planner],
        team: CoverageTeam,
    ) -> None:
        self._grid, self._truth, self._team, self._planners = grid, elevation_m, team, planners
        self._area: BoolArray = np.ones(grid.shape, dtype=np.bool_)
        self._map = ElevationMap(grid)
        self._watchers = np.zeros(grid.cells, dtype=np.int64)
        self._observed: BoolArray = np.zeros(grid.cells, dtype=np.bool_)
        self._views: list[IndexArray] = []
        self._positions: list[Point] = [(float(e), float(n), float(u)) for e, n, u in starts_enu_m]
        self._places = np.array(starts_enu_m, dtype=np.float64)
        self._told = [Teammate(index, position) for index, position in enumerate(self._positions)]
        self._ask_ms: list[float] = []
        self._nearest_m = math.inf
        self._iteration = 0
        self._surface: FloatArray = np.full(grid.shape, np.nan)
        self._map_changed = False
        for position in self._positions:
            self._views.append(self._look(position))
            count_watchers(self._watchers, self._views[-1], 1)

    def run(self, iterations: int) -> CoverageRun:
        track = [list(self._positions)]
        curve = [self._covered()]
        for _ in range(iterations):
            self._iteration += 1
            if self._map_changed:
                self._surface = assumed_surface(
                    self._map.elevation_m, self._area, self._grid.cell_m, SHADOW_RINGS, STEEPEST_SLOPE
                )
                self._map_changed = False
            settled = [self._move(index) for index in range(len(self._planners))]
            track.append(list(self._positions))
            curve.append(self._covered())
            if all(settled):
                break
        return CoverageRun(np.array(track), np.array(curve), self._ask_ms, self._nearest_m)

    def _covered(self) -> float:
        return float(np.count_nonzero(self._watchers)) / self._watchers.size

    def _look(self, position: Point) -> IndexArray:
        """What is seen from a place; what of it nobody had seen goes into the team's map."""
        seen = seen_cells(self._truth, eye_in_cells(self._grid, position), self._grid.cell_m, self._team.range_m)
        new = unmarked(self._observed, seen)
        if len(new):
            self._observed[new] = True
            heights_dm = np.round(self._truth.ravel()[new] * 10.0).astype(np.int32)
            self._map.observe(0, CellObservations(new, heights_dm, np.full(len(new), self._iteration, dtype=np.int64)))
            self._map_changed = True
        return seen

    def _move(self, index: int) -> bool:
        """One decision and its step; True when the planner has nothing left to do."""
        here, team = self._positions[index], self._team
        mates = (*self._told[:index], *self._told[index + 1 :])
        near_m = 4.0 * team.step_m + team.separation_m
        near = [mate for mate in mates if math.dist(here, mate.position_enu_m) <= near_m]
        constraints = Constraints(
            self._grid,
            self._surface,
            team.min_above_m + MARGIN_M,
            team.ceiling_m,
            team.step_m,
            team.separation_m,
            tuple(Reservation(mate.position_enu_m, mate.position_enu_m, mate.index) for mate in near),
            ceiling_m=team.ceiling_m - MARGIN_M,
        )
        situation = Situation(index, here, self._map, self._area, team.range_m, constraints, mates)
        objective = float(shares(self._watchers, self._views[index]).sum())  # eq. 1, from the views that were told
        began_s = time.perf_counter()
        self._planners[index].tell(Observation(here, objective))
        decision = self._planners[index].ask(situation)
        self._ask_ms.append(1e3 * (time.perf_counter() - began_s))
        if isinstance(decision, Waypoint):
            self._go(index, decision.position_enu_m)
            self._told[index] = Teammate(index, self._positions[index], decision.goal_enu_m)
        return isinstance(decision, Finished)

    def _go(self, index: int, end: Point) -> None:
        here = self._positions[index]
        if end == here:
            return
        part = min(1.0, self._team.step_m / max(math.dist(here, end), 1e-9))
        east, north, up = (h + part * (e - h) for h, e in zip(here, end, strict=True))
        place = self._positions[index] = (east, north, up)
        count_watchers(self._watchers, self._views[index], -1)
        self._views[index] = self._look(place)
        count_watchers(self._watchers, self._views[index], 1)
        self._places[index] = place
        self._nearest_m = min(self._nearest_m, nearest_m(self._places, index))
