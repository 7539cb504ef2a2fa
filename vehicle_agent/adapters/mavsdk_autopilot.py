"""The `Autopilot` port over MAVSDK 4: a real or simulated autopilot on a connection URL.

MAVSDK calls back on threads of its own; those calls only enqueue. `poll` runs on the owner's thread, folds what came in
and asks again for streams that stopped. Heartbeats go out in vehicle time, because the autopilot's failsafe counts
vehicle seconds, and only while somebody polls, so that a hung agent is missed.
"""

from __future__ import annotations

import json
import logging
import time
from collections import deque
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from mavsdk import Configuration, LogLevel, Mavsdk, MavsdkError, System, log_subscribe
from mavsdk.plugins.mavlink_direct import MavlinkDirect, MavlinkDirectError, MavlinkMessage

from vehicle_agent.adapters import ardupilot
from vehicle_agent.adapters.heartbeat_pulse import HeartbeatPulse
from vehicle_agent.adapters.mavlink_orders import OrderDesk
from vehicle_agent.adapters.mavlink_requests import (
    COMMAND_REQUEST_MESSAGE,
    COMMAND_SET_MESSAGE_INTERVAL,
    FRAME_GLOBAL_INT,
    CommandRequest,
    ParameterRequest,
    Request,
)
from vehicle_agent.adapters.mavlink_telemetry import FOLDED_MESSAGES, StatusTexts, TelemetryFold
from vehicle_agent.domain.frames import Datum
from vehicle_agent.ports import Action, ActionResult, AutopilotText, VehicleState

COMPONENT_ONBOARD_COMPUTER = 191
COMPONENT_AUTOPILOT = 1
PARAMETER_REAL32 = 9
"""MAV_PARAM_TYPE_REAL32: ArduPilot casts every parameter to float and ignores the type."""

STREAMS: Mapping[str, tuple[int, float]] = MappingProxyType(
    {
        "GLOBAL_POSITION_INT": (33, 5.0),
        "SYSTEM_TIME": (2, 1.0),
        "EXTENDED_SYS_STATE": (245, 2.0),
        "SYS_STATUS": (1, 1.0),
    }
)
"""Message id and rate in Hz of vehicle time of what is asked to be streamed."""
DISTANCE_SENSOR_ID = 132
ASKED_PER_READING = 5.0
"""How often a beam is asked for in its period: so late its readings are known at most, as a share of it."""
HOME_POSITION_ID = 242
STREAM_SILENCE_S = 2.0
"""A stream silent for this long (wall time) is asked for again, as often."""
CONNECT_TIMEOUT_S = 60.0

_log = logging.getLogger(__name__)


class AutopilotError(Exception):
    """An autopilot that cannot be used; its text is one sentence with the endpoint and the mend."""


