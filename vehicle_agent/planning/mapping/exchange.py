"""What a vehicle tells its team of landmarks when it may tell only a few (Kapoutsis 2015, section 3.4)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.landmark_records import LandmarkRecords
from vehicle_agent.domain.landmarks import LandmarkMap


@dataclass(frozen=True, slots=True)
class ExchangeParams:
    """How much is told and taken in at one step.

    Attributes
    ----------
    capacity
        Landmarks in a packet, sent or received (10 in section 6). At least 1.
    travel_m
        What a teammate can travel until the next step: the reachable exploration area's threshold.
    near_m
        Of landmarks nearer to each other than this only one is told.
    """

    capacity: int = 10
    travel_m: float = math.inf
    near_m: float = 0.0

    def __post_init__(self) -> None:
        if self.capacity < 1:
            raise ValueError("capacity must be at least 1 landmark, or vehicles can tell each other nothing")
        if not self.travel_m >= 0:
            raise ValueError("travel_m must not be negative")
        if not self.near_m >= 0:
            raise ValueError("near_m must not be negative")


class LandmarkExchange:
    """Fills one vehicle's packets and sieves those of its teammates.

    A measurement goes as the running sums of who measured it, so a packet that is lost or comes twice does no harm.
    """

    def __init__(self, landmarks: LandmarkMap, params: ExchangeParams) -> None:
        self.params = params
        self._map = landmarks
        self._news: IndexArray = np.empty(0, np.int64)
        self._visible: IndexArray = np.empty(0, np.int64)

    def sensed(self, visible: IndexArray, sealed: IndexArray) -> None:
        """Take note of a step's landmarks: ids now visible (V of definition 1), and those newly accurate by them."""
        self._visible = np.asarray(visible, dtype=np.int64)
        self._news = np.unique(np.asarray(sealed, dtype=np.int64))

    def packet(self, position_enu_m: Point, teammates_enu_m: Sequence[Point]) -> LandmarkRecords:
        """What to tell now: at most `capacity` landmarks, nearest to reachable teammates first.

        Parameters
        ----------
        position_enu_m
            Where this vehicle is.
        teammates_enu_m
            Where teammates are, as last told. Without any, distances count from the vehicle itself.
        """
        others = np.array([point[:2] for point in teammates_enu_m], dtype=np.float64).reshape(-1, 2)
        listeners = self._reachable(others)
        towards = listeners if len(listeners) else others
        if len(towards) == 0:
            towards = np.array([position_enu_m[:2]])
        inaccurate = self._visible[~self._map.accurate[self._visible]]
        chosen = self._filled(np.concatenate((self._news, inaccurate)), towards)
        return LandmarkRecords.joined(
            self._map.seals(chosen), self._map.own_records(chosen[~self._map.accurate[chosen]])
        )

    def sieve(self, packets: Sequence[LandmarkRecords], position_enu_m: Point) -> LandmarkRecords:
        """What to take in of several teammates' packets, up to its capacity: the nearest to this vehicle."""
        told = LandmarkRecords.joined(LandmarkRecords.empty(), *packets)
        known = (told.landmarks >= 0) & (told.landmarks < len(self._map.layout))
        ids, inverse = np.unique(told.landmarks[known], return_inverse=True)
        if len(ids) == 0:
            return told  # nothing that could be sorted: for the map to drop and count
        chosen = self._filled(ids, np.array([position_enu_m[:2]]))
        taken = ~known
        taken[known] = np.isin(ids, chosen)[inverse]
        return told[taken]

    def _reachable(self, others: FloatArray) -> FloatArray:
        """Teammates that could see next step what this vehicle sees now: its reachable exploration area."""
        if len(self._visible) == 0 or len(others) == 0:
            return others[:0]
        seen = self._map.layout.positions_en_m[self._visible]
        nearest = np.linalg.norm(others[:, None, :] - seen[None, :, :], axis=2).min(axis=1)
        reachable: FloatArray = others[nearest < self.params.travel_m]
        return reachable

    def _filled(self, candidates: IndexArray, towards: FloatArray) -> IndexArray:
        """Candidates nearest to any of some places, near duplicates left out, as many as there is room for."""
        places = self._map.layout.positions_en_m[candidates]
        distances = np.linalg.norm(places[:, None, :] - towards[None, :, :], axis=2).min(axis=1)
        order = np.argsort(distances, kind="stable")
        if self.params.near_m <= 0:
            return candidates[order[: self.params.capacity]]
        chosen: list[int] = []
        for row in order.tolist():
            if len(chosen) == self.params.capacity:
                break
            if not chosen or np.linalg.norm(places[chosen] - places[row], axis=1).min() >= self.params.near_m:
                chosen.append(row)
        return candidates[np.array(chosen, dtype=np.int64)]
