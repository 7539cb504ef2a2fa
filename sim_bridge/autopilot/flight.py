"""Commands that change what the vehicle does: arming, flight modes, take-off, landing, return, speed."""

from __future__ import annotations

import math

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import Client, CommandHandler, CommandRequest, MessageHandler, Service
from sim_bridge.modes import Behaviour
from sim_bridge.reply import Outcome

FORCE_ARM = 2989
FORCE_DISARM = 21196
"""ArduPilot's numbers in parameter 2 that skip the checks."""


class FlightService(Service):
    """Maps commands to the vehicle's orders."""

    def handlers(self) -> dict[str, MessageHandler]:
        return {"SET_MODE": self._on_set_mode}

    def commands(self) -> dict[int, CommandHandler]:
        return {
            mavlink.MAV_CMD_COMPONENT_ARM_DISARM: self._arm_disarm,
            mavlink.MAV_CMD_DO_SET_MODE: self._set_mode,
            mavlink.MAV_CMD_NAV_TAKEOFF: self._take_off,
            mavlink.MAV_CMD_NAV_LAND: lambda _: self._enter(Behaviour.LAND),
            mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH: lambda _: self._enter(Behaviour.RETURN),
            mavlink.MAV_CMD_NAV_LOITER_UNLIM: lambda _: self._enter(Behaviour.HOLD),
            mavlink.MAV_CMD_DO_CHANGE_SPEED: self._change_speed,
        }

    def _enter(self, behaviour: Behaviour) -> Outcome:
        return self.node.vehicle.enter(behaviour).outcome

    def _change_mode(self, number: int) -> Outcome:
        return self.node.vehicle.set_mode(number).outcome

    def _on_set_mode(self, client: Client, message: Message) -> None:
        self._change_mode(message.custom_mode)

    def _set_mode(self, request: CommandRequest) -> Outcome:
        base_mode, custom_mode, sub_mode = request.parameters[:3]
        if not (math.isfinite(base_mode) and math.isfinite(custom_mode)):
            return Outcome.DENIED
        if not int(base_mode) & mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED:
            return Outcome.UNSUPPORTED
        if self.node.vehicle.personality.packed_modes:
            sub = int(sub_mode) if math.isfinite(sub_mode) else 0
            return self._change_mode(int(custom_mode) << 16 | sub << 24)
        return self._change_mode(int(custom_mode))

    def _arm_disarm(self, request: CommandRequest) -> Outcome:
        wanted, magic = request.parameters[:2]
        if wanted == 1:
            return self.node.vehicle.arm_motors(force=magic == FORCE_ARM).outcome
        if wanted == 0:
            return self.node.vehicle.disarm(force=magic == FORCE_DISARM).outcome
        return Outcome.UNSUPPORTED

    def _take_off(self, request: CommandRequest) -> Outcome:
        vehicle, height_m = self.node.vehicle, request.z
        if vehicle.personality.takeoff_altitude_amsl and vehicle.home_enu_m is not None:
            height_m -= self.node.datum.altitude_amsl_m + vehicle.home_enu_m[2]
        return vehicle.start_takeoff(height_m).outcome

    def _change_speed(self, request: CommandRequest) -> Outcome:
        kind, speed_m_s = request.parameters[:2]
        if kind not in (0, 1):
            return Outcome.UNSUPPORTED
        return self.node.vehicle.set_speed(speed_m_s).outcome
