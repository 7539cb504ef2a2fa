"""STATUSTEXT: what the vehicle says to people, in chunks of fifty bytes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import Client, Service
from sim_bridge.reply import StatusText

if TYPE_CHECKING:
    from sim_bridge.autopilot.node import Node

CHUNK_BYTES = 50


class TextService(Service):
    """Sends the vehicle's status texts to every client, once, and hands them to the node's `text_listeners`."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self._long_texts = 0

    def tick(self) -> None:
        for status in self.node.vehicle.drain_texts():
            for message in self._messages(status):
                self.node.broadcast(message)
            for listener in self.node.text_listeners:
                listener(status)

    def send(self, client: Client, status: StatusText) -> None:
        """Tell one client only."""
        for message in self._messages(status):
            self.node.send(client, message)

    def _messages(self, status: StatusText) -> list[Message]:
        """A text as one message, or as several with an id and chunk numbers."""
        data = status.text.encode("ascii", "replace")
        if len(data) <= CHUNK_BYTES:
            return [mavlink.MAVLink_statustext_message(status.severity, data)]
        self._long_texts = self._long_texts % 0xFFFF + 1
        return [
            mavlink.MAVLink_statustext_message(
                status.severity, data[start : start + CHUNK_BYTES], self._long_texts, start // CHUNK_BYTES
            )
            for start in range(0, len(data), CHUNK_BYTES)
        ]
