"""What is heard of maps, in one batch: journalled records without gaps, digests, and landmarks."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from ground_station.landmark_picture import LandmarkPicture
from ground_station.picture import FleetState, Stream
from ground_station.team_map import TeamMap
from ground_station.town_tops import cells_told
from vehicle_agent.domain.elevation import CellObservations
from vehicle_agent.wire.messages import DeltaRecord, Digest, Landmarks

MAX_STREAMS = 256


class MapIntake:
    """The next maps in the making: copied once for the whole batch.

    Attributes
    ----------
    streams
        By (origin, stream_id).
    foreign, malformed
        Records that were dropped in this batch, as in `Counters`.
    earliest_ms
        Oldest stamp of any record of this batch; None without one.
    """

    def __init__(self, state: FleetState) -> None:
        self.streams = dict(state.streams)
        self.foreign = self.malformed = 0
        self.earliest_ms: int | None = None
        self._state = state
        self._index_of = {vehicle.name: vehicle.index for vehicle in state.vehicles}
        self._observations: list[tuple[int, CellObservations]] = []
        self._landmarks: list[tuple[int, int, bytes]] = []

    def take_records(self, records: Iterable[DeltaRecord]) -> None:
        for record in records:
            name = (record.origin, record.stream_id)
            stream = self.streams.get(name, Stream())
            index = self._index_of.get(record.origin)
            if index is None or self._is_too_much(name):
                self.foreign += 1
                continue
            if record.delta_sequence in stream.held:
                continue
            self.streams[name] = Stream(
                stream.held.with_number(record.delta_sequence), max(stream.offered, record.delta_sequence + 1)
            )
            cells = cells_told(self._state.plan, record.cells)
            if cells is None:  # counted as held all the same: asking again would bring the same bytes
                self.malformed += 1
            elif len(cells):
                self._observations.append((index, cells))
                first_ms = int(cells.stamps_ms.min())
                self.earliest_ms = first_ms if self.earliest_ms is None else min(self.earliest_ms, first_ms)

    def take_digest(self, digest: Digest) -> None:
        for told in digest.streams:
            name = (told.origin, told.stream_id)
            if told.origin not in self._index_of or self._is_too_much(name):
                continue
            stream = self.streams.get(name, Stream())
            if told.held > stream.offered:
                self.streams[name] = replace(stream, offered=told.held)

    def take_landmarks(self, message: Landmarks) -> None:
        self._landmarks.append((self._index_of[message.sender], message.stamp_ms, message.records))

    def maps(self) -> tuple[TeamMap, LandmarkPicture | None]:
        """Both maps with the batch folded in."""
        landmarks, team_map = self._state.landmarks, self._state.team_map
        if landmarks is None:
            self.foreign += len(self._landmarks)
        elif self._landmarks:
            landmarks, seen, malformed = landmarks.joined_with(self._landmarks)
            self._observations += seen
            self.malformed += malformed
        if self._observations:
            team_map = team_map.joined_with(self._observations)
        return team_map, landmarks

    def _is_too_much(self, name: tuple[str, int]) -> bool:
        return name not in self.streams and len(self.streams) >= MAX_STREAMS