class MavsdkAutopilot:
    """One vehicle's autopilot. Not there yet is no error until `connect_timeout_s` have passed.

    Parameters
    ----------
    url
        MAVSDK connection URL, e.g. `tcpout://127.0.0.1:5760` or `serial:///dev/ttyACM0:115200`.
    system_id
        The autopilot's MAVLink system id.
    controller_id
        The MAVLink system id with which this agent speaks.
    datum
        Origin of the frame of all positions in and out.
    firmware
        Which ArduPilot it is to be.
    sounding_period_s
        Vehicle time between two readings of the autopilot's downward beam; None when it is not asked for any.
    wake
        Called, on MAVSDK's thread, when there is a new position to poll.
    clock
        Wall time in seconds.

    Raises
    ------
    AutopilotError
        When the URL is malformed.
    """

    def __init__(
        self,
        url: str,
        system_id: int,
        controller_id: int,
        datum: Datum,
        *,
        firmware: ardupilot.Firmware = ardupilot.COPTER,
        sounding_period_s: float | None = None,
        wake: Callable[[], None] = lambda: None,
        clock: Callable[[], float] = time.monotonic,
        connect_timeout_s: float = CONNECT_TIMEOUT_S,
    ) -> None:
        self._url = url
        self._system_id = system_id
        self._controller_id = controller_id
        self._wake = wake
        self._clock = clock
        self._connect_timeout_s = connect_timeout_s
        self._started_s = clock()
        self._news: deque[tuple[str, str]] = deque()
        self._systems_changed = True
        self._heard_system_ids: set[int] = set()
        self._direct: MavlinkDirect | None = None
        self._system: System | None = None
        self._streams = dict(STREAMS)
        if sounding_period_s is not None:
            self._streams["DISTANCE_SENSOR"] = (DISTANCE_SENSOR_ID, ASKED_PER_READING / sounding_period_s)
        self._telemetry = TelemetryFold(datum, firmware.flight_mode, sounding_period_s or 0.0)
        self._texts = StatusTexts()
        self._desk = OrderDesk(lambda order: ardupilot.steps_of(order, datum, firmware), self._send_request)
        self._heard_s: dict[str, float] = {}
        self._asked_s: dict[str, float] = {}
        self._was_armed = False
        self.undecodable = 0
        log_subscribe(_log_mavsdk)
        self._mavsdk = Mavsdk(Configuration.create_manual(controller_id, COMPONENT_ONBOARD_COMPUTER, True))
        self._mavsdk.subscribe_on_new_system(lambda _user_data: self._note_new_system())
        try:
            self._mavsdk.add_any_connection_with_handle(url)
        except MavsdkError as error:
            self._mavsdk.destroy()
            raise AutopilotError(
                f"{url}: not a usable connection ({error}); write it like tcpout://127.0.0.1:5760, "
                f"udpin://0.0.0.0:14550 or serial:///dev/ttyACM0:115200"
            ) from None
        self._pulse = HeartbeatPulse(self._send_heartbeat, clock)

    def poll(self) -> tuple[VehicleState | None, list[ActionResult], list[AutopilotText]]:
        """Newest state, results and texts since the last poll; raises AutopilotError when nobody ever answers."""
        now_s = self._clock()
        self._pulse.owner_is_alive()
        if self._systems_changed:
            self._meet_systems()
        if "HEARTBEAT" not in self._heard_s and now_s - self._started_s > self._connect_timeout_s:
            raise AutopilotError(self._silence())
        state: VehicleState | None = None
        texts: list[AutopilotText] = []
        while self._news:
            name, fields_json = self._news.popleft()
            try:
                fields = json.loads(fields_json)
                new_state = self._fold(name, fields, texts, now_s)
            except (ValueError, KeyError, TypeError):
                self.undecodable += 1
                continue
            state = new_state or state
        if self._direct is not None:
            self._ask_for_streams(now_s, state)
        return state, self._desk.tick(now_s), texts

    def submit(self, action: Action) -> None:
        self._desk.submit(action, self._clock())

    def close(self) -> None:
        """Fall silent; the autopilot's own failsafe takes over where it is armed."""
        self._pulse.stop()
        self._mavsdk.destroy()

    def _fold(self, name: str, fields: dict[str, Any], texts: list[AutopilotText], now_s: float) -> VehicleState | None:
        self._heard_s[name] = now_s
        match name:
            case "COMMAND_ACK":
                # ArduPilot fills the requester's ids in; zero means an autopilot that does not.
                if fields.get("target_system", 0) in (0, self._controller_id):
                    self._desk.on_ack(fields["command"], fields["result"], now_s)
            case "PARAM_VALUE":
                self._desk.on_parameter(fields["param_id"], fields["param_value"], now_s)
            case "STATUSTEXT":
                text = self._texts.fold(fields)
                if text is not None:
                    self._desk.on_text(text, now_s)
                    texts.append(AutopilotText(fields["severity"], text))
            case "HEARTBEAT" if fields["autopilot"] != ardupilot.AUTOPILOT_TYPE:
                raise AutopilotError(
                    f"{self._url}: system {self._system_id} is not an ArduPilot (MAV_AUTOPILOT {fields['autopilot']}); "
                    f"connect one, or correct the vehicle's connection"
                )
            case _:
                return self._telemetry.fold(name, fields)
        return None

    def _note_new_system(self) -> None:
        self._systems_changed = True
        self._wake()

    def _meet_systems(self) -> None:
        """Subscribe to the autopilot once it is there; notice a rival that speaks with this agent's id."""
        self._systems_changed = False
        for system in self._mavsdk.get_systems():
            system_id = system.get_system_id()
            self._heard_system_ids.add(system_id)
            if system_id == self._controller_id:
                self._telemetry.rival_controller = True
            if system_id == self._system_id and self._direct is None:
                self._system = system
                direct = MavlinkDirect(system)
                for name in (*FOLDED_MESSAGES, "COMMAND_ACK", "PARAM_VALUE", "STATUSTEXT"):
                    direct.subscribe_message(name, self._enqueue)
                self._direct = direct
                _log.info("%s: met system %d", self._url, system_id)

    def _enqueue(self, message: MavlinkMessage, _user_data: object) -> None:
        if message.component_id != COMPONENT_AUTOPILOT:
            return
        self._news.append((message.message_name, message.fields_json))
        if message.message_name == "GLOBAL_POSITION_INT":
            self._pulse.on_position(message.fields_json)
            self._wake()

    def _ask_for_streams(self, now_s: float, state: VehicleState | None) -> None:
        for name, (message_id, rate_hz) in self._streams.items():
            if self._is_due(name, now_s):
                interval_us = 1e6 / rate_hz
                self._send_request(
                    CommandRequest(COMMAND_SET_MESSAGE_INTERVAL, f"stream {name}", (message_id, interval_us)), 0
                )
        # Arming sets home anew.
        armed_just_now = state is not None and state.armed and not self._was_armed
        if state is not None:
            self._was_armed = state.armed
        if armed_just_now or (self._telemetry.home_enu_m is None and self._is_due("HOME_POSITION", now_s)):
            self._asked_s["HOME_POSITION"] = now_s
            self._send_request(CommandRequest(COMMAND_REQUEST_MESSAGE, "tell home", (HOME_POSITION_ID,)), 0)

    def _is_due(self, name: str, now_s: float) -> bool:
        since_s = max(self._heard_s.get(name, -1e9), self._asked_s.get(name, -1e9))
        if now_s - since_s < STREAM_SILENCE_S:
            return False
        self._asked_s[name] = now_s
        return True

    def _send_request(self, request: Request, asked_before: int) -> None:
        target = {"target_system": self._system_id, "target_component": COMPONENT_AUTOPILOT}
        if isinstance(request, ParameterRequest):
            fields = {"param_id": request.name, "param_value": request.value, "param_type": PARAMETER_REAL32}
            self._send("PARAM_SET", {**target, **fields})
            return
        parameters = {f"param{n + 1}": float(value) for n, value in enumerate(request.parameters)}
        if request.position is None:
            filled = {f"param{n}": 0.0 for n in range(1, 8)} | parameters
            header = {"command": request.command, "confirmation": asked_before}
            self._send("COMMAND_LONG", {**target, **header, **filled})
            return
        latitude_e7, longitude_e7, altitude_amsl_m = request.position
        place = {"frame": FRAME_GLOBAL_INT, "x": latitude_e7, "y": longitude_e7, "z": altitude_amsl_m}
        header = {"command": request.command, "current": 0, "autocontinue": 0}
        self._send("COMMAND_INT", {**target, **header, **parameters, **place})

    def _send_heartbeat(self) -> None:
        onboard_controller = {"type": 18, "autopilot": 8, "base_mode": 0, "custom_mode": 0, "system_status": 4}
        self._send("HEARTBEAT", {**onboard_controller, "mavlink_version": 3})

    def _send(self, name: str, fields: dict[str, Any]) -> None:
        if self._direct is None:
            return  # nobody there yet: the order desk asks again
        try:
            self._direct.send_message(MavlinkMessage(message_name=name, fields_json=json.dumps(fields)))
        except (MavlinkDirectError, RuntimeError) as error:
            _log.debug("%s not sent: %s", name, error)

    def _silence(self) -> str:
        if self._heard_system_ids:
            heard = ", ".join(map(str, sorted(self._heard_system_ids)))
            return (
                f"{self._url}: speaks as MAVLink system {heard}, not {self._system_id}; correct the vehicle's "
                f"system_id in the mission file"
            )
        return (
            f"{self._url}: no autopilot answered within {self._connect_timeout_s:g} s; start it, or correct the "
            f"vehicle's connection"
        )


def _log_mavsdk(level: LogLevel, message: str, _file: str | None, _line: int) -> bool:
    """MAVSDK would print on stdout, which belongs to this program's own words."""
    _log.debug("mavsdk %s: %s", level.name, message)
    return True
