"""A ground station that asks one simulated vehicle, in one process, while simulated time passes by hand."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable
from typing import Any

os.environ.setdefault("MAVLINK20", "1")

from pymavlink.dialects.v20 import all as dialect

from sim_bridge.autopilot.node import Node
from sim_bridge.fleet import Fleet

__all__ = ["Interview", "Message", "dialect"]

STEP_S = 0.05
SYSTEM_ID, COMPONENT_ID = 255, 190
Message = Any


class Interview:
    """One connection to one vehicle of a fleet.

    Attributes
    ----------
    target
        The vehicle's system id.
    """

    def __init__(self, fleet: Fleet, index: int) -> None:
        self._fleet = fleet
        self._node = Node(fleet.vehicles[index], fleet.plan.datum)
        self._client = self._node.connect()
        self._voice = dialect.MAVLink(None, srcSystem=SYSTEM_ID, srcComponent=COMPONENT_ID)
        self._ears = dialect.MAVLink(None)
        self._ears.robust_parsing = True
        self._waiting: list[Message] = []
        self.target = fleet.plan.system_id(index)

    @property
    def time_s(self) -> float:
        return self._fleet.time_s

    def send(self, message: Message) -> None:
        data = message.pack(self._voice)
        self._voice.seq = (self._voice.seq + 1) % 256
        self._node.receive(self._client, data)

    def listen(
        self,
        kinds: tuple[str, ...] | None,
        timeout_s: float,
        most: int = 1,
        which: Callable[[Message], bool] = lambda message: True,
    ) -> list[Message]:
        """Messages of those kinds (None: all) until there are `most` of them or simulated time is up."""
        heard: list[Message] = []
        until_s = self.time_s + timeout_s
        while True:
            self._waiting.extend(self._ears.parse_buffer(self._node.take_output(self._client)) or ())
            while self._waiting and len(heard) < most:
                message = self._waiting.pop(0)
                if (kinds is None or message.get_type() in kinds) and which(message):
                    heard.append(message)
            if len(heard) >= most or self.time_s >= until_s:
                return heard
            self._fleet.step(STEP_S)
            self._node.tick()

    def drain(self, seconds: float) -> None:
        """Let time pass and forget what is said."""
        self.count(seconds)

    def count(self, seconds: float) -> Counter[str]:
        """How often each kind of message came."""
        return Counter(message.get_type() for message in self.listen(None, seconds, 10**9))

    def command(
        self,
        number: int,
        *parameters: float,
        kinds: tuple[str, ...] = ("COMMAND_ACK", "STATUSTEXT"),
        most: int = 2,
        system: int | None = None,
        component: int = 1,
    ) -> list[Message]:
        """Send COMMAND_LONG and listen for up to a second."""
        self.drain(STEP_S)
        padded = (*parameters, *(0.0,) * (7 - len(parameters)))
        target = self.target if system is None else system
        self.send(dialect.MAVLink_command_long_message(target, component, number, 0, *padded))
        return self.listen(kinds, 1.0, most)
