"""The command protocol: COMMAND_LONG and COMMAND_INT in, COMMAND_ACK out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import Client, CommandRequest, MessageHandler, Service
from sim_bridge.reply import Outcome

if TYPE_CHECKING:
    from sim_bridge.autopilot.node import Node

REPEATED_WITHIN_US = 30_000_000
"""A COMMAND_LONG that repeats the one before within this time was sent again because its answer got lost."""


class CommandService(Service):
    """Finds the service that carries a command out and acknowledges to whoever asked.

    A repeated COMMAND_LONG, told by its confirmation count, is acknowledged again and not carried out twice.
    """

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self._answered: dict[Client, tuple[tuple[object, ...], int, Outcome]] = {}

    def handlers(self) -> dict[str, MessageHandler]:
        return {"COMMAND_LONG": self._on_command_long, "COMMAND_INT": self._on_command_int}

    def forget(self, client: Client) -> None:
        self._answered.pop(client, None)

    def _on_command_long(self, client: Client, message: Message) -> None:
        parameters = (message.param1, message.param2, message.param3, message.param4)
        sender = (message.get_srcSystem(), message.get_srcComponent())
        request = CommandRequest(
            client, message.command, parameters, message.param5, message.param6, message.param7, None, sender
        )
        now_us = self.node.vehicle.clock.elapsed_us
        content = (sender, message.command, *parameters, message.param5, message.param6, message.param7)
        before = self._answered.get(client)
        if (
            message.confirmation > 0
            and before is not None
            and repr(before[0]) == repr(content)
            and now_us - before[1] < REPEATED_WITHIN_US
        ):
            self.node.acknowledge(request, before[2])
            return
        self._answered[client] = (content, now_us, self._carry_out(request))

    def _on_command_int(self, client: Client, message: Message) -> None:
        parameters = (message.param1, message.param2, message.param3, message.param4)
        sender = (message.get_srcSystem(), message.get_srcComponent())
        request = CommandRequest(
            client, message.command, parameters, message.x, message.y, message.z, message.frame, sender
        )
        self._carry_out(request)

    def _carry_out(self, request: CommandRequest) -> Outcome:
        handler = self.node.commands.get(request.command)
        outcome = handler(request) if handler else Outcome.UNSUPPORTED
        self.node.acknowledge(request, outcome)
        for following in request.afterwards:
            self.node.send(request.client, following)
        return outcome


def acknowledgement(request: CommandRequest, outcome: Outcome) -> Message:
    """COMMAND_ACK to whoever asked."""
    return mavlink.MAVLink_command_ack_message(request.command, int(outcome), 0, 0, *request.sender)
