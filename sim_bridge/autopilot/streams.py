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
LARGEST_MESSAGE_ID = 0xFFFF
"""That MESSAGE_INTERVAL can tell."""
DATA_STREAMS: dict[int, tuple[str, tuple[int, ...]]] = {
    mavlink.MAV_DATA_STREAM_RAW_SENSORS: (
        "SR0_RAW_SENS",
        (
            mavlink.MAVLINK_MSG_ID_RAW_IMU,
            mavlink.MAVLINK_MSG_ID_SCALED_IMU2,
            mavlink.MAVLINK_MSG_ID_SCALED_IMU3,
            mavlink.MAVLINK_MSG_ID_SCALED_PRESSURE,
            mavlink.MAVLINK_MSG_ID_SCALED_PRESSURE2,
        ),
    ),
    mavlink.MAV_DATA_STREAM_EXTENDED_STATUS: (
        "SR0_EXT_STAT",
        (
            mavlink.MAVLINK_MSG_ID_SYS_STATUS,
            mavlink.MAVLINK_MSG_ID_POWER_STATUS,
            mavlink.MAVLINK_MSG_ID_MEMINFO,
            mavlink.MAVLINK_MSG_ID_GPS_RAW_INT,
            mavlink.MAVLINK_MSG_ID_NAV_CONTROLLER_OUTPUT,
            mavlink.MAVLINK_MSG_ID_MISSION_CURRENT,
            mavlink.MAVLINK_MSG_ID_FENCE_STATUS,
            mavlink.MAVLINK_MSG_ID_POSITION_TARGET_GLOBAL_INT,
        ),
    ),
    mavlink.MAV_DATA_STREAM_RC_CHANNELS: (
        "SR0_RC_CHAN",
        (mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW, mavlink.MAVLINK_MSG_ID_RC_CHANNELS),
    ),
    mavlink.MAV_DATA_STREAM_RAW_CONTROLLER: ("SR0_RAW_CTRL", (mavlink.MAVLINK_MSG_ID_RC_CHANNELS_SCALED,)),
    mavlink.MAV_DATA_STREAM_POSITION: (
        "SR0_POSITION",
        (mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT, mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED),
    ),
    mavlink.MAV_DATA_STREAM_EXTRA1: (
        "SR0_EXTRA1",
        (mavlink.MAVLINK_MSG_ID_ATTITUDE, mavlink.MAVLINK_MSG_ID_SIMSTATE, mavlink.MAVLINK_MSG_ID_AHRS2),
    ),
    mavlink.MAV_DATA_STREAM_EXTRA2: ("SR0_EXTRA2", (mavlink.MAVLINK_MSG_ID_VFR_HUD,)),
    mavlink.MAV_DATA_STREAM_EXTRA3: (
        "SR0_EXTRA3",
        (
            mavlink.MAVLINK_MSG_ID_AHRS,
            mavlink.MAVLINK_MSG_ID_SYSTEM_TIME,
            mavlink.MAVLINK_MSG_ID_RANGEFINDER,
            mavlink.MAVLINK_MSG_ID_DISTANCE_SENSOR,
            mavlink.MAVLINK_MSG_ID_OBSTACLE_DISTANCE,
            mavlink.MAVLINK_MSG_ID_WATER_DEPTH,
            mavlink.MAVLINK_MSG_ID_TERRAIN_REPORT,
            mavlink.MAVLINK_MSG_ID_BATTERY_STATUS,
            mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT,
            mavlink.MAVLINK_MSG_ID_VIBRATION,
        ),
    ),
}
"""ArduPilot's groups with the parameters of their rates, as far as their messages are built here."""


