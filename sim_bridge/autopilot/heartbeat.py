"""HEARTBEAT, out once a simulated second and in from the controller that is watched."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import Client, MessageBuilder, MessageHandler, Service
from sim_bridge.modes import Behaviour

if TYPE_CHECKING:
    from sim_bridge.autopilot.node import Node

PERIOD_US = 1_000_000
PILOTED = frozenset({Behaviour.PILOTED, Behaviour.DEPTH_HOLD, Behaviour.TRACK_BOTTOM, Behaviour.STARTING})


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
        vehicle, personality = self.node.vehicle, self.node.vehicle.personality
        piloted = vehicle.behaviour in PILOTED
        base_mode = personality.base_mode_piloted if piloted else personality.base_mode_automatic
        armed = mavlink.MAV_MODE_FLAG_SAFETY_ARMED if vehicle.armed else 0
        return mavlink.MAVLink_heartbeat_message(
            personality.mav_type,
            personality.autopilot,
            base_mode | armed,
            int(vehicle.mode),
            self._system_status(),
            3,
        )

    def _system_status(self) -> int:
        vehicle = self.node.vehicle
        if vehicle.behaviour is Behaviour.STARTING:
            return int(mavlink.MAV_STATE_CALIBRATING)
        if vehicle.home_enu_m is None:
            return int(mavlink.MAV_STATE_BOOT)
        if vehicle.armed and vehicle.failsafe_active:
            return int(mavlink.MAV_STATE_CRITICAL)
        return int(mavlink.MAV_STATE_STANDBY if vehicle.landed else mavlink.MAV_STATE_ACTIVE)

    def _on_heartbeat(self, client: Client, message: Message) -> None:
        self.node.vehicle.heard_controller(message.get_srcSystem())
