"""Records that survive the death of their agent: the `Journal` port over one append-only file.

The file is a magic word followed by frames: payload length u32 and CRC-32 of the payload u32, little endian, then the
payload. The first frame says which vehicle of which mission the file belongs to. Every append is one `os.write`, so it
survives the death of the process at once; it is forced to the disk (`fsync`) at the latest one second later, given
that somebody appends or calls `sync_if_due`, so a power cut costs at most that second.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import stat
import struct
import time
import zlib
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import msgspec

from vehicle_agent.mission.load import MissionPlan

MAGIC = b"fieldfleet-journal-1\n"
SYNC_PERIOD_S = 1.0
MAX_RECORD_BYTES = 4_000_000
_FRAME = struct.Struct("<II")


class JournalError(Exception):
    """A journal that cannot be used; its text is one sentence with the file and the mend."""


class JournalHeader(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Whose journal a file is; records mean something only on the same cells."""

    mission: str
    vehicle: str
    grid_fingerprint: str

    @classmethod
    def of(cls, plan: MissionPlan, vehicle: str) -> JournalHeader:
        """Header of one vehicle's journal; the fingerprint covers the datum, the grid and the area's cells."""
        digest = hashlib.sha256(repr((plan.datum, plan.grid)).encode())
        digest.update(plan.area_cells.tobytes())
        if plan.voxel_grid is not None:
            digest.update(repr(plan.voxel_grid).encode())
        return cls(plan.mission.name, vehicle, digest.hexdigest()[:32])


class FileJournal:
    """An open journal, locked against a second agent.

    Attributes
    ----------
    torn_bytes
        Bytes of a half-written tail that were cut off on opening.
    """

    def __init__(self, path: Path, descriptor: int, clock: Callable[[], float]) -> None:
        self.path = path
        self.torn_bytes = 0
        self._descriptor = descriptor
        self._clock = clock
        self._end = 0
        self._records: list[bytes] = []
        self._last_sync_s = clock()
        self._dirty = False

    @classmethod
    def open(cls, path: Path, header: JournalHeader, clock: Callable[[], float] = time.monotonic) -> FileJournal:
        """Open or begin a journal, cutting off a torn tail.

        Raises
        ------
        JournalError
            When the file cannot be written, is held by another agent, is not a journal, or belongs to another vehicle
            or mission.
        """
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        except OSError as error:
            raise JournalError(f"{path}: cannot be opened ({error.strerror}); choose another --run-dir") from None
        journal = cls(path, descriptor, clock)
        try:
            journal._load(header)
        except OSError as error:
            journal.close()
            raise JournalError(f"{path}: cannot be read or written ({error.strerror}); mend the disk") from None
        except JournalError:
            journal.close()
            raise
        return journal

    def records(self) -> Iterable[bytes]:
        """Every whole record of earlier runs, oldest first."""
        return iter(self._records)

    def append(self, records: Sequence[bytes]) -> None:
        """Write records behind the last; raises JournalError, leaving whole records only, when the disk refuses."""
        if not records:
            return
        data = b"".join(_frame(record) for record in records)
        try:
            written = os.pwrite(self._descriptor, data, self._end)
            if written != len(data):
                os.ftruncate(self._descriptor, self._end)
                raise JournalError(f"{self.path}: the disk is full; make room")
        except OSError as error:
            raise JournalError(
                f"{self.path}: cannot be written ({error.strerror}); make room or mend the disk"
            ) from None
        self._end += len(data)
        self._dirty = True
        self.sync_if_due()

    def sync_if_due(self) -> None:
        """Force what was written to the disk if the last time is a second ago."""
        if self._dirty and self._clock() - self._last_sync_s >= SYNC_PERIOD_S:
            os.fsync(self._descriptor)
            self._dirty = False
            self._last_sync_s = self._clock()

    def close(self) -> None:
        if self._descriptor >= 0:
            if self._dirty:
                os.fsync(self._descriptor)
            os.close(self._descriptor)
            self._descriptor = -1

    def _load(self, header: JournalHeader) -> None:
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise JournalError(
                f"{self.path}: another agent is using this journal; end it, or choose another --run-dir"
            ) from None
        if not stat.S_ISREG(os.fstat(self._descriptor).st_mode):
            raise JournalError(f"{self.path}: is not a journal; choose another --run-dir")
        content = _read_all(self._descriptor)
        if not content.startswith(MAGIC) and not MAGIC.startswith(content):
            raise JournalError(f"{self.path}: is not a journal; move it away or choose another --run-dir")
        frames, self._end = _parse(content)
        if not frames:
            # New, or its agent died while beginning it: nothing was said on its strength yet.
            self.torn_bytes = len(content)
            os.ftruncate(self._descriptor, 0)
            start = MAGIC + _frame(msgspec.json.encode(header))
            if os.pwrite(self._descriptor, start, 0) != len(start):
                raise JournalError(f"{self.path}: the disk is full; make room")
            self._end = len(start)
            self._dirty = True
            return
        self._check_owner(frames[0], header)
        self.torn_bytes = len(content) - self._end
        if self.torn_bytes:
            os.ftruncate(self._descriptor, self._end)
        self._records = frames[1:]

    def _check_owner(self, first: bytes, header: JournalHeader) -> None:
        try:
            found = msgspec.json.decode(first, type=JournalHeader)
        except msgspec.DecodeError:
            raise JournalError(f"{self.path}: has no readable header; move it away") from None
        if (found.mission, found.vehicle) != (header.mission, header.vehicle):
            raise JournalError(
                f"{self.path}: is the journal of {found.vehicle} in mission {found.mission}, not of {header.vehicle} "
                f"in {header.mission}; choose another --run-dir"
            )
        if found.grid_fingerprint != header.grid_fingerprint:
            raise JournalError(
                f"{self.path}: was written for another area or cell size of mission {found.mission}; choose another "
                f"--run-dir or restore the mission file as flown"
            )


def _frame(record: bytes) -> bytes:
    if len(record) > MAX_RECORD_BYTES:
        raise ValueError(f"a journal record of {len(record)} bytes is longer than {MAX_RECORD_BYTES}")
    return _FRAME.pack(len(record), zlib.crc32(record)) + record


def _parse(content: bytes) -> tuple[list[bytes], int]:
    """Whole frames from the start on, and the offset where they end."""
    frames: list[bytes] = []
    offset = len(MAGIC)
    while offset + _FRAME.size <= len(content):
        length, checksum = _FRAME.unpack_from(content, offset)
        end = offset + _FRAME.size + length
        if length > MAX_RECORD_BYTES or end > len(content):
            break
        record = content[offset + _FRAME.size : end]
        if zlib.crc32(record) != checksum:
            break
        frames.append(record)
        offset = end
    return frames, offset


def _read_all(descriptor: int) -> bytes:
    parts = []
    offset = 0
    while part := os.pread(descriptor, 1 << 20, offset):
        parts.append(part)
        offset += len(part)
    return b"".join(parts)
