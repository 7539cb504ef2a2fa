"""The parameter protocol: list, read and set, by name or by index."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator
from typing import TYPE_CHECKING

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import Client, MessageHandler, Service
from sim_bridge.parameters import Parameter, ParameterType

if TYPE_CHECKING:
    from sim_bridge.autopilot.node import Node

LISTED_PER_TICK = 60
BY_NAME_INDEX = 65535
"""ArduPilot's index in answers to a read or set by name."""
HASH_NAME = "_HASH_CHECK"


class ParameterService(Service):
    """Values travel as floats whatever their type (ArduPilot's "C cast") or bytewise (PX4); unknown names: silence."""

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
        if self._bytewise and row.kind is not ParameterType.REAL32:
            value = integer_as_float(int(value))
        return mavlink.MAVLink_param_value_message(
            row.name.encode("ascii"), value, int(row.kind), len(table), told_index
        )

    @property
    def _bytewise(self) -> bool:
        return self.node.vehicle.personality.bytewise_parameters

    def _on_request_list(self, client: Client, message: Message) -> None:
        self._listings[client] = iter(range(len(self.node.vehicle.parameters)))

    def _on_request_read(self, client: Client, message: Message) -> None:
        table = self.node.vehicle.parameters
        if message.param_index >= 0:
            if message.param_index < len(table):
                self.node.send(client, self._value(message.param_index, message.param_index))
        elif message.param_id == HASH_NAME and self._bytewise:
            self.node.send(client, self._hash())
        elif message.param_id in table:
            self.node.send(client, self._value(table.index_of(message.param_id), BY_NAME_INDEX))

    def _hash(self) -> Message:
        """PX4's checksum of all parameters, by which a client knows whether those it has kept are still right."""
        table, checksum = self.node.vehicle.parameters, 0
        for name in table:
            row, value = table.at(table.index_of(name))
            number = struct.pack("<f", value) if row.kind is ParameterType.REAL32 else struct.pack("<i", int(value))
            checksum = zlib.crc32(name.encode("ascii") + number, checksum)
        as_float = struct.unpack("<f", struct.pack("<I", checksum))[0]
        return mavlink.MAVLink_param_value_message(
            HASH_NAME.encode("ascii"), as_float, mavlink.MAV_PARAM_TYPE_UINT32, len(table), BY_NAME_INDEX
        )

    def _on_set(self, client: Client, message: Message) -> None:
        vehicle, name = self.node.vehicle, message.param_id
        if name in vehicle.parameters:
            value = message.param_value
            row, _ = vehicle.parameters.at(vehicle.parameters.index_of(name))
            if self._bytewise and row.kind is not ParameterType.REAL32:
                value = float(float_as_integer(value))
            if not vehicle.set_parameter(name, value).accepted:
                vehicle.say(4, f"Param write denied ({name})")
                self.node.log(f"PARAM_SET {name} to {value:g} refused: {_told_range(row)}")
            self.node.broadcast(self._value(vehicle.parameters.index_of(name), BY_NAME_INDEX))


def _told_range(row: Parameter) -> str:
    limited = math.isfinite(row.low) or math.isfinite(row.high)
    return f"it takes {row.low:g} to {row.high:g}" if limited else "it takes finite numbers only"


def integer_as_float(value: int) -> float:
    """The float whose bytes are those of a 32-bit integer."""
    return float(struct.unpack("<f", struct.pack("<i", value))[0])


def float_as_integer(value: float) -> int:
    """The 32-bit integer whose bytes are those of a float."""
    return int(struct.unpack("<i", struct.pack("<f", value))[0])
