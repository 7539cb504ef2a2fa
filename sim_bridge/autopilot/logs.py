"""The log protocol: one log per flight of this boot, holding its status texts; listed and read while disarmed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import Client, MessageHandler, Service
from sim_bridge.reply import StatusText

if TYPE_CHECKING:
    from sim_bridge.autopilot.node import Node

PIECE_BYTES = 90
PIECES_PER_TICK = 40
MOST_LOGS = 20
MOST_LINES = 2_000


class LogService(Service):
    """Logs are numbered from 1."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self._logs: list[tuple[int, list[bytes]]] = []
        self._was_armed = False
        self._reading: dict[Client, tuple[int, int, int]] = {}
        node.text_listeners.append(self.note)

    def handlers(self) -> dict[str, MessageHandler]:
        return {
            "LOG_REQUEST_LIST": self._on_request_list,
            "LOG_REQUEST_DATA": self._on_request_data,
            "LOG_REQUEST_END": self._on_request_end,
            "LOG_ERASE": self._on_erase,
        }

    def forget(self, client: Client) -> None:
        self._reading.pop(client, None)

    def note(self, text: StatusText) -> None:
        """Write a status text into the log of the present flight."""
        if self._logs and self.node.vehicle.armed and len(self._logs[-1][1]) < MOST_LINES:
            stamp = self.node.time_boot_ms
            self._logs[-1][1].append(f"{stamp} {text.severity} {text.text}\n".encode("ascii", "replace"))

    def tick(self) -> None:
        armed = self.node.vehicle.armed
        if armed and not self._was_armed:
            self._logs.append((self.node.vehicle.clock.unix_ms // 1000, [b"fieldfleet simulated flight\n"]))
            del self._logs[:-MOST_LOGS]
        self._was_armed = armed
        for client, (number, offset, end) in list(self._reading.items()):
            data = b"".join(self._logs[number - 1][1]) if number <= len(self._logs) else b""
            for _ in range(PIECES_PER_TICK):
                if offset >= end:
                    break
                piece = data[offset : min(offset + PIECE_BYTES, end)]
                self.node.send(client, _data(number, offset, piece))
                offset += PIECE_BYTES
                if len(piece) < PIECE_BYTES:
                    offset = end
            if offset >= end:
                del self._reading[client]
            else:
                self._reading[client] = (number, offset, end)

    def _refused(self, client: Client) -> bool:
        if self.node.vehicle.armed:
            self.node.send_text(client, StatusText(3, "Disarm for log download"))
        return bool(self.node.vehicle.armed)

    def _on_request_list(self, client: Client, message: Message) -> None:
        if self._refused(client):
            return
        count = len(self._logs)
        if count == 0:
            self.node.send(client, mavlink.MAVLink_log_entry_message(0, 0, 0, 0, 0))
        for number in range(max(message.start, 1), min(message.end, count) + 1):
            began_s, lines = self._logs[number - 1]
            size = sum(map(len, lines))
            self.node.send(client, mavlink.MAVLink_log_entry_message(number, count, count, began_s, size))

    def _on_request_data(self, client: Client, message: Message) -> None:
        if not self._refused(client) and 1 <= message.id <= len(self._logs):
            self._reading[client] = (message.id, message.ofs, message.ofs + message.count)

    def _on_request_end(self, client: Client, message: Message) -> None:
        self._reading.pop(client, None)

    def _on_erase(self, client: Client, message: Message) -> None:
        if not self._refused(client):
            self._logs.clear()
            self._reading.clear()


def _data(number: int, offset: int, piece: bytes) -> Message:
    padded = piece.ljust(PIECE_BYTES, b"\0")
    return mavlink.MAVLink_log_data_message(number, offset, len(piece), list(padded))
