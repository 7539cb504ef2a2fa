"""What a vehicle tells over a link that carries little: what its listeners would otherwise do again, soonest first.

Goes beyond section 3.4 of Kapoutsis 2015, in what is told, not in how much: a packet has room for as many landmarks,
sent and received, and a sketch of what is done around a place takes that of one. A landmark is worth telling by how
unsure it is that a listener knows of it, and by how near it is to where that listener is or goes. What may have been
lost is told again when nothing is more urgent.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.done_sketch import DoneSketch, SketchBook
from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.landmark_records import SEAL, LandmarkRecords
from vehicle_agent.domain.landmarks import LandmarkMap
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.planning.interface import Teammate

_INACCURATE = 0.5
"""What measurements that would make a landmark accurate count, against one that is."""
_DOUBT = 0.5
"""How unsure it is after one telling that a listener knows."""
_LEAST_DOUBT = 0.02
"""The same once a listener showed that it lacks something where it was thought to know all."""
_ELSEWHERE = 0.02
"""Urgency of what is far from all listeners, over that of what is where one goes."""
_PATCH = 0.3
"""Edge of what a sketch speaks of as a whole, over the distance at which news is 1/e as urgent."""
_LEAST_VALUE = 1e-4
_LEAST_SKETCH_VALUE = 0.1


@dataclass(frozen=True, slots=True)
class Packet:
    """What one vehicle tells at one step.

    Attributes
    ----------
    records
        Landmarks, with what they were estimated to be.
    sketch
        What is done around a place; None when that would be news to nobody.
    """

    records: LandmarkRecords
    sketch: DoneSketch | None = None


class NeedExchange:
    """Fills one vehicle's packets and sieves those of its teammates.

    Parameters
    ----------
    capacity
        Landmarks in a packet, sent or received, a sketch counting as one. At least 1.
    near_m
        Distance at which what is to be told is 1/e as urgent.

    Attributes
    ----------
    said_done
        (N,) bool, landmarks that teammates' sketches called done. Their heights may be lost with who measured them:
        they are not to be measured before all others, and not to be forgotten.
    """

    def __init__(self, landmarks: LandmarkMap, capacity: int, near_m: float) -> None:
        if capacity < 1:
            raise ValueError("capacity must be at least 1 landmark, or vehicles can tell each other nothing")
        if not near_m > 0:
            raise ValueError("near_m must be positive")
        count = len(landmarks.layout)
        self.said_done: BoolArray = np.zeros(count, dtype=np.bool_)
        self._map, self._capacity, self._near_m = landmarks, capacity, near_m
        self._book = SketchBook(landmarks.layout, _PATCH * near_m)
        self._told_information: FloatArray = np.zeros(count)
        self._unsure: FloatArray = np.ones((landmarks.vehicles, count))
        """Chance that each teammate does not know that a landmark, accurate here, is accurate.

        This vehicle's own row is for whoever else may listen.
        """

    @property
    def has_untold(self) -> bool:
        """Whether this vehicle has measured something that it has told nobody yet."""
        own = self._map.own_information
        never = np.where(self._map.accurate, self._unsure[self._map.own_index] == 1.0, own > self._told_information)
        return bool(np.any(never & (own > 0.0)))

    def packet(self, teammates: Sequence[Teammate], room: int | None = None) -> Packet:
        """What to tell now to those who probably hear it; without any, what was told least.

        At most `capacity` landmarks, or `room` of them where that is less.
        """
        known = self._map
        most = self._capacity if room is None else min(room, self._capacity)
        values = self._values(teammates)
        listeners = np.array([mate.index for mate in teammates], dtype=np.int64)
        sketch = self._sketch(values, teammates) if most > 1 else None
        if sketch is not None:
            drawn = self._book.landmarks_in(sketch)
            self._unsure[np.ix_(listeners, drawn)] *= _DOUBT
            values[drawn] *= _DOUBT
        ids = np.flatnonzero(values > _LEAST_VALUE)
        chosen = ids[np.argsort(-values[ids], kind="stable")[: most - (sketch is not None)]]
        self._told_information[chosen] = known.own_information[chosen]
        self._unsure[np.ix_(np.append(listeners, known.own_index), chosen)] *= _DOUBT
        records = LandmarkRecords.joined(known.seals(chosen), known.own_records(chosen[~known.accurate[chosen]]))
        return Packet(records, sketch)

    def take(self, packets: Mapping[int, Packet], position_enu_m: Point) -> LandmarkRecords:
        """What to take in of teammates' packets, by team index, up to its capacity: what adds most near this vehicle.

        Sketches taken go to `said_done`. Records of landmarks unknown are kept, for the map to drop and count.
        """
        known = self._map
        told = LandmarkRecords.joined(LandmarkRecords.empty(), *(packet.records for packet in packets.values()))
        sensible = (told.landmarks >= 0) & (told.landmarks < len(known.layout))
        ids, inverse = np.unique(told.landmarks[sensible], return_inverse=True)
        gains = np.zeros(len(ids))
        np.add.at(gains, inverse, known.gain_of(told)[sensible])
        sketched = self._sketched(packets)
        news = [done[~known.accurate[done] & ~self.said_done[done]] for _, done in sketched]
        here = [position_enu_m]
        worth = np.array([*(gains * self._urgency(ids, here)), *(self._urgency(new, here).sum() for new in news)])
        taken = np.argsort(-worth, kind="stable")[: self._capacity]
        for row in taken[taken >= len(ids)].tolist():
            self.said_done[sketched[row - len(ids)][1]] = True
        for sender, packet in packets.items():
            seals = packet.records.landmarks[packet.records.contributors == SEAL]
            self._unsure[sender, seals[(seals >= 0) & (seals < len(known.layout))]] = 0.0
        for sender, done in sketched:
            self._unsure[sender, done] = 0.0
        kept = ~sensible
        kept[sensible] = np.isin(ids, ids[taken[taken < len(ids)]])[inverse]
        return told[kept]

    def doubt(self, listener: int, landmarks: IndexArray) -> None:
        """A listener seems to lack something of these landmarks: what was told of them less often comes again first."""
        unsure = np.maximum(self._unsure[listener, landmarks], _LEAST_DOUBT)
        self._unsure[listener, landmarks] = np.minimum(unsure / _DOUBT, 1.0)
        self._told_information[landmarks] *= _DOUBT

    def forget(self, listener: int) -> None:
        """A listener has begun anew and knows nothing of what it was told."""
        self._unsure[listener] = 1.0
        self._told_information[:] = 0.0

    def is_readable(self, sketch: DoneSketch) -> bool:
        """Whether a sketch can be one of this layout."""
        return self._book.is_readable(sketch)

    def _values(self, teammates: Sequence[Teammate]) -> FloatArray:
        """(N,), what telling each landmark is worth to all teammates together."""
        known = self._map
        untold = np.clip(known.own_information - self._told_information, 0.0, 1.0)
        news = np.where(known.accurate, 1.0, _INACCURATE * untold)
        values = np.zeros(len(news))
        ids = np.flatnonzero(news)
        if not teammates:
            values[ids] = news[ids] * np.where(known.accurate[ids], self._unsure[known.own_index, ids], 1.0)
        for mate in teammates:
            unsure = np.where(known.accurate[ids], self._unsure[mate.index, ids], 1.0)
            values[ids] += news[ids] * unsure * self._urgency(ids, _whereabouts(mate))
        return values

    def _sketch(self, values: FloatArray, teammates: Sequence[Teammate]) -> DoneSketch | None:
        """The sketch of most worth around where a teammate is or goes."""
        done = np.where(self._map.accurate, values, 0.0)
        places = [place for mate in teammates for place in _whereabouts(mate)]
        centres = sorted({self._book.centre_at(place[0], place[1]) for place in places})
        drawn = [self._book.sketch(self._map.accurate, centre) for centre in centres]
        worth = [float(done[self._book.landmarks_in(sketch)].sum()) for sketch in drawn]
        return drawn[int(np.argmax(worth))] if max(worth, default=0.0) >= _LEAST_SKETCH_VALUE else None

    def _sketched(self, packets: Mapping[int, Packet]) -> list[tuple[int, IndexArray]]:
        """Senders of sketches, and what these call done."""
        return [
            (sender, self._book.landmarks_in(packet.sketch))
            for sender, packet in packets.items()
            if packet.sketch is not None
        ]

    def _urgency(self, landmarks: IndexArray, towards: Sequence[Point]) -> FloatArray:
        """How soon landmarks matter to somebody at or on the way to some places, (M,)."""
        places = self._map.layout.positions_en_m[landmarks]
        away = np.min([np.hypot(places[:, 0] - place[0], places[:, 1] - place[1]) for place in towards], axis=0)
        urgency: FloatArray = np.exp(-away / self._near_m) + _ELSEWHERE
        return urgency


def _whereabouts(mate: Teammate) -> list[Point]:
    return [mate.position_enu_m] if mate.goal_enu_m is None else [mate.position_enu_m, mate.goal_enu_m]
