"""AUTOPILOT_VERSION and the banner: what the vehicle is and can do."""

from __future__ import annotations

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import CommandHandler, CommandRequest, MessageBuilder, Service
from sim_bridge.reply import Outcome

FLIGHT_SOFTWARE_VERSION = 4 << 24 | 7 << 16
"""4.7.0-dev: the release whose answers this vehicle gives."""
CAPABILITIES = (
    mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT
    | mavlink.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
    | mavlink.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    | mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
    | mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT
)
BANNER = ("ArduCopter V4.7.0-dev (fieldfleet)", "simulated by sim-bridge", "Frame: QUAD/X")


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
        nothing = [0] * 8
        return mavlink.MAVLink_autopilot_version_message(
            CAPABILITIES,
            FLIGHT_SOFTWARE_VERSION,
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
        for line in BANNER:
            request.afterwards.append(
                mavlink.MAVLink_statustext_message(mavlink.MAV_SEVERITY_INFO, line.encode("ascii"))
            )
        return Outcome.ACCEPTED
