"""MAVLink FTP, reading only: directories, files and their checksums; how ground stations load parameters quickly.

Sessions belong to a connection, so that clients with the same session number do not disturb each other.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.files import content, directory
from sim_bridge.autopilot.service import Client, MessageHandler, Service

if TYPE_CHECKING:
    from sim_bridge.autopilot.node import Node

HEADER = struct.Struct("<HBBBBBBI")
MOST_DATA = 239
MOST_SESSIONS = 16
"""Per connection; a new one takes the place of the oldest."""
BURST_PER_TICK = 40
READ_ONLY = 30
"""errno EROFS: nothing here can be written."""


class Opcode(IntEnum):
    """What a client asks for, and the two answers."""

    NONE = 0
    TERMINATE_SESSION = 1
    RESET_SESSIONS = 2
    LIST_DIRECTORY = 3
    OPEN_FILE_RO = 4
    READ_FILE = 5
    CREATE_FILE = 6
    WRITE_FILE = 7
    REMOVE_FILE = 8
    CREATE_DIRECTORY = 9
    REMOVE_DIRECTORY = 10
    OPEN_FILE_WO = 11
    TRUNCATE_FILE = 12
    RENAME = 13
    CALC_FILE_CRC32 = 14
    BURST_READ_FILE = 15
    ACK = 128
    NAK = 129


class Failure(IntEnum):
    """Why it is refused."""

    FAIL = 1
    FAIL_ERRNO = 2
    INVALID_DATA_SIZE = 3
    END_OF_FILE = 6
    UNKNOWN_COMMAND = 7
    FILE_NOT_FOUND = 10


WRITING = frozenset({
    Opcode.CREATE_FILE, Opcode.REMOVE_FILE, Opcode.CREATE_DIRECTORY, Opcode.REMOVE_DIRECTORY, Opcode.OPEN_FILE_WO,
    Opcode.RENAME,
})  # fmt: skip
SessionKey = tuple[int, int, int]
"""System id, component id and session number of a client."""


@dataclass(frozen=True, slots=True)
class Request:
    """One request, taken apart."""

    system_id: int
    component_id: int
    sequence: int
    session: int
    opcode: int
    size: int
    offset: int
    data: bytes

    @property
    def key(self) -> SessionKey:
        return (self.system_id, self.component_id, self.session)

    @property
    def path(self) -> str:
        return self.data.partition(b"\0")[0].decode("ascii", "replace")


@dataclass(slots=True)
class Burst:
    """A file that is being sent without further requests."""

    request: Request
    offset: int
    sequence: int


class FtpService(Service):
    """Answers FILE_TRANSFER_PROTOCOL; nothing can be written."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self._files: dict[Client, dict[SessionKey, bytes]] = {}
        self._bursts: dict[Client, dict[SessionKey, Burst]] = {}
        self._answered: dict[Client, tuple[Request, Message]] = {}

    def handlers(self) -> dict[str, MessageHandler]:
        return {"FILE_TRANSFER_PROTOCOL": self._on_request}

    def forget(self, client: Client) -> None:
        for kept in (self._files, self._bursts, self._answered):
            kept.pop(client, None)

    def tick(self) -> None:
        for client, bursts in list(self._bursts.items()):
            for key, burst in list(bursts.items()):
                if not self._send_burst(client, burst):
                    del bursts[key]
            if not bursts:
                del self._bursts[client]

    def _on_request(self, client: Client, message: Message) -> None:
        payload = bytes(message.payload)
        sequence, session, opcode, size, _, _, _, offset = HEADER.unpack_from(payload)
        request = Request(
            message.get_srcSystem(), message.get_srcComponent(), sequence, session, opcode, size, offset,
            payload[HEADER.size : HEADER.size + min(size, MOST_DATA)],
        )  # fmt: skip
        answered = self._answered.get(client)
        if answered is not None and answered[0] == request:
            self.node.send(client, answered[1])
            return
        answer = self._answer(client, request)
        if answer is not None:
            self._answered[client] = (request, answer)
            self.node.send(client, answer)

    def _answer(self, client: Client, request: Request) -> Message | None:
        if request.opcode == Opcode.NONE:
            return _reply(request, Opcode.ACK)
        if request.opcode in (Opcode.ACK, Opcode.NAK):
            return None
        if request.size > MOST_DATA:
            return _refusal(request, Failure.INVALID_DATA_SIZE)
        if request.opcode == Opcode.TERMINATE_SESSION:
            self._close(client, request.key)
            return _reply(request, Opcode.ACK)
        if request.opcode == Opcode.RESET_SESSIONS:
            self._files.pop(client, None)
            self._bursts.pop(client, None)
            return _reply(request, Opcode.ACK)
        if request.opcode == Opcode.LIST_DIRECTORY:
            return self._list(request)
        if request.opcode == Opcode.OPEN_FILE_RO:
            return self._open(client, request)
        if request.opcode == Opcode.CALC_FILE_CRC32:
            data = content(self.node, request.path)
            if data is None:
                return _refusal(request, Failure.FILE_NOT_FOUND)
            return _reply(request, Opcode.ACK, struct.pack("<I", checksum(data)))
        if request.opcode == Opcode.READ_FILE:
            return self._read(client, request)
        if request.opcode == Opcode.BURST_READ_FILE:
            return self._begin_burst(client, request)
        if request.opcode in WRITING:
            return _refusal(request, Failure.FAIL_ERRNO, READ_ONLY)
        if request.opcode == Opcode.WRITE_FILE:
            is_open = request.key in self._files.get(client, {})
            return _refusal(request, Failure.FAIL if is_open else Failure.FILE_NOT_FOUND)
        return _refusal(request, Failure.UNKNOWN_COMMAND)

    def _close(self, client: Client, key: SessionKey) -> None:
        self._files.get(client, {}).pop(key, None)
        self._bursts.get(client, {}).pop(key, None)

    def _open(self, client: Client, request: Request) -> Message:
        data = content(self.node, request.path)
        if data is None:
            return _refusal(request, Failure.FILE_NOT_FOUND)
        files = self._files.setdefault(client, {})
        files.pop(request.key, None)
        if len(files) >= MOST_SESSIONS:
            self._close(client, next(iter(files)))
        files[request.key] = data
        return _reply(request, Opcode.ACK, struct.pack("<I", len(data)))

    def _list(self, request: Request) -> Message:
        entries = directory(self.node, request.path)
        if entries is None:
            return _refusal(request, Failure.FILE_NOT_FOUND)
        listed = b""
        for entry in entries[request.offset :]:
            line = entry.encode("ascii") + b"\0"
            if len(listed) + len(line) > MOST_DATA:
                break
            listed += line
        return _reply(request, Opcode.ACK, listed) if listed else _refusal(request, Failure.END_OF_FILE)

    def _read(self, client: Client, request: Request) -> Message:
        data = self._files.get(client, {}).get(request.key)
        if data is None:
            return _refusal(request, Failure.FILE_NOT_FOUND)
        piece = data[request.offset : request.offset + (request.size or MOST_DATA)]
        return _reply(request, Opcode.ACK, piece) if piece else _refusal(request, Failure.END_OF_FILE)

    def _begin_burst(self, client: Client, request: Request) -> Message | None:
        if request.key not in self._files.get(client, {}):
            return _refusal(request, Failure.FILE_NOT_FOUND)
        burst = Burst(request, request.offset, request.sequence)
        if self._send_burst(client, burst):
            self._bursts.setdefault(client, {})[request.key] = burst
        else:
            self._bursts.get(client, {}).pop(request.key, None)
        return None

    def _send_burst(self, client: Client, burst: Burst) -> bool:
        """Send the next pieces; False once the end has been told."""
        data = self._files.get(client, {}).get(burst.request.key)
        if data is None:
            return False
        size = burst.request.size or MOST_DATA
        for _ in range(BURST_PER_TICK):
            piece = data[burst.offset : burst.offset + size]
            if not piece:
                self.node.send(client, _refusal(burst.request, Failure.END_OF_FILE, None, burst.sequence, burst.offset))
                return False
            self.node.send(client, _reply(burst.request, Opcode.ACK, piece, burst.sequence, burst.offset))
            burst.offset += len(piece)
            burst.sequence += 1
        return True


def checksum(data: bytes) -> int:
    """CRC-32 that begins at zero and is not inverted, as this protocol has it."""
    return zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


def _reply(
    request: Request, opcode: Opcode, data: bytes = b"", sequence: int | None = None, offset: int | None = None
) -> Message:
    number = (request.sequence if sequence is None else sequence) + 1
    head = HEADER.pack(
        number & 0xFFFF, request.session, opcode, len(data), request.opcode, 0, 0,
        request.offset if offset is None else offset,
    )  # fmt: skip
    payload = (head + data).ljust(HEADER.size + MOST_DATA, b"\0")
    return mavlink.MAVLink_file_transfer_protocol_message(0, request.system_id, request.component_id, list(payload))


def _refusal(
    request: Request, failure: Failure, errno: int | None = None, sequence: int | None = None, offset: int | None = None
) -> Message:
    data = bytes((failure,)) if errno is None else bytes((failure, errno))
    return _reply(request, Opcode.NAK, data, sequence, offset)
