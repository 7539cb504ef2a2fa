"""Sails a few lines over its part of the area first, then densely where it is rough and sparsely where it is even.

The first lines show how rough the ground is from place to place. From what was found a relief is fitted; then the most
telling track from here is worked out for all of the way that is left, over this vehicle's share of the ground, and a
part of it sailed. What is left of it is then mended by what was found meanwhile, or laid afresh where that tells more.
Vehicles share by a cut that leaves equal work on both sides, each from its own map alone.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.relief import EXPONENT, Relief
from vehicle_agent.planning.interface import Decision, Finished, Waypoint
from vehicle_agent.planning.mapping.infill import left_untold, settled_track, telling_track
from vehicle_agent.planning.mapping.interface import MappingSituation
from vehicle_agent.planning.mapping.roughness import roughness_at_nodes
from vehicle_agent.planning.mapping.survey_lines import Box, corners_of, parallel_lines

MOST_SOUNDINGS = 350
"""Of more than these every n-th is left out, so that a decision stays quick."""
PACE_GUESSED_S = 60.0
"""The pace that was guessed beforehand counts like so much time."""
TEMPERED = 0.8
"""Power of the roughness that tracks follow: ground far from all soundings is less uncertain than by the power law."""
STRAIGHT_WITHIN_M = 1.0
"""So far a way may pass beside its track, for the sake of longer legs."""


@dataclass(frozen=True, slots=True)
class SurveyParams:
    """How a survey is divided.

    Attributes
    ----------
    way_m
        What one vehicle can sail in all, as far as is known beforehand.
    time_s
        Time in which it sails; what is left of the way is then judged by the pace so far.
    lines_share
        Share of it for the first lines.
    widest_m
        Lines are no further apart than this.
    nodes
        Places that stand for the ground, about so many.
    part_m
        What of a track is sailed before the next is worked out.
    step_m
        Distance between soundings.
    rounds
        Of settling, for a track.
    inside_m
        A track keeps so far from the box's sides.
    """

    way_m: float
    time_s: float = math.inf
    lines_share: float = 0.15
    widest_m: float = 25.0
    nodes: int = 3_600
    part_m: float = 300.0
    step_m: float = 2.5
    rounds: int = 100
    inside_m: float = 0.0

    def __post_init__(self) -> None:
        if not (self.way_m > 0 and self.part_m > 0 and self.widest_m > 0 and self.step_m > 0):
            raise ValueError("way_m, part_m, widest_m and step_m must be positive")
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
        self._shape = (columns, rows)
        self._edges_m = ((box.east_m - box.west_m) / columns, (box.north_m - box.south_m) / rows)

    @property
    def spacing_m(self) -> float:
        """Distance between the first lines."""
        lane_m2 = self._box.area_m2 / self._vehicles
        return min(self.params.widest_m, lane_m2 / (self.params.lines_share * self.params.way_m))

    def first_lines(self, start_en_m: tuple[float, float]) -> FloatArray:
        """Corners of the first lines over this vehicle's strip: (K, 2) ENU metres."""
        strip = self._box.lane(self._vehicle, self._vehicles)
        return parallel_lines(strip, self.spacing_m, 0.35 * self.spacing_m, start_en_m)

    def roughness(self, relief: Relief) -> FloatArray:
        """How rough the ground is at `nodes_en_m`, up to a factor common to all: (M,)."""
        return roughness_at_nodes(relief, self.nodes_en_m, self._shape, self._edges_m)

    def next_way(
        self,
        here_en_m: tuple[float, float],
        strengths: FloatArray,
        sounded_en_m: FloatArray,
        left_m: float,
        teammates: Collection[int],
        allowed: BoolArray | None = None,
        planned_en_m: FloatArray | None = None,
    ) -> FloatArray:
        """The most telling track from here, the place itself first: (K, 2) ENU metres, at most `step_m` apart.

        Parameters
        ----------
        strengths : (M,), how rough the ground is at `nodes_en_m`, up to a common factor.
        sounded_en_m : (N, 2), where the team has sounded.
        left_m
            What this vehicle can still sail.
        teammates
            Numbers of those that share the ground.
        allowed : (M,) bool over `nodes_en_m`; None allows all.
        planned_en_m : (K, 2), what is left of the track worked out before: it is settled anew and sailed on, unless a
            track laid afresh tells more.
        """
        here = np.array(here_en_m, dtype=np.float64)
        strengths = strengths**TEMPERED
        own = self._own_share(strengths ** (2.0 / (EXPONENT + 1.0)), teammates)
        if allowed is not None:
            own &= allowed
        if not own.any():
            return here[None]
        away_m = np.asarray(KDTree(sounded_en_m).query(self.nodes_en_m[own])[0])
        nodes, rough, params = self.nodes_en_m[own], strengths[own], self.params
        how = (params.step_m, EXPONENT, params.rounds)
        track = telling_track(here, nodes, rough, away_m, left_m, *how)
        if planned_en_m is not None and len(planned_en_m) > 0:
            within = planned_en_m[: max(1, int(left_m / params.step_m))]
            again = settled_track(np.concatenate((here[None], within)), nodes, rough, away_m, *how)
            untold = [left_untold(way, nodes, rough, away_m, EXPONENT) for way in (track, again)]
            track = again if untold[1] < untold[0] else track
        box, inside_m = self._box, self.params.inside_m
        low, high = np.array([box.west_m, box.south_m]) + inside_m, np.array([box.east_m, box.north_m]) - inside_m
        track[1:] = np.clip(track[1:], low, high)
        return track

    def _own_share(self, work: FloatArray, teammates: Collection[int]) -> BoolArray:
        """Nodes that are this vehicle's: of strips from west to east with equal work, the one in its own order."""
        rank = sum(mate < self._vehicle for mate in teammates)
        order = np.argsort(self.nodes_en_m[:, 0], kind="stable")
        passed = np.empty(len(order))
        passed[order] = np.cumsum(work[order])
        strips = len(teammates) + 1
        strip = np.minimum((passed / passed.max() * strips * (1 - 1e-12)).astype(np.int64), strips - 1)
        own: BoolArray = strip == rank
        return own


