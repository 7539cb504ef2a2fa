"""Mission recordings: every input of the picture in an MCAP file, readable by Foxglove, and back.

Topics are `/<vehicle>/<topic>` for what was heard, `/station/...` for the station's own findings and orders, and
`/<vehicle>/location` (foxglove.LocationFix) for maps. All messages are JSON with a JSON Schema. The mission itself is
an attachment, so one file is all that a replay needs.
"""

from __future__ import annotations

import struct
import time
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import msgspec
from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, Chunk, Footer, McapRecord, Message, Metadata
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import Writer

from ground_station.inputs import FleetInput, Heard, LinkCounted, Tick
from ground_station.picture import FleetState
from ground_station.wire_json import STATION_TOPICS, from_object, schema_of, to_object, topic_name
from vehicle_agent.mission.load import MissionError, MissionPlan, plan_mission
from vehicle_agent.mission.model import Mission
from vehicle_agent.wire.keys import TOPICS
from vehicle_agent.wire.messages import Status

FILE_NAME = "mission.mcap"
STATION = "station"
OTHERS = "others"
FLUSH_PERIOD_S = 2.0
"""At most so much of a recording is lost when its writer dies."""
CHUNK_BYTES = 256_000
LOCATION_SCHEMA: Mapping[str, object] = {
    "title": "foxglove.LocationFix",
    "type": "object",
    "properties": {
        "timestamp": {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}},
        "frame_id": {"type": "string"},
        "latitude": {"type": "number"},
        "longitude": {"type": "number"},
        "altitude": {"type": "number"},
    },
}
_BROKEN = (McapError, struct.error, zlib.error, EOFError, OSError, ValueError, IndexError, KeyError, RuntimeError)


class RecordingError(Exception):
    """A recording that cannot be shown; its text is one sentence with the file and the mend."""


class RecordingWriter:
    """Writes the inputs of one picture.

    Raises OSError when the file cannot be written.
    """

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file = path.open("wb")
        self._writer = Writer(self._file, chunk_size=CHUNK_BYTES)
        self._channels: dict[tuple[str, str], int] = {}
        self._plan: MissionPlan | None = None
        self._offset_ns = 0
        self._flushed_s = 0.0
        self._sequence = 0
        self._counted: LinkCounted | None = None

    def begin(self, state: FleetState) -> None:
        """Write what a replay begins with: the mission, and who the station is."""
        self._plan = state.plan
        self._offset_ns = time.time_ns() - round(1e9 * state.began_s)
        self._flushed_s = state.began_s
        self._writer.start(profile="", library="fieldfleet")
        began = {"station": state.station, "boot_id": str(state.station_boot_id), "began_s": repr(state.began_s)}
        self._writer.add_metadata("fieldfleet", began)
        mission = msgspec.json.encode(state.plan.mission)
        now_ns = time.time_ns()
        self._writer.add_attachment(now_ns, now_ns, "mission.json", "application/json", mission)
        radio = [topic.name for topic in TOPICS if topic.over_radio]
        schemas = {name: self._schema(f"fieldfleet.{name}", schema_of(name)) for name in (*radio, *STATION_TOPICS)}
        location = self._schema("foxglove.LocationFix", LOCATION_SCHEMA)
        for vehicle in (*state.plan.vehicle_names, OTHERS):
            for name in radio:
                self._channel(vehicle, name, schemas[name])
            self._channel(vehicle, "location", location)
        for name in STATION_TOPICS:
            self._channel(STATION, name, schemas[name])

    def write(self, inputs: Sequence[FleetInput]) -> None:
        """Keep one batch of inputs, in order."""
        for event in inputs:
            if isinstance(event, LinkCounted):
                if event == self._counted:
                    continue
                self._counted = event
            self._write(event)
        now_s = inputs[-1].now_s if inputs and isinstance(inputs[-1], Tick) else self._flushed_s
        if now_s - self._flushed_s >= FLUSH_PERIOD_S:
            self._flushed_s = now_s
            self._writer.flush()  # type: ignore[no-untyped-call]
            self._file.flush()

    def close(self) -> None:
        self._writer.finish()  # type: ignore[no-untyped-call]
        self._file.close()

    def _write(self, event: FleetInput) -> None:
        content = to_object(event)
        name = topic_name(event)
        source = STATION
        if isinstance(event, Heard):
            source = event.message.sender if (event.message.sender, name) in self._channels else OTHERS
        station_s = next((content[key] for key in ("station_s", "now_s", "arrival_s") if key in content), None)
        log_ns = self._offset_ns + round(1e9 * (self._flushed_s if station_s is None else station_s))
        publish_ns = event.message.stamp_ms * 1_000_000 if isinstance(event, Heard) else log_ns
        self._put(source, name, log_ns, publish_ns, msgspec.json.encode(content))
        if isinstance(event, Heard) and isinstance(event.message, Status) and source != OTHERS:
            self._put(source, "location", log_ns, publish_ns, self._location(event.message))

    def _put(self, source: str, name: str, log_ns: int, publish_ns: int, data: bytes) -> None:
        self._writer.add_message(self._channels[source, name], max(0, log_ns), data, publish_ns, self._sequence)
        self._sequence = (self._sequence + 1) % 2**32

    def _location(self, status: Status) -> bytes:
        assert self._plan is not None
        east, north, up = status.position_cm
        place = self._plan.datum.to_geodetic((east / 100, north / 100, up / 100))
        seconds, rest_ms = divmod(status.stamp_ms, 1_000)
        return msgspec.json.encode(
            {
                "timestamp": {"sec": seconds, "nsec": rest_ms * 1_000_000},
                "frame_id": self._plan.mission.name,
                "latitude": place.latitude_deg,
                "longitude": place.longitude_deg,
                "altitude": place.altitude_amsl_m,
            }
        )

    def _schema(self, name: str, schema: Mapping[str, object]) -> int:
        return int(self._writer.register_schema(name, "jsonschema", msgspec.json.encode(schema)))

    def _channel(self, source: str, name: str, schema_id: int) -> None:
        self._channels[source, name] = self._writer.register_channel(f"/{source}/{name}", "json", schema_id)


