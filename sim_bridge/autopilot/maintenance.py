"""What is done on the ground: reboot and calibration."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sim_bridge.autopilot.dialect import mavlink
from sim_bridge.autopilot.service import Client, CommandHandler, CommandRequest, Service
from sim_bridge.reply import Outcome

if TYPE_CHECKING:
    from sim_bridge.autopilot.node import Node

FORCE_REBOOT = 20190226
"""ArduPilot's number in parameter 6 that skips the check for running motors."""
REBOOT_AFTER_US = 100_000
CALIBRATION_US = 2_000_000


class MaintenanceService(Service):
    """Reboots shortly after acknowledging; calibrates the barometer in a few seconds, everything else at once."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self._reboot_due_us: int | None = None
        self._calibrating: list[tuple[int, CommandRequest]] = []

    def commands(self) -> dict[int, CommandHandler]:
        return {
            mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN: self._reboot,
            mavlink.MAV_CMD_PREFLIGHT_CALIBRATION: self._calibrate,
        }

    def forget(self, client: Client) -> None:
        self._calibrating = [entry for entry in self._calibrating if entry[1].client is not client]

    def tick(self) -> None:
        now_us = self.node.vehicle.clock.elapsed_us
        for due_us, request in list(self._calibrating):
            if now_us >= due_us:
                self._calibrating.remove((due_us, request))
                self.node.vehicle.say(6, "Barometer 1 calibration complete")
                self.node.acknowledge(request, Outcome.ACCEPTED)
        if self._reboot_due_us is not None and now_us >= self._reboot_due_us:
            self.node.reboot()

    def _reboot(self, request: CommandRequest) -> Outcome:
        if request.parameters[0] not in (1, 3):
            return Outcome.UNSUPPORTED
        if self.node.vehicle.armed and request.y != FORCE_REBOOT:
            return Outcome.FAILED
        self._reboot_due_us = self.node.vehicle.clock.elapsed_us + REBOOT_AFTER_US
        return Outcome.ACCEPTED

    def _calibrate(self, request: CommandRequest) -> Outcome:
        vehicle = self.node.vehicle
        if vehicle.armed:
            vehicle.say(5, "Disarm to allow calibration")
            return Outcome.FAILED
        if request.parameters[2] == 1:
            vehicle.say(6, "Calibrating barometer")
            self._calibrating.append((vehicle.clock.elapsed_us + CALIBRATION_US, request))
            return Outcome.IN_PROGRESS
        wanted = request.parameters[0] == 1 or request.x in (1, 2, 4)
        return Outcome.ACCEPTED if wanted else Outcome.UNSUPPORTED
