"""AUTOPILOT_VERSION and the banner: what the vehicle is and can do."""

from __future__ import annotations

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import CommandHandler, CommandRequest, MessageBuilder, Service
from sim_bridge.reply import Outcome


class VersionService(Service):
    """Answers who the vehicle is."""

    def commands(self) -> dict[int, CommandHandler]:
        return {
            mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: self._request_capabilities,
            mavlink.MAV_CMD_DO_SEND_BANNER: self._send_banner,
        }

    def builders(self) -> dict[int, MessageBuilder]:
        return {mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION: self.autopilot_version}

    def autopilot_version(self) -> Message:
        personality, nothing = self.node.vehicle.personality, [0] * 8
        return mavlink.MAVLink_autopilot_version_message(
            personality.capabilities,
            personality.flight_software_version,
            0,
            0,
            0,
            list(b"simbridg"),
            nothing,
            nothing,
            0,
            0,
            self.node.system_id,
        )

    def _request_capabilities(self, request: CommandRequest) -> Outcome:
        if request.parameters[0] != 1:
            return Outcome.DENIED
        request.afterwards.append(self.autopilot_version())
        return Outcome.ACCEPTED

    def _send_banner(self, request: CommandRequest) -> Outcome:
        for line in self.node.vehicle.personality.banner:
            request.afterwards.append(
                mavlink.MAVLink_statustext_message(mavlink.MAV_SEVERITY_INFO, line.encode("ascii"))
            )
        return Outcome.ACCEPTED
