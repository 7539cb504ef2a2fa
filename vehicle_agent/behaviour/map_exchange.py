"""How a team's maps become one: journalled deltas, digests of what one holds, repairs of what another lacks.

A vehicle's own observations form a stream of numbered records. Whoever hears a digest that lacks records sends them:
the stream's origin, or, when the origin is silent or lacks the stream, the first living vehicle that by its own digest
holds more. Records may come twice, late, in any order and from anybody: each is folded into the map once.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import msgspec
import numpy as np

from vehicle_agent.behaviour.shared_map import SharedMap
from vehicle_agent.domain.team_map import TeamMap
from vehicle_agent.ports import SensorScan
from vehicle_agent.wire.messages import MAX_RECORDS, DeltaRecord, Digest, StreamHeld

StreamId = tuple[str, int]
MAX_RECORD_BYTES = 8_000
"""A record larger than this would stand in the way of others on a thin link; the rest waits for the next one."""
MAX_STREAMS = 256
"""Streams followed and told in a digest; a team of honest vehicles makes one per start of an agent."""
MAX_REPAIR_BYTES = 24_000
REPEAT_AFTER_S = 3.0
"""A record sent once is not sent again so soon: a repair reaches everybody."""
REPEAT_BEYOND_GAP_S = 60.0
"""The same for a record after a gap that nobody here can mend: a digest cannot tell that it is held."""


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

    @property
    def has_gaps(self) -> bool:
        return self.held < len(self.records)

    def from_on(self, sequence: int) -> list[int]:
        """Numbers of the records held from that one on, those after a gap included."""
        return [*range(sequence, self.held), *sorted(n for n in self.records if n >= max(sequence, self.held))]

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
    shared
        The map, everything that this vehicle measured or was told.
    refused
        Scans and records of unknown vehicles or with impossible content, counted and dropped.
    """

    def __init__(
        self,
        shared: SharedMap,
        team: tuple[str, ...],
        own_index: int,
        boot_id: int,
        journal_records: Iterable[bytes] = (),
    ) -> None:
        self.shared = shared
        self.refused = 0
        self._team = team
        self._own_index = own_index
        self._stream_id = boot_id
        self._streams: dict[StreamId, Stream] = {}
        self._sent_at_s: dict[tuple[StreamId, int], float] = {}
        self._told: dict[str, dict[StreamId, int]] = {}
        for record in _own_records(journal_records, team[own_index]):
            self._stream_id = record.stream_id
            self._take(record)
        resumed = self._streams.get((team[own_index], self._stream_id))
        if resumed is not None and resumed.has_gaps:  # its next number may be one that others know already
            self._stream_id = boot_id

    @property
    def team_map(self) -> TeamMap:
        """The map itself."""
        return self.shared.team_map

    @property
    def own_stream(self) -> Stream:
        return self._streams.setdefault((self._team[self._own_index], self._stream_id), Stream())

    def observe(self, scan: SensorScan) -> int:
        """Fold one scan of the own sensor in; return how much it changed. What makes no sense is counted."""
        changed, sensible = self.shared.take_scan(scan)
        self.refused += not sensible
        return changed

    def next_record(self) -> DeltaRecord | None:
        """What was observed since the last call as the stream's next record; None when nothing was.

        A record stays below `MAX_RECORD_BYTES`: what does not fit is left for the next call. The caller journals it
        before anybody else hears of it.
        """
        blob = self.shared.next_blob(MAX_RECORD_BYTES)
        if blob is None:
            return None
        record = DeltaRecord(self._team[self._own_index], self._stream_id, self.own_stream.held, blob)
        self.own_stream.add(record)
        return record

    def receive(self, records: Iterable[DeltaRecord], repaired_at_s: float | None = None) -> int:
        """Fold in records from anybody; return how many were new.

        `repaired_at_s` tells when they came as somebody's repair, which need not be repeated at once.
        """
        new = 0
        for record in records:
            new += self._take(record)
            if repaired_at_s is not None:
                self._sent_at_s[(record.origin, record.stream_id), record.delta_sequence] = repaired_at_s
        return new

    def digest(self) -> tuple[StreamHeld, ...]:
        return tuple(StreamHeld(origin, stream_id, s.held) for (origin, stream_id), s in sorted(self._streams.items()))

    def repair_for(self, digest: Digest, living: Sequence[str], now_s: float) -> tuple[DeltaRecord, ...]:
        """Records that the digest's sender lacks and this vehicle answers for, oldest first, one message full.

        Parameters
        ----------
        living
            Names of this vehicle and of the teammates that are heard, in team order.
        """
        theirs = {(held.origin, held.stream_id): held.held for held in digest.streams}
        if digest.sender in self._team:
            self._told[digest.sender] = theirs
        records: list[DeltaRecord] = []
        size = 0
        for stream_id, stream in sorted(self._streams.items()):
            their_held = theirs.get(stream_id, 0)
            if not self._answers_for(stream_id, digest.sender, their_held, living):
                continue
            for sequence in stream.from_on(their_held):
                wait_s = REPEAT_AFTER_S if sequence < stream.held else REPEAT_BEYOND_GAP_S
                if now_s - self._sent_at_s.get((stream_id, sequence), -np.inf) < wait_s:
                    continue
                record = stream.records[sequence]
                size += len(record.cells) + 16
                if records and (size > MAX_REPAIR_BYTES or len(records) >= MAX_RECORDS):
                    return tuple(records)
                self._sent_at_s[stream_id, sequence] = now_s
                records.append(record)
        return tuple(records)

    def _answers_for(self, stream_id: StreamId, sender: str, their_held: int, living: Sequence[str]) -> bool:
        """Whether this vehicle is the one that mends the sender's gaps in a stream: one answers, not all."""
        own, origin = self._team[self._own_index], stream_id[0]
        holds_it = origin == own or stream_id in self._told.get(origin, {stream_id: 0})
        if origin in living and origin != sender and holds_it:
            return origin == own
        for name in living:
            if name == own:
                return True
            if name != sender and self._told.get(name, {}).get(stream_id, 0) > their_held:
                return False
        return False

    def _take(self, record: DeltaRecord) -> bool:
        stream_id = (record.origin, record.stream_id)
        too_many = stream_id not in self._streams and len(self._streams) >= MAX_STREAMS
        if record.origin not in self._team or too_many:
            self.refused += 1
            return False
        known = self._streams.get(stream_id)
        if known is not None and record.delta_sequence in known.records:
            return False
        if not self.shared.fold(self._team.index(record.origin), record.cells):
            self.refused += 1
            return False
        return self._streams.setdefault(stream_id, Stream()).add(record)


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
