"""A ground station on a simulated vehicle without sockets, and time that passes by hand."""

from __future__ import annotations

from typing import Any

from sim_bridge.autopilot.dialect import mavlink, new_codec
from sim_bridge.autopilot.node import Node
from sim_bridge.fleet import Fleet
from sim_bridge.world import World
from tests.fakes.sim_missions import sim_plan


class Asker:
    """A ground station on one connection, with the system and component ids of the recorded one."""

    def __init__(self, node: Node, system_id: int = 255, component_id: int = 190) -> None:
        self.node, self.connection = node, node.connect()
        self.codec, self._ears = new_codec(system_id, component_id), new_codec(0)

    def send(self, message: Any) -> None:
        data = message.pack(self.codec)
        self.codec.seq = (self.codec.seq + 1) % 256
        self.node.receive(self.connection, data)

    def heard(self) -> list[Any]:
        return self._ears.parse_buffer(self.node.take_output(self.connection)) or []

    def ask(self, message: Any) -> list[Any]:
        self.heard()
        self.send(message)
        return self.heard()

    def command(self, number: int, *parameters: float, system: int = 1, component: int = 1) -> list[Any]:
        values = [*parameters, *[0.0] * (7 - len(parameters))]
        return self.ask(mavlink.MAVLink_command_long_message(system, component, number, 0, *values))


class Bench:
    """One vehicle with its node; time passes by hand."""

    def __init__(self, **changes: Any) -> None:
        plan = sim_plan(**changes)
        self.fleet = Fleet(plan, World.of(plan))
        self.logged: list[str] = []
        self.node = Node(self.fleet.vehicles[0], plan.datum, self.logged.append)
        self.asker = Asker(self.node)

    def wait(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.05)):
            self.fleet.step(0.05)
            self.node.tick()

    def airborne(self) -> None:
        self.wait(6.0)
        vehicle = self.fleet.vehicles[0]
        assert vehicle.arm().accepted
        assert vehicle.take_off(20.0).accepted
        self.wait(25.0)


def kinds(messages: list[Any]) -> list[str]:
    return [message.get_type() for message in messages]


def result(messages: list[Any], command: int) -> int:
    (acknowledgement,) = [m for m in messages if m.get_type() == "COMMAND_ACK"]
    assert (acknowledgement.command, acknowledgement.target_system, acknowledgement.target_component) == (
        command, 255, 190,
    )  # fmt: skip
    return int(acknowledgement.result)
