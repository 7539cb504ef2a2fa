"""Listening to autopilots' heartbeats beside the fleet's link: over a telemetry radio, or at a simulated vehicle."""

from __future__ import annotations

import errno
import re
import socket
from collections.abc import Sequence

from ground_station.heartbeat import Heartbeat, HeartbeatReader
from ground_station.inputs import AutopilotHeard

RETRY_S = 2.0
READS_PER_POLL = 64
CHUNK_BYTES = 65_536
MAX_SOURCES = 256
_ENDPOINT = re.compile(r"^(udpin|tcpout)://([^\s/]+):(\d{1,5})$")


class EarsError(Exception):
    """An endpoint that cannot be listened to; one sentence with the endpoint and the mend."""


class MavlinkEars:
    """Hears and says nothing; every call returns at once.

    Parameters
    ----------
    endpoints
        `udpin://HOST:PORT` to listen, `tcpout://HOST:PORT` to connect; one that is not there is tried again.

    Raises EarsError for malformed endpoints and ports in use.
    """

    def __init__(self, endpoints: Sequence[str]) -> None:
        self._doors: list[tuple[str, socket.socket]] = []
        self._callers: list[_Caller] = []
        self._readers: dict[str, HeartbeatReader] = {}
        for endpoint in endpoints:
            match = _ENDPOINT.match(endpoint)
            if match is None or not 0 < int(match[3]) < 65_536:
                self.close()
                raise EarsError(f"{endpoint}: no MAVLink endpoint; write it like udpin://0.0.0.0:14550")
            address = (match[2], int(match[3]))
            if match[1] == "tcpout":
                self._callers.append(_Caller(endpoint, address))
            else:
                self._doors.append((endpoint, self._listening(endpoint, address)))

    def poll(self, now_s: float) -> list[AutopilotHeard]:
        """The newest heartbeat of every autopilot and source since the last call."""
        newest: dict[tuple[int, str], Heartbeat] = {}
        for _, door in self._doors:
            for data, source in _datagrams(door):
                for heartbeat in self._read(source, data):
                    newest[heartbeat.system_id, source] = heartbeat
        for caller in self._callers:
            for data in caller.received(now_s):
                for heartbeat in self._read(caller.source, data):
                    newest[heartbeat.system_id, caller.source] = heartbeat
        return [
            AutopilotHeard(one.system_id, one.armed, one.in_failsafe, source, now_s)
            for (_, source), one in newest.items()
        ]

    def close(self) -> None:
        for _, door in self._doors:
            door.close()
        for caller in self._callers:
            caller.close()

    def _read(self, source: str, data: bytes) -> list[Heartbeat]:
        if source not in self._readers and len(self._readers) >= MAX_SOURCES:
            return []
        return self._readers.setdefault(source, HeartbeatReader()).feed(data)

    def _listening(self, endpoint: str, address: tuple[str, int]) -> socket.socket:
        door = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            door.bind(address)
        except OSError as error:
            door.close()
            self.close()
            reason = (error.strerror or str(error)).lower()
            raise EarsError(f"{endpoint}: {reason}; give --mavlink a port of this machine that is free") from None
        door.setblocking(False)
        return door


class _Caller:
    """One TCP connection that is made anew whenever it is gone."""

    def __init__(self, source: str, address: tuple[str, int]) -> None:
        self.source = source
        self._address = address
        self._socket: socket.socket | None = None
        self._due_s = float("-inf")

    def received(self, now_s: float) -> list[bytes]:
        if self._socket is None:
            if now_s < self._due_s:
                return []
            self._due_s = now_s + RETRY_S
            self._socket = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
            self._socket.setblocking(False)
            if self._socket.connect_ex(self._address) not in (0, errno.EINPROGRESS):
                self.close()
                return []
        parts: list[bytes] = []
        while self._socket is not None and len(parts) < READS_PER_POLL:
            try:
                part = self._socket.recv(CHUNK_BYTES)
            except (BlockingIOError, InterruptedError):
                break
            except OSError as error:
                if error.errno != errno.ENOTCONN:  # that one is still on its way
                    self.close()
                break
            if not part:
                self.close()
                break
            parts.append(part)
        return parts

    def close(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None


def _datagrams(door: socket.socket) -> list[tuple[bytes, str]]:
    found: list[tuple[bytes, str]] = []
    while len(found) < READS_PER_POLL:
        try:
            data, (host, port, *_) = door.recvfrom(CHUNK_BYTES)
        except OSError:  # nothing more, or news of an earlier sender's death
            break
        found.append((data, f"udp {host}:{port}"))
    return found
