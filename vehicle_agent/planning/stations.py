"""Stations: decentralised static coverage in which vehicles agree on places by words and then fly there.

Each vehicle claims the station where it will stay. In turn, whenever it is asked, it proposes to itself places near
its station, places over ground that nobody would see, and keeps the one whose view adds most to what the teammates'
claimed stations see, all predicted on the team's map. That is best response in a game whose potential is the team's
coverage (wonderful-life utility), so every change helps the team; Gumbel noise on the gains, cooling to none,
makes it log-linear learning (Marden and Shamma 2012), which leaves poor equilibria before they freeze.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.visibility import best_view, eyes_in_cells, mark_seen
from vehicle_agent.planning.frontier_travel import bearing_word
from vehicle_agent.planning.ground_estimate import GroundEstimate
from vehicle_agent.planning.interface import Decision, Finished, Observation, Situation, Wait, Waypoint
from vehicle_agent.planning.settling import Settling, SettlingParams
from vehicle_agent.planning.station_leg import leg_to_station

NEAR = 0.05
"""A vehicle within this share of a leg's reach is on its station."""


@dataclass(frozen=True, slots=True)
class StationsParams(SettlingParams):
    """How stations over ground are chosen, beyond what all stations have.

    Attributes
    ----------
    view_cells
        Range in cells of the coarse map on which heated proposals are compared.
    dear_way
        Cells of gain that a metre of way is worth while heated.
    refresh
        Decisions between looks at a growing map.
    """

    view_cells: float = 12.5
    dear_way: float = 0.0
    refresh: int = 5

    def __post_init__(self) -> None:
        SettlingParams.__post_init__(self)
        if self.refresh < 1 or not self.view_cells > 0.0:
            raise ValueError("refresh must be at least 1, view_cells must be positive")


