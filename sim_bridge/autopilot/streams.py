"""Messages at a rate and on request: SET_MESSAGE_INTERVAL, REQUEST_DATA_STREAM, REQUEST_MESSAGE."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from sim_bridge.autopilot.dialect import Message, mavlink
from sim_bridge.autopilot.service import Client, CommandHandler, CommandRequest, MessageHandler, Service
from sim_bridge.reply import Outcome

if TYPE_CHECKING:
    from sim_bridge.autopilot.node import Node

SHORTEST_INTERVAL_US = 20_000
DATA_STREAMS: dict[int, tuple[int, ...]] = {
    mavlink.MAV_DATA_STREAM_EXTENDED_STATUS: (
        mavlink.MAVLINK_MSG_ID_SYS_STATUS,
        mavlink.MAVLINK_MSG_ID_GPS_RAW_INT,
        mavlink.MAVLINK_MSG_ID_MISSION_CURRENT,
        mavlink.MAVLINK_MSG_ID_POSITION_TARGET_GLOBAL_INT,
    ),
    mavlink.MAV_DATA_STREAM_POSITION: (
        mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
        mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED,
    ),
    mavlink.MAV_DATA_STREAM_EXTRA1: (mavlink.MAVLINK_MSG_ID_ATTITUDE,),
    mavlink.MAV_DATA_STREAM_EXTRA2: (mavlink.MAVLINK_MSG_ID_VFR_HUD,),
    mavlink.MAV_DATA_STREAM_EXTRA3: (
        mavlink.MAVLINK_MSG_ID_SYSTEM_TIME,
        mavlink.MAVLINK_MSG_ID_BATTERY_STATUS,
        mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT,
    ),
}
"""ArduPilot's groups, as far as their messages are built here."""


class StreamService(Service):
    """Sends nothing unasked; intervals count in simulated time and belong to one client."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self._intervals_us: dict[Client, dict[int, int]] = {}
        self._due_us: dict[Client, dict[int, int]] = {}

    def handlers(self) -> dict[str, MessageHandler]:
        return {"REQUEST_DATA_STREAM": self._on_request_data_stream}

    def commands(self) -> dict[int, CommandHandler]:
        return {
            mavlink.MAV_CMD_SET_MESSAGE_INTERVAL: self._set_interval,
            mavlink.MAV_CMD_GET_MESSAGE_INTERVAL: self._get_interval,
            mavlink.MAV_CMD_REQUEST_MESSAGE: self._request_message,
        }

    def forget(self, client: Client) -> None:
        self._intervals_us.pop(client, None)
        self._due_us.pop(client, None)

    def tick(self) -> None:
        now_us = self.node.vehicle.clock.elapsed_us
        built: dict[int, Message | None] = {}
        for client, due in self._due_us.items():
            for message_id, due_us in due.items():
                if due_us > now_us:
                    continue
                interval_us = self._intervals_us[client][message_id]
                due[message_id] = due_us + interval_us if now_us - due_us < interval_us else now_us + interval_us
                if message_id not in built:
                    built[message_id] = self.node.builders[message_id]()
                message = built[message_id]
                if message is not None:
                    self.node.send(client, message)

    def _stream(self, client: Client, message_id: int, interval_us: int) -> None:
        """Send a message every so often; not at all with an interval of 0 or less."""
        intervals = self._intervals_us.setdefault(client, {})
        due = self._due_us.setdefault(client, {})
        if interval_us <= 0:
            intervals.pop(message_id, None)
            due.pop(message_id, None)
            return
        intervals[message_id] = max(interval_us, SHORTEST_INTERVAL_US)
        due[message_id] = self.node.vehicle.clock.elapsed_us

    def _on_request_data_stream(self, client: Client, message: Message) -> None:
        interval_us = round(1e6 / message.req_message_rate) if message.start_stop and message.req_message_rate else 0
        for stream, message_ids in DATA_STREAMS.items():
            if message.req_stream_id in (mavlink.MAV_DATA_STREAM_ALL, stream):
                for message_id in message_ids:
                    self._stream(client, message_id, interval_us)

    def _set_interval(self, request: CommandRequest) -> Outcome:
        message_id = _whole(request.parameters[0])
        if message_id not in self.node.builders:
            self._complain(request, message_id)
            return Outcome.DENIED
        self._stream(request.client, message_id, _whole(request.parameters[1]))
        return Outcome.ACCEPTED

    def _get_interval(self, request: CommandRequest) -> Outcome:
        message_id = _whole(request.parameters[0])
        interval_us = 0
        if message_id in self.node.builders:
            interval_us = self._intervals_us.get(request.client, {}).get(message_id, -1)
        told = mavlink.MAVLink_message_interval_message(max(message_id, 0) & 0xFFFF, interval_us)
        self.node.send(request.client, told)
        return Outcome.ACCEPTED

    def _request_message(self, request: CommandRequest) -> Outcome:
        builder = self.node.builders.get(_whole(request.parameters[0]))
        if builder is None:
            return Outcome.FAILED
        message = builder()
        if message is not None:
            request.afterwards.append(message)
        return Outcome.ACCEPTED

    def _complain(self, request: CommandRequest, message_id: int) -> None:
        text = f"No ap_message for mavlink id ({message_id})".encode("ascii")
        request.afterwards.append(mavlink.MAVLink_statustext_message(mavlink.MAV_SEVERITY_INFO, text))


def _whole(value: float) -> int:
    """A command parameter as a whole number; -1 when it is none."""
    return int(value) if math.isfinite(value) and abs(value) < 2**31 else -1
