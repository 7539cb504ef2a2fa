"""The fence's state: FENCE_STATUS, and switching it on and off by command."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import CommandHandler, CommandRequest, MessageBuilder, Service
from sim_bridge.reply import Outcome, StatusText

if TYPE_CHECKING:
    from sim_bridge.autopilot.node import Node

SWITCH = "FENCE_ENABLE"
BREACHES = {"Max Alt": mavlink.FENCE_BREACH_MAXALT, "Min Alt": mavlink.FENCE_BREACH_MINALT}
"""Parts of the fence to FENCE_BREACH; every other part is its boundary."""


class FenceService(Service):
    """Says nothing while the fence is off, as ArduPilot."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self._breaches = 0
        self._last_breach_ms = 0
        node.text_listeners.append(self._note)

    def commands(self) -> dict[int, CommandHandler]:
        return {mavlink.MAV_CMD_DO_FENCE_ENABLE: self._enable}

    def builders(self) -> dict[int, MessageBuilder]:
        return {mavlink.MAVLINK_MSG_ID_FENCE_STATUS: self.fence_status}

    def fence_status(self) -> Message | None:
        vehicle = self.node.vehicle
        if vehicle.settings.fence.action is None:
            return None
        part = vehicle.fence_breach()
        kind = mavlink.FENCE_BREACH_NONE if part is None else BREACHES.get(part, mavlink.FENCE_BREACH_BOUNDARY)
        return mavlink.MAVLink_fence_status_message(
            int(part is not None), min(self._breaches, 0xFFFF), kind, self._last_breach_ms
        )

    def _note(self, status: StatusText) -> None:
        if status.text.endswith("fence breached"):
            self._breaches += 1
            self._last_breach_ms = self.node.time_boot_ms

    def _enable(self, request: CommandRequest) -> Outcome:
        if SWITCH not in self.node.vehicle.parameters:
            return Outcome.UNSUPPORTED
        if request.parameters[0] not in (0, 1):
            return Outcome.DENIED
        return self.node.vehicle.set_parameter(SWITCH, request.parameters[0]).outcome