class Stations:
    """One vehicle's part in the team's stations."""

    def __init__(self, rng: np.random.Generator, params: StationsParams | None = None) -> None:
        self._params = params or StationsParams()
        self._rng = rng
        self._coarse: GroundEstimate | None = None
        self._fine: GroundEstimate | None = None
        self._station: FloatArray | None = None
        self._settling = Settling(self._params)
        self._refused: list[FloatArray] = []
        self._known = -1
        self._seen: tuple[list[Point], BoolArray] | None = None

    def tell(self, observation: Observation) -> None:
        """Nothing is learned from measurements beyond the map."""

    def ask(self, situation: Situation) -> Decision:
        estimate = self._estimate_for(situation)
        if self._station is None:
            self._station = np.array(situation.position_enu_m)
        if self._settling.looks_on:
            self._revise(situation, estimate, self._station)
        self._settling.decisions += 1
        return self._way(situation, self._station)

    def _estimate_for(self, situation: Situation) -> GroundEstimate:
        """The estimate to compare places on: coarse while heated, the map's own cells after."""
        grid, params = situation.team_map.grid, self._params
        if self._coarse is None:
            block = max(1, round(situation.range_m / (params.view_cells * grid.cell_m)))
            self._coarse = GroundEstimate(grid, situation.area_cells, block)
        if self._settling.meet(situation.teammates):
            self._seen = None
        estimate = self._coarse
        if self._settling.is_cold:
            if self._fine is None:
                self._fine = GroundEstimate(grid, situation.area_cells, 1)
                self._known = -1
            estimate = self._fine
        elif self._fine is not None:
            self._fine, self._known = None, -1
        if self._known < 0 or self._settling.decisions % params.refresh == 0:
            known = int(situation.team_map.observed.sum())
            if known != self._known:
                self._known, self._seen = known, None
                self._settling.look_again()
                estimate.take(situation.team_map)
        return estimate

    def _revise(self, situation: Situation, estimate: GroundEstimate, station: FloatArray) -> None:
        """Move the own station to the proposal of the greatest noisy gain."""
        params = self._params
        wanted = estimate.weights * ~self._seen_by_teammates(situation, estimate)
        proposals = self._admissible(situation, estimate, self._proposals(situation, estimate, station, wanted))
        eyes = eyes_in_cells(estimate.grid, proposals)
        cooled = self._settling.cooled
        bonuses = np.zeros(len(proposals))
        if cooled < 1.0:
            whole_view = math.pi * (situation.range_m / situation.team_map.grid.cell_m) ** 2
            noise = params.heat * whole_view * (1.0 - cooled)
            away_m = np.linalg.norm(proposals - np.array(situation.position_enu_m), axis=1)
            bonuses = noise * self._rng.gumbel(size=len(proposals)) - params.dear_way * away_m
        best, gain, own_gain = best_view(
            estimate.elevation_m, eyes, estimate.grid.cell_m, situation.range_m, wanted, bonuses
        )
        if cooled >= 1.0 and gain < own_gain + 0.5:
            self._settling.found(better=False)
        elif best != 0:
            self._station = proposals[best]
            self._settling.found(better=True)

    def _seen_by_teammates(self, situation: Situation, estimate: GroundEstimate) -> BoolArray:
        """What the teammates' stations see: (columns, rows) bool of the estimate."""
        places = self._places(situation)
        if self._seen is None or self._seen[0] != places:
            eyes = eyes_in_cells(estimate.grid, np.array(places).reshape(-1, 3))
            seen = mark_seen(estimate.elevation_m, eyes, estimate.grid.cell_m, situation.range_m)
            self._seen = (places, seen)
        return self._seen[1]

    def _places(self, situation: Situation) -> list[Point]:
        return self._settling.places(situation.teammates, NEAR * situation.constraints.reach_m)

    def _proposals(
        self, situation: Situation, estimate: GroundEstimate, station: FloatArray, wanted: FloatArray
    ) -> FloatArray:
        """The present station first, then places around it and places over ground that nobody would see: (M, 3)."""
        params, rng = self._params, self._rng
        stretch = np.array((1.0, 1.0, 0.5)) * situation.range_m
        scales = params.local_scales[:-1] if self._settling.is_cold else params.local_scales
        around = [rng.standard_normal((params.per_scale, 3)) * stretch * scale for scale in scales]
        choices = [station[None, :], *(station + offsets for offsets in around)]
        unseen = np.flatnonzero(wanted)
        count = params.far // 3 if self._settling.is_cold else params.far
        if count and len(unseen):
            far = np.empty((count, 3))
            middles = estimate.grid.centres_of(rng.choice(unseen, count))
            far[:, :2] = middles + rng.standard_normal((count, 2)) * 0.5 * situation.range_m
            limits = situation.constraints
            lowest_m, highest_m = limits.min_above_m, min(limits.max_above_m, 0.6 * situation.range_m)
            far[:, 2] = estimate.ground_m(far) + rng.uniform(lowest_m, max(lowest_m, highest_m), count)
            choices.append(far)
        return np.concatenate(choices)

    def _admissible(self, situation: Situation, estimate: GroundEstimate, places: FloatArray) -> FloatArray:
        """Proposals moved into the area and its height band; those too near to teammates' stations left out."""
        limits, grid = situation.constraints, situation.team_map.grid
        margin_m = 0.5 * grid.cell_m
        places = places.copy()
        places[:, 0] = places[:, 0].clip(grid.west_m + margin_m, grid.east_m - margin_m)
        places[:, 1] = places[:, 1].clip(grid.south_m + margin_m, grid.north_m - margin_m)
        ground_m = estimate.ground_m(places)
        known_m = limits.grounds_m(places)
        ground_m = np.where(np.isnan(known_m), ground_m, known_m)
        lowest_m = ground_m + limits.min_above_m
        places[:, 2] = places[:, 2].clip(lowest_m, ground_m + limits.max_above_m)
        keep = lowest_m <= limits.ceiling_m
        places[:, 2] = np.minimum(places[:, 2], limits.ceiling_m)
        if situation.teammates:
            theirs = np.array(self._places(situation))
            apart_m = np.linalg.norm(places[:, None, :] - theirs[None, :, :], axis=2)
            keep &= (apart_m >= 1.05 * limits.separation_m).all(axis=1)
        for refused in self._refused:
            keep &= np.linalg.norm(places - refused, axis=1) > 2.0 * NEAR * limits.reach_m
        keep[0] = True
        return places[keep]

    def _way(self, situation: Situation, station: FloatArray) -> Decision:
        here = situation.position_enu_m
        there = (float(station[0]), float(station[1]), float(station[2]))
        away_m = math.dist(here, there)
        near_m = NEAR * situation.constraints.reach_m
        self._settling.count(situation.index, here, there, situation.teammates, near_m)
        if self._settling.is_done:
            return Finished("covered: nobody knows a place from where the team would see more")
        if away_m > near_m and self._settling.is_stuck:
            self._refused.append(station)
            self._station = np.array(here)
            self._settling.arrive()
            self._settling.look_again()
            return Wait("its station cannot be reached: looking for another from here")
        if away_m <= near_m:
            self._settling.arrive()
            looking = not self._settling.is_cold or self._settling.looks_on
            return Wait("on its station, looking for a better one" if looking else "on its station")
        end = leg_to_station(here, there, situation.constraints)
        if end is None:
            return Wait("the way to its station is taken")
        return Waypoint(end, f"station {away_m:.0f} m {bearing_word(here[:2], there[:2])}", there, away_m, (there,))
