"""Where the mission stands: MISSION_CURRENT, MISSION_ITEM_REACHED, going to another item, starting."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import Client, CommandHandler, CommandRequest, MessageBuilder, MessageHandler, Service
from sim_bridge.modes import Behaviour
from sim_bridge.reply import Outcome

if TYPE_CHECKING:
    from sim_bridge.autopilot.node import Node


class MissionProgressService(Service):
    """Tells every client when the mission moves on."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self._told_current = 0

    def handlers(self) -> dict[str, MessageHandler]:
        return {"MISSION_SET_CURRENT": self._on_set_current}

    def commands(self) -> dict[int, CommandHandler]:
        return {
            mavlink.MAV_CMD_DO_SET_MISSION_CURRENT: self._set_current,
            mavlink.MAV_CMD_MISSION_START: self._start,
        }

    def builders(self) -> dict[int, MessageBuilder]:
        return {mavlink.MAVLINK_MSG_ID_MISSION_CURRENT: self.mission_current}

    def mission_current(self) -> Message:
        vehicle = self.node.vehicle
        total = max(len(vehicle.flight_plan.mission) - 1, 0)
        in_auto = vehicle.behaviour is Behaviour.AUTO
        flight = vehicle.auto_flight
        return mavlink.MAVLink_mission_current_message(flight.current, total, int(flight.state), int(in_auto))

    def tick(self) -> None:
        flight = self.node.vehicle.auto_flight
        for index in flight.drain_reached():
            self.node.broadcast(mavlink.MAVLink_mission_item_reached_message(index))
        if flight.current != self._told_current:
            self._told_current = flight.current
            self.node.broadcast(self.mission_current())

    def _on_set_current(self, client: Client, message: Message) -> None:
        """Clients take MISSION_CURRENT for the acknowledgement, so a refusal is silence."""
        if self.node.vehicle.auto_flight.set_current(message.seq):
            self.node.send(client, self.mission_current())
        else:
            self.node.log(f"MISSION_SET_CURRENT refused: there is no item {message.seq}")

    def _set_current(self, request: CommandRequest) -> Outcome:
        index, reset = request.parameters[:2]
        flight = self.node.vehicle.auto_flight
        if reset == 1:
            flight.reset()
        if not math.isfinite(index) or not flight.set_current(int(index)):
            return Outcome.DENIED
        request.afterwards.append(self.mission_current())
        return Outcome.ACCEPTED

    def _start(self, request: CommandRequest) -> Outcome:
        if request.parameters[0] != 0 or request.parameters[1] != 0:
            return Outcome.DENIED
        return self.node.vehicle.start_mission().outcome