@dataclass(frozen=True, slots=True)
class Span:
    """One chunk of a recording: where it lies in the file, and from when to when it reaches (log time, ns)."""

    offset: int
    start_ns: int
    end_ns: int


class Recording:
    """A recording that is read chunk by chunk, however long it is.

    Attributes
    ----------
    path
        The file.
    initial
        The picture that it begins with.
    complete
        False when the file ends before its end, or something in it cannot be read: all else is shown.
    length_s
        From its first to its last input.
    """

    def __init__(self, path: Path) -> None:
        self.path = path / FILE_NAME if path.is_dir() else path
        self._spans: list[Span] = []
        self._topics: dict[int, str] = {}
        try:
            self._file: IO[bytes] = self.path.open("rb")
        except OSError as error:
            raise RecordingError(f"{self.path}: {error.strerror}; name a run folder or an .mcap file") from None
        began, mission, self.complete = self._scan()
        if began is None or mission is None or not self._spans:
            raise RecordingError(f"{self.path}: holds no mission that fieldfleet recorded; name another recording")
        try:
            plan = plan_mission(msgspec.json.decode(mission, type=Mission), self.path)
            station, boot_id, began_s = began["station"], int(began["boot_id"]), float(began["began_s"])
        except (MissionError, msgspec.MsgspecError, KeyError, ValueError) as error:
            raise RecordingError(f"{self.path}: its mission cannot be read ({error}); name another") from None
        self.initial = FleetState.initial(plan, station, boot_id, began_s)
        self.length_s = max(0.0, (self._spans[-1].end_ns - self._spans[0].start_ns) / 1e9)

    @property
    def chunks(self) -> int:
        return len(self._spans)

    def inputs(self, chunk: int) -> list[FleetInput]:
        """What one chunk holds; what cannot be read in it is left out."""
        self._file.seek(self._spans[chunk].offset)
        record = next(StreamReader(self._file, skip_magic=True, emit_chunks=True).records)
        assert isinstance(record, Chunk)
        try:
            records = breakup_chunk(record)
        except _BROKEN:
            self.complete = False
            return []
        return [event for one in records if (event := self._parsed(one)) is not None]

    def close(self) -> None:
        self._file.close()

    def _parsed(self, record: McapRecord) -> FleetInput | None:
        name = self._topics.get(record.channel_id, "") if isinstance(record, Message) else ""
        if not name or not isinstance(record, Message):
            return None
        try:
            return from_object(name, msgspec.json.decode(record.data))
        except msgspec.DecodeError:
            self.complete = False
            return None

    def _scan(self) -> tuple[dict[str, str] | None, bytes | None, bool]:
        """Look at every record's head once; returns the metadata, the mission, and whether the file is whole."""
        began: dict[str, str] | None = None
        mission: bytes | None = None
        offset = 8
        try:
            for record in StreamReader(self._file, emit_chunks=True).records:
                if isinstance(record, Metadata) and record.name == "fieldfleet":
                    began = record.metadata
                elif isinstance(record, Attachment) and record.name == "mission.json":
                    mission = record.data
                elif isinstance(record, Chunk):
                    self._take(record, offset)
                elif isinstance(record, Footer):
                    return began, mission, True
                offset = self._file.tell()
        except _BROKEN:
            return began, mission, False
        return began, mission, False

    def _take(self, chunk: Chunk, offset: int) -> None:
        if not self._spans:  # the writer names all its channels in the first
            for record in breakup_chunk(chunk):
                if isinstance(record, Channel) and not record.topic.endswith("/location"):
                    self._topics[record.id] = record.topic.rpartition("/")[2]
        self._spans.append(Span(offset, chunk.message_start_time, chunk.message_end_time))
