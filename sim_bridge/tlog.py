"""Telemetry logs as ground stations keep them: every MAVLink frame behind the time at which it passed."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path

from sim_bridge.clock import SimClock

BUFFER_BYTES = 65_536
"""Written to the file at once; a frame in between costs a copy."""
MOST_BYTES = 256 * 1024 * 1024
"""A longer flight is recorded up to here."""
_STAMP = struct.Struct(">Q")


class TelemetryLogError(Exception):
    """A log that cannot be begun; its text is one sentence with the file and the mend."""


class TelemetryLog:
    """A `.tlog` file: for each frame 8 bytes of Unix microseconds, big-endian, then the frame as it was on the wire.

    MAVProxy, Mission Planner and pymavlink's mavutil open it. It ends early, and says so, when it has become
    `most_bytes` long or the disk is full; the flight goes on.
    """

    def __init__(self, path: Path, clock: SimClock, note: Callable[[str], None], most_bytes: int = MOST_BYTES) -> None:
        self._path = path
        self._clock = clock
        self._note = note
        self._left_bytes = most_bytes
        try:
            self._file = path.open("wb", BUFFER_BYTES)
        except OSError as error:
            raise TelemetryLogError(
                f"{path}: cannot be written ({error.strerror}); choose another --tlog-dir"
            ) from None

    def write(self, frame: bytes | bytearray) -> None:
        """Keep one frame, stamped with simulated time."""
        self._left_bytes -= _STAMP.size + len(frame)
        if self._left_bytes < 0:
            if not self._file.closed:
                self._end("it is long enough")
            return
        try:
            self._file.write(_STAMP.pack(self._clock.unix_us) + frame)
        except OSError as error:
            self._end(str(error.strerror))

    def close(self) -> None:
        """Write out what waits; once closed nothing happens."""
        try:
            self._file.close()
        except OSError as error:
            self._note(f"{self._path}: its end is lost ({error.strerror})")

    def _end(self, reason: str) -> None:
        self._left_bytes = -1
        self._note(f"{self._path}: the record ends here ({reason})")
        self.close()
