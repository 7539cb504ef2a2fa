"""How a team's maps become one: journalled deltas, digests of what one holds, repairs of what another lacks.

A vehicle's own observations form a stream of numbered records. Whoever hears a digest that lacks records sends them:
the stream's origin, or, when the origin is silent, the first living vehicle that holds more. Records may come twice,
late, in any order and from anybody: each is folded into the map once.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import msgspec
import numpy as np

from vehicle_agent.domain.elevation import CellObservations, ElevationMap
from vehicle_agent.domain.grid import Grid
from vehicle_agent.wire.cells import pack_cells, unpack_cells
from vehicle_agent.wire.messages import MAX_RECORDS, DeltaRecord, Digest, StreamHeld

StreamId = tuple[str, int]
MAX_REPAIR_BYTES = 24_000
REPEAT_AFTER_S = 3.0
"""A record sent once is not sent again so soon: a repair reaches everybody."""


@dataclass(slots=True)
class Stream:
    """What is held of one origin's stream.

    Attributes
    ----------
    records
        By delta sequence.
    held
        Records 0 .. held - 1 are all there.
    """

    records: dict[int, DeltaRecord] = field(default_factory=dict)
    held: int = 0

    def add(self, record: DeltaRecord) -> bool:
        """Keep a record; False when it is there already."""
        if record.delta_sequence in self.records:
            return False
        self.records[record.delta_sequence] = record
        while self.held in self.records:
            self.held += 1
        return True


class MapExchange:
    """One vehicle's map, its own stream and the streams it has heard.

    Attributes
    ----------
    team_map
        Everything that this vehicle measured or was told.
    refused
        Records of unknown vehicles or with impossible cells, counted and dropped.
    """

    def __init__(
        self, grid: Grid, team: tuple[str, ...], own_index: int, boot_id: int, journal_records: Iterable[bytes] = ()
    ) -> None:
        self.team_map = ElevationMap(grid)
        self.refused = 0
        self._team = team
        self._own_index = own_index
        self._stream_id = boot_id
        self._streams: dict[StreamId, Stream] = {}
        self._pending: list[CellObservations] = []
        self._sent_at_s: dict[tuple[StreamId, int], float] = {}
        for record in _own_records(journal_records, team[own_index]):
            self._stream_id = record.stream_id
            self._take(record)

    @property
    def own_stream(self) -> Stream:
        return self._streams.setdefault((self._team[self._own_index], self._stream_id), Stream())

    def observe(self, cells: CellObservations) -> int:
        """Fold one scan of the own sensor in; return how many cells it changed."""
        changed = self.team_map.observe(self._own_index, cells)
        if len(changed):
            self._pending.append(changed)
        return len(changed)

    def next_record(self) -> DeltaRecord | None:
        """What was observed since the last call as the stream's next record; None when nothing was.

        The caller journals it before anybody else hears of it.
        """
        if not self._pending:
            return None
        cells = _earliest(self._pending)
        self._pending.clear()
        record = DeltaRecord(self._team[self._own_index], self._stream_id, self.own_stream.held, pack_cells(cells))
        self.own_stream.add(record)
        return record

    def receive(self, records: Iterable[DeltaRecord]) -> None:
        """Fold in records from anybody."""
        for record in records:
            self._take(record)

    def digest(self) -> tuple[StreamHeld, ...]:
        return tuple(StreamHeld(origin, stream_id, s.held) for (origin, stream_id), s in sorted(self._streams.items()))

    def repair_for(self, digest: Digest, responsible_for: frozenset[str], now_s: float) -> tuple[DeltaRecord, ...]:
        """Records that the digest's sender lacks and this vehicle is responsible for, oldest first, one message full.

        Parameters
        ----------
        responsible_for
            Origins whose gaps this vehicle mends: itself, and silent teammates where it is the first in line.
        """
        theirs = {(held.origin, held.stream_id): held.held for held in digest.streams}
        records: list[DeltaRecord] = []
        size = 0
        for stream_id, stream in sorted(self._streams.items()):
            if stream_id[0] not in responsible_for or stream_id[0] == digest.sender:
                continue
            for sequence in range(theirs.get(stream_id, 0), stream.held):
                record = stream.records[sequence]
                size += len(record.cells) + 16
                if size > MAX_REPAIR_BYTES or len(records) >= MAX_RECORDS:
                    return tuple(records)
                if now_s - self._sent_at_s.get((stream_id, sequence), -np.inf) < REPEAT_AFTER_S:
                    size -= len(record.cells) + 16
                    continue
                self._sent_at_s[stream_id, sequence] = now_s
                records.append(record)
        return tuple(records)

    def _take(self, record: DeltaRecord) -> None:
        cells = unpack_cells(record.cells, self.team_map.grid.cells)
        if cells is None or record.origin not in self._team:
            self.refused += 1
            return
        if self._streams.setdefault((record.origin, record.stream_id), Stream()).add(record):
            self.team_map.observe(self._team.index(record.origin), cells)


def _own_records(journal_records: Iterable[bytes], own_name: str) -> Iterator[DeltaRecord]:
    for data in journal_records:
        try:
            record = msgspec.msgpack.decode(data, type=DeltaRecord)
        except msgspec.DecodeError:
            continue
        if record.origin == own_name:
            yield record


def encode_record(record: DeltaRecord) -> bytes:
    """The bytes of a record as the journal keeps them."""
    return msgspec.msgpack.encode(record)


def _earliest(batches: list[CellObservations]) -> CellObservations:
    """One batch with every cell once, its earliest observation kept."""
    indices = np.concatenate([batch.cell_indices for batch in batches])
    elevations = np.concatenate([batch.elevations_dm for batch in batches])
    stamps = np.concatenate([batch.stamps_ms for batch in batches])
    order = np.lexsort((elevations, stamps, indices))
    first = order[np.unique(indices[order], return_index=True)[1]]
    return CellObservations(indices[first], elevations[first], stamps[first])
