"""One exploration in steps: every vehicle moves at most one step, sees, tells, until the surface is known.

Vehicles decide one after the other within a step, each knowing what has been told so far, as an asynchronous team
does; nobody knows anything of the terrain that nobody has seen.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vehicle_agent.behaviour.goal_claim import told_lanes
from vehicle_agent.behaviour.units import to_centimetres
from vehicle_agent.domain.clearance import leg_clearances
from vehicle_agent.domain.elevation import CellObservations, ElevationMap
from vehicle_agent.domain.frames import FloatArray, Point, as_array
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.paths import assumed_surface
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.sensing import visible_surface
from vehicle_agent.domain.shadows import guess_hidden_ground
from vehicle_agent.planning.constraints import Constraints, Reservation
from vehicle_agent.planning.interface import Observation, Planner, Situation, Teammate, Waypoint
from vehicle_agent.wire.cells import pack_cells
from vehicle_agent.wire.codec import Codec
from vehicle_agent.wire.messages import Claim, DeltaRecord, MapDelta

DONE_AT = 0.995
SHADOW_RINGS = 2
STEEPEST_SLOPE = 2.0
STEEP_LEG_STRETCH = 5.0
"""Planned legs may be steep: a vehicle flies the first step of them."""


@dataclass(frozen=True, slots=True)
class TeamParams:
    """What the vehicles of a bench can do.

    Attributes
    ----------
    range_m
        Sensing distance.
    step_m
        Longest way per step, in three dimensions.
    min_above_m, max_above_m
        Height band above the ground.
    separation_m
        Between any two vehicles.
    """

    range_m: float = 8.0
    step_m: float = 2.0
    min_above_m: float = 3.0
    max_above_m: float = 8.0
    separation_m: float = 2.0


@dataclass(slots=True)
class ExplorationRun:
    """What one run left behind.

    Attributes
    ----------
    positions_enu_m : (T, N, 3) float64, where the vehicles were after each step, the start first.
    observed_fraction : (T,) float64, share of the reachable surface seen by then.
    ask_ms : planning time of every decision, milliseconds.
    bytes_sent : by all vehicles together.
    overlap : mean number of vehicles that saw a cell, less one.
    finished : whether the surface was known before the steps ran out.
    lowest_m : least height above the true ground along what was flown, metres.
    """

    positions_enu_m: FloatArray
    observed_fraction: FloatArray
    ask_ms: list[float]
    bytes_sent: int
    overlap: float
    finished: bool
    lowest_m: float

    @property
    def steps(self) -> int:
        return len(self.positions_enu_m) - 1


def explore(
    grid: Grid,
    elevation_m: FloatArray,
    starts_en_m: Sequence[tuple[float, float]],
    planners: Sequence[Planner],
    team: TeamParams,
    max_steps: int,
) -> ExplorationRun:
    """Run one team over one surface.

    Parameters
    ----------
    elevation_m : (columns, rows) float64, the true surface, ENU z.
    starts_en_m : where each vehicle starts, at the lowest height allowed.
    planners : one per vehicle.
    max_steps : when to give up.
    """
    return _Exploration(grid, elevation_m, starts_en_m, planners, team).run(max_steps)


class _Exploration:
    def __init__(
        self,
        grid: Grid,
        elevation_m: FloatArray,
        starts_en_m: Sequence[tuple[float, float]],
        planners: Sequence[Planner],
        team: TeamParams,
    ) -> None:
        self._grid, self._truth, self._team, self._planners = grid, elevation_m, team, planners
        self._area: BoolArray = np.ones(grid.shape, dtype=np.bool_)
        self._map = ElevationMap(grid)
        self._seen_by = np.zeros((len(planners), *grid.shape), dtype=np.bool_)
        self._hidden_guess_m = np.full((len(planners), *grid.shape), np.inf)
        self._positions = [self._above(*start) for start in starts_en_m]
        self._goals: list[Waypoint | None] = [None] * len(planners)
        self._ask_ms: list[float] = []
        self._bytes = 0
        self._codec = Codec()
        self._step = 0
        self._lowest_m = math.inf

    def run(self, max_steps: int) -> ExplorationRun:
        track = [list(self._positions)]
        self._observe()
        curve = [self._share()]
        while curve[-1] < DONE_AT and self._step < max_steps:
            self._step += 1
            surface = assumed_surface(
                self._map.elevation_m, self._area, self._grid.cell_m, SHADOW_RINGS, STEEPEST_SLOPE
            )
            # The map stays as it is within a step: all work on it is done before anybody decides.
            everyone = range(len(self._planners))
            surfaces = [self._to_stay_clear_of(index, surface) for index in everyone]
            objectives = [self._map.first_observer_share(index) for index in everyone]
            for index in everyone:
                self._move(index, surfaces[index], objectives[index])
            self._observe()
            track.append(list(self._positions))
            curve.append(self._share())
        seen = self._seen_by.any(axis=0)
        return ExplorationRun(
            np.array(track),
            np.array(curve),
            self._ask_ms,
            self._bytes,
            float(self._seen_by.sum(axis=0)[seen].mean()) - 1.0,
            curve[-1] >= DONE_AT,
            self._lowest_m,
        )

    def _above(self, east_m: float, north_m: float) -> Point:
        column, row = self._grid.cell_of(east_m, north_m)
        around = self._truth[max(0, column - 1) : column + 2, max(0, row - 1) : row + 2]
        return (east_m, north_m, float(around.max()) + self._team.min_above_m)

    def _share(self) -> float:
        return float(self._map.observed.mean())

    def _observe(self) -> None:
        for index, position in enumerate(self._positions):
            cells = visible_surface(self._grid, self._truth, position, self._team.range_m)
            self._seen_by[index].ravel()[cells] = True
            observed = CellObservations(
                cells,
                np.round(self._truth.ravel()[cells] * 10.0).astype(np.int32),
                np.full(len(cells), self._step, dtype=np.int64),
            )
            changed = self._map.observe(index, observed)
            if len(changed):
                record = DeltaRecord("v", 0, self._step, pack_cells(changed))
                self._say(MapDelta(sender="v", boot_id=0, sequence=0, stamp_ms=self._step, record=record))
        known = self._map.elevation_m
        for (east_m, north_m, up_m), hidden_guess_m in zip(self._positions, self._hidden_guess_m, strict=True):
            u = (east_m - self._grid.west_m) / self._grid.cell_m - 0.5
            v = (north_m - self._grid.south_m) / self._grid.cell_m - 0.5
            guess_hidden_ground(known, u, v, up_m, self._grid.cell_m, self._team.range_m, hidden_guess_m)

    def _to_stay_clear_of(self, index: int, surface: FloatArray) -> FloatArray:
        """The team's surface, lower where this vehicle saw that the ground it does not know must be lower."""
        hidden = ~self._map.observed & np.isfinite(self._hidden_guess_m[index])
        return np.where(hidden, np.fmin(surface, self._hidden_guess_m[index]), surface)

    def _say(self, message: MapDelta | Claim) -> None:
        self._bytes += len(self._codec.encode(message))

    def _move(self, index: int, surface: FloatArray, objective: float) -> None:
        here, team = self._positions[index], self._team
        others = [other for other in range(len(self._planners)) if other != index]
        constraints = Constraints(
            self._grid,
            surface,
            team.min_above_m,
            team.max_above_m,
            team.step_m,
            team.separation_m,
            tuple(Reservation(self._positions[other], self._positions[other], other) for other in others),
            STEEP_LEG_STRETCH,
        )
        situation = Situation(
            index, here, self._map, self._area, team.range_m, constraints, tuple(map(self._teammate, others))
        )
        began_s = time.perf_counter()
        self._planners[index].tell(Observation(here, objective))
        decision = self._planners[index].ask(situation)
        self._ask_ms.append(1e3 * (time.perf_counter() - began_s))
        if not isinstance(decision, Waypoint):
            return
        self._claim(decision, self._goals[index])
        self._goals[index] = decision
        end = decision.position_enu_m
        part = min(1.0, team.step_m / max(math.dist(here, end), 1e-9))
        east, north, up = (h + part * (e - h) for h, e in zip(here, end, strict=True))
        self._positions[index] = (east, north, up)
        grid = self._grid
        flown_m = leg_clearances(
            self._truth, grid.west_m, grid.south_m, grid.cell_m, as_array(here), np.array([self._positions[index]])
        )
        self._lowest_m = min(self._lowest_m, float(flown_m[0]))

    def _claim(self, decision: Waypoint, before: Waypoint | None) -> None:
        """Tell the team of a goal, a tour or lanes that are not those told before."""
        told = (decision.goal_enu_m, decision.tour, decision.lanes)
        same = before is not None and (before.goal_enu_m, before.tour, before.lanes) == told
        if decision.goal_enu_m is None or same:
            return
        number, patches = (decision.tour.number, decision.tour.patches) if decision.tour else (0, ())
        self._say(
            Claim(
                sender="v", boot_id=0, sequence=0, stamp_ms=0, active=True,
                goal_cm=to_centimetres(decision.goal_enu_m), cost_m=round(decision.goal_cost_m),
                tour_number=number, tour=patches, lanes=told_lanes(decision.lanes),
            )
        )  # fmt: skip

    def _teammate(self, index: int) -> Teammate:
        goal = self._goals[index]
        if goal is None or goal.goal_enu_m is None:
            return Teammate(index, self._positions[index])
        return Teammate(index, self._positions[index], goal.goal_enu_m, goal.goal_cost_m, goal.tour, goal.lanes)
