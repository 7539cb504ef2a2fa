"""A pilot's sticks from a ground station: only the throttle counts, which starts a mission on the ground."""

from __future__ import annotations

from sim_bridge.autopilot.dialect import Message
from sim_bridge.autopilot.service import Client, MessageHandler, Service
from sim_bridge.modes import Behaviour

RAISED_PWM = 1_200
FASTEST_PWM = 2_200
RAISED_SHARE = 100
"""Of MANUAL_CONTROL's throttle, out of 1000."""


class StickService(Service):
    """In AUTO an armed vehicle on the ground waits for the throttle or for MISSION_START, as ArduCopter."""

    def handlers(self) -> dict[str, MessageHandler]:
        return {"RC_CHANNELS_OVERRIDE": self._on_override, "MANUAL_CONTROL": self._on_manual_control}

    def _on_override(self, client: Client, message: Message) -> None:
        if message.target_system == self.node.system_id and RAISED_PWM <= message.chan3_raw <= FASTEST_PWM:
            self._raise_throttle()

    def _on_manual_control(self, client: Client, message: Message) -> None:
        if message.target == self.node.system_id and message.z >= RAISED_SHARE:
            self._raise_throttle()

    def _raise_throttle(self) -> None:
        vehicle = self.node.vehicle
        if vehicle.behaviour is Behaviour.AUTO and vehicle.armed and vehicle.landed and not vehicle.auto_flight.running:
            vehicle.start_mission()