class SurveyPlanner:
    """A `MappingPlanner` that flies a `Survey`."""

    def __init__(self, survey: Survey) -> None:
        self._survey = survey
        self._corners: deque[tuple[float, float]] | None = None
        self._planned: FloatArray | None = None
        self._sails_lines = True
        self._here: tuple[float, float] | None = None
        self._sailed_m = 0.0
        self._began_s: float | None = None

    def ask(self, situation: MappingSituation) -> Decision:
        """Say where to go next; Finished when the way is used up or nothing uncertain is in reach."""
        here = (situation.position_enu_m[0], situation.position_enu_m[1])
        if self._here is not None:
            self._sailed_m += math.dist(here, self._here)
        if self._began_s is None:
            self._began_s = situation.now_s
        self._here = here
        if self._corners is None:
            self._corners = deque(map(tuple, self._survey.first_lines(here).tolist()))
        while True:
            while self._corners and not self._admits(situation, self._corners[0]):
                self._corners.popleft()
            if self._corners:
                return self._towards(situation, here)
            left_m = self._left_m(situation.now_s - self._began_s)
            if left_m <= 0.0:
                return Finished("the way that time allows is sailed")
            self._sails_lines = False
            if not self._plan_on(situation, here, left_m):
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
        why = f"line, {away_m:.0f} m to its end" if self._sails_lines else f"rough ground, {away_m:.0f} m on"
        goal = (corner[0], corner[1], up_m)
        route = tuple((east, north, up_m) for east, north in list(self._corners)[:10])
        return Waypoint(end, why, goal, away_m, route)

    def _left_m(self, gone_s: float) -> float:
        """What it can still sail, at the pace so far; at first that counts little."""
        params = self._survey.params
        if math.isinf(params.time_s):
            return params.way_m - self._sailed_m
        guessed_m_s = params.way_m / params.time_s
        pace_m_s = (self._sailed_m + PACE_GUESSED_S * guessed_m_s) / (gone_s + PACE_GUESSED_S)
        return pace_m_s * (params.time_s - gone_s)

    def _plan_on(self, situation: MappingSituation, here: tuple[float, float], left_m: float) -> bool:
        """Work out the next part of the way; False when there is none."""
        survey, landmarks = self._survey, situation.landmarks
        known = np.flatnonzero(np.isfinite(landmarks.heights_m))
        if len(known) == 0:
            return False
        sounded, some = landmarks.layout.positions_en_m[known], known[:: math.ceil(len(known) / MOST_SOUNDINGS)]
        relief = Relief(landmarks.layout.positions_en_m[some], landmarks.heights_m[some], landmarks.sd_m[some])
        nodes = np.column_stack((survey.nodes_en_m, np.full(len(survey.nodes_en_m), situation.band.highest_m)))
        teammates = [mate.index for mate in situation.teammates]
        allowed = situation.admissible(nodes)
        track = survey.next_way(here, survey.roughness(relief), sounded, left_m, teammates, allowed, self._planned)
        count = max(2, round(survey.params.part_m / survey.params.step_m) + 1)
        part, self._planned = track[:count], track[count:]
        self._corners = deque(map(tuple, corners_of(part, STRAIGHT_WITHIN_M)[1:].tolist()))
        return bool(self._corners)

    @staticmethod
    def _admits(situation: MappingSituation, corner: tuple[float, float]) -> bool:
        return bool(situation.admissible(np.array([(*corner, situation.band.highest_m)]))[0])
