"""Sails lines over its part of the area first, then where the map is least certain: a survey that looks where it pays.

The first lines lie as far apart as leaves enough of the way for later. From what they found a relief is fitted; then
again and again the most telling way from here is worked out over this vehicle's share of what is uncertain, and a part
of it sailed. Vehicles share by a cut that leaves equal uncertainty on both sides, each from its own map alone.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.relief import Relief
from vehicle_agent.planning.interface import Decision, Finished, Teammate, Waypoint
from vehicle_agent.planning.mapping.infill import most_telling_way
from vehicle_agent.planning.mapping.interface import MappingSituation
from vehicle_agent.planning.mapping.survey_lines import Box, parallel_lines

MOST_SOUNDINGS = 350
"""Of more than these every n-th is left out, so that a decision stays quick."""


@dataclass(frozen=True, slots=True)
class SurveyParams:
    """How a survey is divided.

    Attributes
    ----------
    way_m
        What one vehicle can sail in all.
    lines_share
        Share of it for the first lines.
    widest_m
        Lines are no further apart than this.
    nodes
        Places over which ways are worked out, about so many.
    look_ahead_m, part_m
        Length of a way that is worked out, and what of it is sailed before the next.
    turn_m
        A detour is reckoned this much longer: what it costs to brake and turn.
    foreign_weight
        What variance in a teammate's share counts.
    """

    way_m: float
    lines_share: float = 0.5
    widest_m: float = 12.5
    nodes: int = 324
    look_ahead_m: float = 160.0
    part_m: float = 80.0
    turn_m: float = 4.0
    foreign_weight: float = 0.02

    def __post_init__(self) -> None:
        if not self.way_m > 0 or not self.part_m > 0 or not self.widest_m > 0:
            raise ValueError("way_m, part_m and widest_m must be positive")
        if not 0 < self.lines_share <= 1:
            raise ValueError("lines_share must be above 0 and at most 1")
        if self.nodes < 4:
            raise ValueError("nodes must be at least 4")


class Survey:
    """One vehicle's survey: told where it is and what is known, it says the corners of its way.

    Parameters
    ----------
    box
        The area.
    vehicle, vehicles
        This one's number and how many there are.
    """

    def __init__(self, box: Box, vehicle: int, vehicles: int, params: SurveyParams) -> None:
        self.params = params
        self._box, self._vehicle, self._vehicles = box, vehicle, vehicles
        edge_m = math.sqrt(box.area_m2 / params.nodes)
        columns = max(2, round((box.east_m - box.west_m) / edge_m))
        rows = max(2, round((box.north_m - box.south_m) / edge_m))
        east = box.west_m + (np.arange(columns) + 0.5) * (box.east_m - box.west_m) / columns
        north = box.south_m + (np.arange(rows) + 0.5) * (box.north_m - box.south_m) / rows
        self.nodes_en_m: FloatArray = np.stack(np.meshgrid(east, north, indexing="ij"), axis=-1).reshape(-1, 2)

    @property
    def spacing_m(self) -> float:
        """Distance between the first lines."""
        lane_m2 = self._box.area_m2 / self._vehicles
        return min(self.params.widest_m, lane_m2 / (self.params.lines_share * self.params.way_m))

    def first_lines(self, start_en_m: tuple[float, float]) -> FloatArray:
        """Corners of the first lines over this vehicle's strip: (K, 2) ENU metres."""
        strip = self._box.lane(self._vehicle, self._vehicles)
        return parallel_lines(strip, self.spacing_m, 0.35 * self.spacing_m, start_en_m)

    def next_way(
        self,
        here_en_m: tuple[float, float],
        relief: Relief,
        sounding_sd_m: float,
        left_m: float,
        teammates_en_m: FloatArray,
        allowed: BoolArray | None = None,
    ) -> FloatArray:
        """Corners of the most telling way from here, the place itself first: (K, 2) ENU metres.

        Parameters
        ----------
        left_m
            What this vehicle can still sail.
        teammates_en_m : (T, 2), where those are that share what is uncertain.
        allowed : (M,) bool over `nodes_en_m`; None allows all.
        """
        covariance = relief.covariance_of(self.nodes_en_m)
        variance = np.maximum(np.diag(covariance), 0.0)
        own = self._own_share(variance, np.array(here_en_m), teammates_en_m)
        weights = np.where(own, 1.0, self.params.foreign_weight)
        if allowed is not None:
            covariance = np.where(allowed[:, None] & allowed, covariance, np.diag(np.full(len(allowed), 1e-12)))
        return most_telling_way(
            float(here_en_m[0]),
            float(here_en_m[1]),
            self.nodes_en_m,
            np.ascontiguousarray(covariance),
            weights,
            sounding_sd_m**2,
            min(left_m, self.params.look_ahead_m),
            self.params.turn_m,
        )

    def _own_share(self, variance_m2: FloatArray, here_en_m: FloatArray, teammates_en_m: FloatArray) -> BoolArray:
        """Nodes that are this vehicle's: of strips across the area with equal variance, the one in its own order."""
        if len(teammates_en_m) == 0:
            return np.ones(len(variance_m2), dtype=np.bool_)
        places = np.vstack((here_en_m[None], teammates_en_m))
        axis = int(np.argmax(np.ptp(places, axis=0)))
        rank = int(np.count_nonzero(teammates_en_m[:, axis] < here_en_m[axis]))
        order = np.argsort(self.nodes_en_m[:, axis], kind="stable")
        passed = np.empty(len(order))
        passed[order] = np.cumsum(variance_m2[order])
        strip = np.minimum((passed / passed.max() * len(places) * (1 - 1e-12)).astype(np.int64), len(places) - 1)
        own: BoolArray = strip == rank
        return own


