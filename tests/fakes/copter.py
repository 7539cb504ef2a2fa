"""A scripted ArduCopter on a TCP port, small enough to be wrong on purpose: it forgets, refuses and vanishes."""

from __future__ import annotations

import os
import selectors
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

os.environ.setdefault("MAVLINK20", "1")

from pymavlink.dialects.v20 import ardupilotmega as mavlink

UNIX_EPOCH_MS = 1_767_225_600_000
STREAMS = {
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
    mavlink.MAVLINK_MSG_ID_SYSTEM_TIME,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE,
    mavlink.MAVLINK_MSG_ID_SYS_STATUS,
}


@dataclass
class Behaviour:
    """What the copter does wrong, and what it knows.

    Attributes
    ----------
    ignored_commands
        Number of times that each command (by MAV_CMD) still goes unanswered.
    results
        MAV_RESULT by MAV_CMD, accepted where missing.
    parameters
        What it has; others stay silent, as on ArduPilot.
    stubborn
        Parameters that keep their value.
    refusal
        STATUSTEXT sent before a refused arming.
    """

    system_id: int = 1
    autopilot: int = mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
    speedup: float = 1.0
    ignored_commands: dict[int, int] = field(default_factory=dict)
    results: dict[int, int] = field(default_factory=dict)
    parameters: dict[str, float] = field(default_factory=lambda: {"SYSID_MYGCS": 255.0, "RTL_ALT": 1500.0})
    stubborn: set[str] = field(default_factory=set)
    refusal: str = ""
    rival: int | None = None
    """Relays heartbeats of this system id, as if another component shared the link."""


