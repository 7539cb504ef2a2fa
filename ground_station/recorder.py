"""Keeps what was heard as JSON lines in a run folder."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import IO

import msgspec

from ground_station.ledger import SequenceRanges
from vehicle_agent.wire.messages import AnyMessage, Command, CommandResult, Event, Status

FILE_BY_KIND: dict[type[AnyMessage], str] = {
    Status: "status.jsonl",
    Event: "events.jsonl",
    Command: "events.jsonl",
    CommandResult: "events.jsonl",
}


class RunRecorder:
    """Appends statuses to `status.jsonl` and events, commands and results to `events.jsonl`.

    Every line is an object with `kind` and the message's fields by name (enumerations as lower-case words). A message
    that comes twice is written once. Map records are not kept here: agents journal them.

    Raises OSError when the folder cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._files: dict[str, IO[bytes]] = {
            name: (folder / name).open("ab") for name in sorted(set(FILE_BY_KIND.values()))
        }
        self._seen: dict[tuple[str, int], SequenceRanges] = {}

    def record(self, messages: Iterable[AnyMessage]) -> None:
        """Write the messages that belong in the record and put them on disk."""
        for message in messages:
            name = FILE_BY_KIND.get(type(message))
            if name is not None and self._is_new(message):
                self._files[name].write(json_line(message))
        for file in self._files.values():
            file.flush()

    def close(self) -> None:
        for file in self._files.values():
            file.close()

    def _is_new(self, message: AnyMessage) -> bool:
        life = (message.sender, message.boot_id)
        seen = self._seen.get(life, SequenceRanges())
        self._seen[life] = seen.with_number(message.sequence)
        return message.sequence not in seen


def json_line(message: AnyMessage) -> bytes:
    """One message as a line of JSON."""
    fields: dict[str, object] = {"kind": type(message).__name__.lower()}
    for name in message.__struct_fields__:
        value = getattr(message, name)
        fields[name] = value.name.lower() if hasattr(value, "name") else value
    return msgspec.json.encode(fields) + b"\n"