class SurveyPlanner:
    """A `MappingPlanner` that flies a `Survey`."""

    def __init__(self, survey: Survey) -> None:
        self._survey = survey
        self._corners: deque[tuple[float, float]] | None = None
        self._sails_lines = True
        self._here: tuple[float, float] | None = None
        self._left_m = survey.params.way_m

    def ask(self, situation: MappingSituation) -> Decision:
        """Say where to go next; Finished when the way is used up or nothing uncertain is in reach."""
        here = (situation.position_enu_m[0], situation.position_enu_m[1])
        if self._here is not None:
            self._left_m -= math.dist(here, self._here)
        self._here = here
        if self._corners is None:
            self._corners = deque(map(tuple, self._survey.first_lines(here).tolist()))
        while True:
            while self._corners and not self._admits(situation, self._corners[0]):
                self._corners.popleft()
            if self._corners:
                return self._towards(situation, here)
            if self._left_m <= 0.0:
                return Finished("the way that time allows is sailed")
            self._sails_lines = False
            if not self._plan_on(situation, here):
                return Finished("nothing uncertain is left within reach")

    def _towards(self, situation: MappingSituation, here: tuple[float, float]) -> Waypoint:
        """The next corner, or as far towards it as one leg goes."""
        assert self._corners
        corner = self._corners[0]
        away_m = math.dist(here, corner)
        share = min(1.0, situation.reach_m / max(away_m, 1e-9))
        if share >= 1.0:
            self._corners.popleft()
        up_m = situation.band.highest_m
        end = (here[0] + share * (corner[0] - here[0]), here[1] + share * (corner[1] - here[1]), up_m)
        why = f"line, {away_m:.0f} m to its end" if self._sails_lines else f"uncertain ground {away_m:.0f} m away"
        goal = (corner[0], corner[1], up_m)
        route = tuple((east, north, up_m) for east, north in list(self._corners)[:10])
        return Waypoint(end, why, goal, away_m, route)

    def _plan_on(self, situation: MappingSituation, here: tuple[float, float]) -> bool:
        """Work out the next part of the way; False when there is none."""
        survey, landmarks = self._survey, situation.landmarks
        known = np.flatnonzero(np.isfinite(landmarks.heights_m))
        if len(known) == 0:
            return False
        known = known[:: math.ceil(len(known) / MOST_SOUNDINGS)]
        relief = Relief(landmarks.layout.positions_en_m[known], landmarks.heights_m[known], landmarks.sd_m[known])
        drop_m = max(1.0, situation.band.highest_m - float(np.mean(landmarks.heights_m[known])))
        sounding_sd_m = float(situation.sensor.noise_sd_m(np.array([drop_m]), situation.unfixed_s)[0])
        nodes = np.column_stack((survey.nodes_en_m, np.full(len(survey.nodes_en_m), situation.band.highest_m)))
        way = survey.next_way(
            here, relief, sounding_sd_m, self._left_m, _places(situation.teammates), situation.admissible(nodes)
        )
        gone_m = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(way, axis=0).T))))
        last = max(2, int(np.searchsorted(gone_m, survey.params.part_m)) + 1)
        self._corners = deque(map(tuple, way[1:last].tolist()))
        return bool(self._corners)

    @staticmethod
    def _admits(situation: MappingSituation, corner: tuple[float, float]) -> bool:
        return bool(situation.admissible(np.array([(*corner, situation.band.highest_m)]))[0])


def _places(teammates: tuple[Teammate, ...]) -> FloatArray:
    return np.array([mate.position_enu_m[:2] for mate in teammates], dtype=np.float64).reshape(-1, 2)
