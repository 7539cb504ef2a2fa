"""Spread first, then cover: the team begins its coverage from a constrained Voronoi tessellation.

Renzaglia 2020, section 5.1: the little that is known of the surface beforehand, a few points, is enough to spread the
team well before anybody has seen anything. Every vehicle works the same places out by itself.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import linear_sum_assignment

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.planning.cvt import ApproximateSurface, TessellationParams, tessellate
from vehicle_agent.planning.frontier_travel import bearing_word
from vehicle_agent.planning.interface import Decision, Finished, Observation, Planner, Situation, Wait, Waypoint
from vehicle_agent.planning.station_leg import leg_to_station

NEAR = 0.05
"""A vehicle within this share of a leg's reach has arrived."""
PATIENCE = 25
"""Decisions without a way on after which a vehicle begins to cover from where it is."""


def spread_team(
    known_enu_m: FloatArray,
    grid: Grid,
    area_cells: BoolArray,
    starts_en_m: FloatArray,
    min_above_m: float,
    rng: np.random.Generator,
) -> FloatArray:
    """Where each vehicle begins to cover: generators of the tessellation, shared out for the least way in all.

    Parameters
    ----------
    known_enu_m : (n, 3) float64, the points of the surface that are known, inside the grid; at least one.
    area_cells : (columns, rows) bool; a generator outside moves to the nearest cell inside.
    starts_en_m : (N, 2) float64, where the vehicles are, east and north.
    min_above_m : height above the approximate surface, to which generators are lifted.

    Returns
    -------
    (N, 3) float64, ENU metres, in the order of the starts; the same for everybody with the same arguments.
    """
    surface = ApproximateSurface(known_enu_m, (grid.west_m, grid.south_m, grid.east_m, grid.north_m))
    places = tessellate(surface, len(starts_en_m), TessellationParams(), rng)
    middles = grid.centres_of(np.flatnonzero(area_cells))
    for place in places:
        away_m = np.abs(middles - place[:2]).max(axis=1)
        if away_m.min() > 0.5 * grid.cell_m:
            place[:2] = middles[int(np.argmin(np.linalg.norm(middles - place[:2], axis=1)))]
    places[:, 2] += min_above_m
    ways_m = np.linalg.norm(starts_en_m[:, None, :] - places[None, :, :2], axis=2)
    spread: FloatArray = places[linear_sum_assignment(ways_m)[1]]
    return spread


class SpreadFirst:
    """One vehicle's way to its first place, after which another planner goes on.

    Parameters
    ----------
    station_enu_m
        The place.
    coverer
        Who decides from there.
    """

    def __init__(self, station_enu_m: Point, coverer: Planner) -> None:
        self._station, self._coverer = station_enu_m, coverer
        self._held_up = 0
        self.arrived = False

    def tell(self, observation: Observation) -> None:
        if self.arrived:
            self._coverer.tell(observation)

    def ask(self, situation: Situation) -> Decision:
        if not self.arrived:
            decision = self._way(situation)
            if not isinstance(decision, Finished):
                return decision
            self.arrived = True
        return self._coverer.ask(situation)

    def _way(self, situation: Situation) -> Decision:
        """The next leg to the place, at whatever height the ground there allows."""
        here, there, limits = situation.position_enu_m, self._station, situation.constraints
        away_m = math.dist(here[:2], there[:2])
        if away_m <= NEAR * limits.reach_m or self._held_up >= PATIENCE:
            return Finished("at its first place")
        end = leg_to_station(here, there, limits)
        if end is None or math.dist(end[:2], there[:2]) >= away_m:
            self._held_up += 1
        if end is None:
            return Wait("the way to its first place is taken")
        why = f"first place {away_m:.0f} m {bearing_word(here[:2], there[:2])}, spread by what is known"
        return Waypoint(end, why, there, away_m, (there,))
