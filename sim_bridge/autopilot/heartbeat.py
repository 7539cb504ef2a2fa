"""HEARTBEAT, out once a simulated second and in from the controller that is watched."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import Client, MessageBuilder, MessageHandler, Service

if TYPE_CHECKING:
    from sim_bridge.autopilot.node import Node

PERIOD_US = 1_000_000
BASE_MODE = (
    mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
    | mavlink.MAV_MODE_FLAG_GUIDED_ENABLED
    | mavlink.MAV_MODE_FLAG_STABILIZE_ENABLED
    | mavlink.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
)


class HeartbeatService(Service):
    """Tells that the vehicle lives, its mode and its state."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self._due_us = 0

    def handlers(self) -> dict[str, MessageHandler]:
        return {"HEARTBEAT": self._on_heartbeat}

    def builders(self) -> dict[int, MessageBuilder]:
        return {mavlink.MAVLINK_MSG_ID_HEARTBEAT: self.heartbeat}

    def tick(self) -> None:
        now_us = self.node.vehicle.clock.elapsed_us
        if now_us >= self._due_us:
            self._due_us = max(self._due_us + PERIOD_US, now_us)
            self.node.broadcast(self.heartbeat())

    def heartbeat(self) -> Message:
        vehicle = self.node.vehicle
        armed = mavlink.MAV_MODE_FLAG_SAFETY_ARMED if vehicle.armed else 0
        return mavlink.MAVLink_heartbeat_message(
            mavlink.MAV_TYPE_QUADROTOR,
            mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA,
            BASE_MODE | armed,
            int(vehicle.mode),
            self._system_status(),
            3,
        )

    def _system_status(self) -> int:
        vehicle = self.node.vehicle
        if not vehicle.position_known:
            return int(mavlink.MAV_STATE_BOOT)
        if vehicle.armed and vehicle.failsafe_active:
            return int(mavlink.MAV_STATE_CRITICAL)
        return int(mavlink.MAV_STATE_STANDBY if vehicle.landed else mavlink.MAV_STATE_ACTIVE)

    def _on_heartbeat(self, client: Client, message: Message) -> None:
        self.node.vehicle.heard_controller(message.get_srcSystem())
