"""The command protocol: COMMAND_LONG and COMMAND_INT in, COMMAND_ACK out."""

from __future__ import annotations

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import Client, CommandRequest, MessageHandler, Service
from sim_bridge.reply import Outcome


class CommandService(Service):
    """Finds the service that carries a command out and acknowledges to whoever asked."""

    def handlers(self) -> dict[str, MessageHandler]:
        return {"COMMAND_LONG": self._on_command_long, "COMMAND_INT": self._on_command_int}

    def _on_command_long(self, client: Client, message: Message) -> None:
        parameters = (message.param1, message.param2, message.param3, message.param4)
        request = CommandRequest(
            client, message.command, parameters, message.param5, message.param6, message.param7, None
        )
        self._carry_out(request, message)

    def _on_command_int(self, client: Client, message: Message) -> None:
        parameters = (message.param1, message.param2, message.param3, message.param4)
        request = CommandRequest(client, message.command, parameters, message.x, message.y, message.z, message.frame)
        self._carry_out(request, message)

    def _carry_out(self, request: CommandRequest, message: Message) -> None:
        handler = self.node.commands.get(request.command)
        outcome = handler(request) if handler else Outcome.UNSUPPORTED
        acknowledgement = mavlink.MAVLink_command_ack_message(
            request.command, int(outcome), 0, 0, message.get_srcSystem(), message.get_srcComponent()
        )
        self.node.send(request.client, acknowledgement)
        for following in request.afterwards:
            self.node.send(request.client, following)