class StreamService(Service):
    """Sends what the SR0_ parameters tell and what was asked for; intervals are simulated time, each client's own."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self._intervals_us: dict[Client, dict[int, int]] = {}
        self._due_us: dict[Client, dict[int, int]] = {}
        self._first_due_us: dict[Client, int] = {}

    def handlers(self) -> dict[str, MessageHandler]:
        return {"REQUEST_DATA_STREAM": self._on_request_data_stream}

    def commands(self) -> dict[int, CommandHandler]:
        return {
            mavlink.MAV_CMD_SET_MESSAGE_INTERVAL: self._set_interval,
            mavlink.MAV_CMD_GET_MESSAGE_INTERVAL: self._get_interval,
            mavlink.MAV_CMD_REQUEST_MESSAGE: self._request_message,
        }

    def welcome(self, client: Client) -> None:
        """Begin a new client's streams at the rates of the parameters."""
        for name, message_ids in DATA_STREAMS.values():
            rate_hz = int(self.node.vehicle.parameters.get(name, 0.0))
            if rate_hz > 0:
                self._stream_group(client, message_ids, _interval_us(rate_hz))

    def forget(self, client: Client) -> None:
        for kept in (self._intervals_us, self._due_us, self._first_due_us):
            kept.pop(client, None)

    def tick(self) -> None:
        now_us = self.node.vehicle.clock.elapsed_us
        built: dict[int, Message | None] = {}
        for client, due in self._due_us.items():
            if now_us < self._first_due_us[client]:
                continue
            intervals_us = self._intervals_us[client]
            for message_id, due_us in due.items():
                if due_us > now_us:
                    continue
                interval_us = intervals_us[message_id]
                due[message_id] = due_us + interval_us if now_us - due_us < interval_us else now_us + interval_us
                if message_id not in built:
                    built[message_id] = self.node.builders[message_id]()
                message = built[message_id]
                if message is not None:
                    self.node.send(client, message)
            self._first_due_us[client] = min(due.values(), default=now_us)

    def _stream(self, client: Client, message_id: int, interval_us: int) -> None:
        """Send a message every so often; not at all with an interval of 0 or less."""
        intervals = self._intervals_us.setdefault(client, {})
        due = self._due_us.setdefault(client, {})
        if interval_us <= 0:
            intervals.pop(message_id, None)
            due.pop(message_id, None)
        else:
            intervals[message_id] = max(interval_us, SHORTEST_INTERVAL_US)
            due[message_id] = self.node.vehicle.clock.elapsed_us
        self._first_due_us[client] = self.node.vehicle.clock.elapsed_us

    def _stream_group(self, client: Client, message_ids: tuple[int, ...], interval_us: int) -> None:
        for message_id in message_ids:
            if message_id in self.node.builders:
                self._stream(client, message_id, interval_us)

    def _on_request_data_stream(self, client: Client, message: Message) -> None:
        wanted = message.start_stop and message.req_message_rate > 0
        interval_us = _interval_us(message.req_message_rate) if wanted else 0
        for stream, (_, message_ids) in DATA_STREAMS.items():
            if message.req_stream_id in (mavlink.MAV_DATA_STREAM_ALL, stream):
                self._stream_group(client, message_ids, interval_us)

    def _set_interval(self, request: CommandRequest) -> Outcome:
        message_id = _whole(request.parameters[0])
        if message_id not in self.node.builders:
            self._complain(request, message_id)
            return Outcome.DENIED
        interval_us = _whole(request.parameters[1])
        self._stream(request.client, message_id, interval_us or self._usual_interval_us(message_id))
        return Outcome.ACCEPTED

    def _usual_interval_us(self, message_id: int) -> int:
        """What the parameters say; 0 when they keep it silent."""
        for name, message_ids in DATA_STREAMS.values():
            rate_hz = int(self.node.vehicle.parameters.get(name, 0.0))
            if message_id in message_ids and rate_hz > 0:
                return _interval_us(rate_hz)
        return 0

    def _get_interval(self, request: CommandRequest) -> Outcome:
        message_id = _whole(request.parameters[0])
        if not 0 <= message_id <= LARGEST_MESSAGE_ID:
            return Outcome.DENIED
        known = message_id in self.node.builders
        interval_us = 0
        if known:
            interval_us = self._intervals_us.get(request.client, {}).get(message_id, -1)
        self.node.send(request.client, mavlink.MAVLink_message_interval_message(message_id, interval_us))
        return Outcome.ACCEPTED if known else Outcome.FAILED

    def _request_message(self, request: CommandRequest) -> Outcome:
        message_id = _whole(request.parameters[0])
        responder, builder = self.node.responders.get(message_id), self.node.builders.get(message_id)
        if responder is not None:
            request.afterwards.extend(responder(request))
        elif builder is not None:
            message = builder()
            if message is not None:
                request.afterwards.append(message)
        else:
            return Outcome.FAILED
        return Outcome.ACCEPTED

    def _complain(self, request: CommandRequest, message_id: int) -> None:
        text = f"No ap_message for mavlink id ({message_id})".encode("ascii")
        request.afterwards.append(mavlink.MAVLink_statustext_message(mavlink.MAV_SEVERITY_INFO, text))


def _interval_us(rate_hz: int) -> int:
    """ArduPilot's streams count whole milliseconds."""
    return max(1000 // rate_hz, 1) * 1000


def _whole(value: float) -> int:
    """A command parameter as a whole number; -1 when it is none."""
    return int(value) if math.isfinite(value) and abs(value) < 2**31 else -1
