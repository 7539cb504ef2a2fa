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
    keeps_backlog
        Goes beyond the paper, for links that carry little. News, that is newly accurate landmarks, waits for room and
        comes before all else; then comes that of which most is measured that was not told. A receiver takes what adds
        most to its map.
    tellings
        How often news is told where it is kept: more than once survives the loss of a packet, and takes others' room.
    """

    capacity: int = 10
    travel_m: float = math.inf
    near_m: float = 0.0
    keeps_backlog: bool = False
    tellings: int = 2

    def __post_init__(self) -> None:
        if self.capacity < 1:
            raise ValueError("capacity must be at least 1 landmark, or vehicles can tell each other nothing")
        if not self.travel_m >= 0:
            raise ValueError("travel_m must not be negative")
        if not self.near_m >= 0:
            raise ValueError("near_m must not be negative")
        if self.tellings < 1:
            raise ValueError("tellings must be at least 1")


class LandmarkExchange:
    """Fills one vehicle's packets and sieves those of its teammates.

    A measurement goes as the running sums of who measured it, so a packet that is lost or comes twice does no harm.
    """

    def __init__(self, landmarks: LandmarkMap, params: ExchangeParams) -> None:
        self.params = params
        self._map = landmarks
        self._news: IndexArray = np.empty(0, np.int64)
        self._visible: IndexArray = np.empty(0, np.int64)
        self._told: dict[int, int] = {}
        self._told_information: FloatArray = np.zeros(len(landmarks.layout))

    def sensed(self, visible: IndexArray, sealed: IndexArray) -> None:
        """Take note of a step's landmarks: ids now visible (V of definition 1), and those newly accurate by them."""
        self._visible = np.asarray(visible, dtype=np.int64)
        keep = self._news if self.params.keeps_backlog else np.empty(0, np.int64)
        self._news = np.union1d(keep, np.asarray(sealed, dtype=np.int64))
        for landmark in np.asarray(sealed, dtype=np.int64).tolist():
            self._told.pop(landmark, None)  # what is news again is told again

    def packet(self, position_enu_m: Point, teammates_enu_m: Sequence[Point]) -> LandmarkRecords:
        """What to tell now: at most `capacity` landmarks, nearest to reachable teammates first.

        With a backlog that is the order of news, and what comes after it goes by how much is untold.

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
        if self.params.keeps_backlog:
            chosen = self._filled(self._news, towards)
            self._count(chosen)
            self._told_information[chosen] = self._map.own_information[chosen]
            chosen = np.concatenate((chosen, self._untold(self.params.capacity - len(chosen))))
        else:
            inaccurate = self._visible[~self._map.accurate[self._visible]]
            chosen = self._filled(np.concatenate((self._news, inaccurate)), towards)
        return LandmarkRecords.joined(
            self._map.seals(chosen), self._map.own_records(chosen[~self._map.accurate[chosen]])
        )

    def sieve(self, packets: Sequence[LandmarkRecords], position_enu_m: Point) -> LandmarkRecords:
        """What to take in of several teammates' packets, up to its capacity: the nearest to this vehicle, or with a
        backlog those that add most.
        """
        told = LandmarkRecords.joined(LandmarkRecords.empty(), *packets)
        if self.params.keeps_backlog:
            return self._most_telling(told)
        known = (told.landmarks >= 0) & (told.landmarks < len(self._map.layout))
        ids, inverse = np.unique(told.landmarks[known], return_inverse=True)
        if len(ids) == 0:
            return told  # nothing that could be sorted: for the map to drop and count
        chosen = self._filled(ids, np.array([position_enu_m[:2]]))
        taken = ~known
        taken[known] = np.isin(ids, chosen)[inverse]
        return told[taken]

    def _most_telling(self, told: LandmarkRecords) -> LandmarkRecords:
        """Records of those landmarks of which they add most, as many as there is room for."""
        gains = self._map.gain_of(told)
        known = (told.landmarks >= 0) & (told.landmarks < len(self._map.layout))
        ids, inverse = np.unique(told.landmarks[known], return_inverse=True)
        total = np.zeros(len(ids))
        np.add.at(total, inverse, gains[known])
        chosen = ids[np.argsort(-total, kind="stable")[: self.params.capacity]]
        taken = ~known
        taken[known] = np.isin(ids, chosen)[inverse]
        return told[taken]

    def _untold(self, room: int) -> IndexArray:
        """Inaccurate landmarks of which this vehicle has measured most that it has not told, as many as have room."""
        untold = np.where(self._map.accurate, 0.0, self._map.own_information - self._told_information)
        chosen = np.argsort(-untold, kind="stable")[:room]
        chosen = chosen[untold[chosen] > 0.0]
        self._told_information[chosen] = self._map.own_information[chosen]
        return chosen

    def _count(self, told: IndexArray) -> None:
        """News that was told often enough is no news any more."""
        for landmark in told.tolist():
            self._told[landmark] = self._told.get(landmark, 0) + 1
        waiting = [one for one in self._news.tolist() if self._told.get(one, 0) < self.params.tellings]
        self._news = np.array(waiting, dtype=np.int64)

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