class ScriptedCopter:
    """Answers on its own thread; `received` is what it was told, for tests to look at.

    Attributes
    ----------
    received
        Every decoded MAVLink message from the client, in order.
    """

    def __init__(self, port: int, behaviour: Behaviour) -> None:
        self.behaviour = behaviour
        self.received: list[Any] = []
        self.mode = 0
        self.armed = False
        self.landed = mavlink.MAV_LANDED_STATE_ON_GROUND
        self.latitude_e7, self.longitude_e7, self.altitude_mm = 365_700_000, -842_700_000, 400_000
        self._started_s = time.monotonic()
        self._codec = mavlink.MAVLink(None, srcSystem=behaviour.system_id, srcComponent=1)
        self._rival = mavlink.MAVLink(None, srcSystem=behaviour.rival or 1, srcComponent=191)
        self._intervals_ms: dict[int, float] = {mavlink.MAVLINK_MSG_ID_HEARTBEAT: 1_000.0}
        self._due_ms: dict[int, float] = {}
        self._stopping = threading.Event()
        self._listener = socket.create_server(("127.0.0.1", port), reuse_port=False)
        self._client: socket.socket | None = None
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    @property
    def boot_ms(self) -> float:
        return (time.monotonic() - self._started_s) * 1_000.0 * self.behaviour.speedup

    def commands(self, command: int) -> list[Any]:
        """COMMAND_LONG and COMMAND_INT received with this MAV_CMD."""
        return [message for message in list(self.received) if getattr(message, "command", None) == command]

    def heartbeats(self) -> list[Any]:
        return [message for message in list(self.received) if message.get_type() == "HEARTBEAT"]

    def forget_streams(self) -> None:
        """Stop everything but the heartbeat, as after a reboot."""
        self._intervals_ms = {mavlink.MAVLINK_MSG_ID_HEARTBEAT: 1_000.0}

    def stop(self) -> None:
        self._stopping.set()
        self._thread.join(5.0)
        self._listener.close()

    def _run(self) -> None:
        with selectors.DefaultSelector() as selector:
            selector.register(self._listener, selectors.EVENT_READ)
            while not self._stopping.is_set():
                for ready, _ in selector.select(0.01):
                    if ready.fileobj is self._listener:
                        if self._client is not None:
                            selector.unregister(self._client)
                            self._client.close()
                        self._client, _ = self._listener.accept()
                        selector.register(self._client, selectors.EVENT_READ)
                        self._codec = mavlink.MAVLink(None, srcSystem=self.behaviour.system_id, srcComponent=1)
                        self._codec.robust_parsing = True
                    elif self._client is not None and not self._read(self._client):
                        selector.unregister(self._client)
                        self._client.close()
                        self._client = None
                self._stream()
            if self._client is not None:
                self._client.close()

    def _read(self, client: socket.socket) -> bool:
        try:
            data = client.recv(65_536)
        except ConnectionError:
            return False
        for message in self._codec.parse_buffer(data) or [] if data else []:
            self.received.append(message)
            self._answer(message)
        return bool(data)

    def _send(self, message: Any, codec: Any = None) -> None:
        if self._client is not None:
            try:
                self._client.sendall(message.pack(codec or self._codec))
            except OSError:
                return
            (codec or self._codec).seq = ((codec or self._codec).seq + 1) % 256

    def _answer(self, message: Any) -> None:
        kind = message.get_type()
        if kind == "PARAM_SET":
            name = message.param_id
            if name in self.behaviour.parameters:
                if name not in self.behaviour.stubborn:
                    self.behaviour.parameters[name] = message.param_value
                value = self.behaviour.parameters[name]
                self._send(mavlink.MAVLink_param_value_message(name.encode(), value, 9, 1, 65_535))
        elif kind in ("COMMAND_LONG", "COMMAND_INT"):
            self._obey(message)

    def _obey(self, message: Any) -> None:
        command = message.command
        if self.behaviour.ignored_commands.get(command, 0) > 0:
            self.behaviour.ignored_commands[command] -= 1
            return
        result = self.behaviour.results.get(command, mavlink.MAV_RESULT_ACCEPTED)
        if command == mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
            if int(message.param1) in STREAMS:
                self._intervals_ms[int(message.param1)] = message.param2 / 1_000.0
        elif command == mavlink.MAV_CMD_DO_SET_MODE and result == 0:
            self.mode = int(message.param2)
        elif command == mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
            if result == 0:
                self.armed = message.param1 == 1.0
            elif self.behaviour.refusal:
                self._send(mavlink.MAVLink_statustext_message(2, self.behaviour.refusal.encode()))
        elif command == mavlink.MAV_CMD_DO_REPOSITION and result == 0:
            self.mode, self.latitude_e7, self.longitude_e7 = 4, message.x, message.y
            self.altitude_mm = int(message.z * 1_000)
        elif command == mavlink.MAV_CMD_NAV_TAKEOFF and result == 0:
            self.landed = mavlink.MAV_LANDED_STATE_IN_AIR
        self._send(
            mavlink.MAVLink_command_ack_message(
                command, result, 0, 0, message.get_srcSystem(), message.get_srcComponent()
            )
        )
        if command == mavlink.MAV_CMD_REQUEST_MESSAGE and int(message.param1) == 242:
            home = (365_700_000, -842_700_000, 400_000)
            self._send(mavlink.MAVLink_home_position_message(*home, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0))

    def _stream(self) -> None:
        now_ms = self.boot_ms
        for message_id, interval_ms in self._intervals_ms.items():
            if now_ms >= self._due_ms.get(message_id, 0.0):
                self._due_ms[message_id] = now_ms + interval_ms
                self._send(self._telemetry(message_id, int(now_ms)))
                if message_id == mavlink.MAVLINK_MSG_ID_HEARTBEAT and self.behaviour.rival is not None:
                    self._send(mavlink.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3), self._rival)

    def _telemetry(self, message_id: int, boot_ms: int) -> Any:
        if message_id == mavlink.MAVLINK_MSG_ID_HEARTBEAT:
            base_mode = 81 | (mavlink.MAV_MODE_FLAG_SAFETY_ARMED if self.armed else 0)
            return mavlink.MAVLink_heartbeat_message(2, self.behaviour.autopilot, base_mode, self.mode, 4, 3)
        if message_id == mavlink.MAVLINK_MSG_ID_SYSTEM_TIME:
            return mavlink.MAVLink_system_time_message((UNIX_EPOCH_MS + boot_ms) * 1_000, boot_ms)
        if message_id == mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE:
            return mavlink.MAVLink_extended_sys_state_message(0, self.landed)
        if message_id == mavlink.MAVLINK_MSG_ID_SYS_STATUS:
            sensors = mavlink.MAV_SYS_STATUS_PREARM_CHECK
            return mavlink.MAVLink_sys_status_message(sensors, sensors, sensors, 10, 12_000, 100, 73, 0, 0, 0, 0, 0, 0)
        return mavlink.MAVLink_global_position_int_message(
            boot_ms, self.latitude_e7, self.longitude_e7, self.altitude_mm, 0, 100, 200, -300, 9_000
        )


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextmanager
def scripted_copter(port: int, behaviour: Behaviour | None = None) -> Iterator[ScriptedCopter]:
    copter = ScriptedCopter(port, behaviour or Behaviour())
    try:
        yield copter
    finally:
        copter.stop()
