"""The parameter protocol: list, read and set, by name or by index."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import Client, MessageHandler, Service

if TYPE_CHECKING:
    from sim_bridge.autopilot.node import Node

LISTED_PER_TICK = 60
BY_NAME_INDEX = 65535
"""ArduPilot's index in answers to a read or set by name."""


class ParameterService(Service):
    """Values travel as floats whatever their type (ArduPilot's "C cast"); unknown names get silence."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self._listings: dict[Client, Iterator[int]] = {}

    def handlers(self) -> dict[str, MessageHandler]:
        return {
            "PARAM_REQUEST_LIST": self._on_request_list,
            "PARAM_REQUEST_READ": self._on_request_read,
            "PARAM_SET": self._on_set,
        }

    def tick(self) -> None:
        for client, indices in list(self._listings.items()):
            for _ in range(LISTED_PER_TICK):
                index = next(indices, None)
                if index is None:
                    del self._listings[client]
                    break
                self.node.send(client, self._value(index, index))

    def forget(self, client: Client) -> None:
        self._listings.pop(client, None)

    def _value(self, index: int, told_index: int) -> Message:
        table = self.node.vehicle.parameters
        row, value = table.at(index)
        return mavlink.MAVLink_param_value_message(
            row.name.encode("ascii"), value, int(row.kind), len(table), told_index
        )

    def _on_request_list(self, client: Client, message: Message) -> None:
        self._listings[client] = iter(range(len(self.node.vehicle.parameters)))

    def _on_request_read(self, client: Client, message: Message) -> None:
        table = self.node.vehicle.parameters
        if message.param_index >= 0:
            if message.param_index < len(table):
                self.node.send(client, self._value(message.param_index, message.param_index))
        elif message.param_id in table:
            self.node.send(client, self._value(table.index_of(message.param_id), BY_NAME_INDEX))

    def _on_set(self, client: Client, message: Message) -> None:
        vehicle, name = self.node.vehicle, message.param_id
        if name in vehicle.parameters:
            vehicle.set_parameter(name, message.param_value)
            self.node.broadcast(self._value(vehicle.parameters.index_of(name), BY_NAME_INDEX))
