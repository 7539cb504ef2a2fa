"""The questions of the conformance bench, under the names of the recording, in its order and with its waits."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from missions.bench.interview import Interview, Message, dialect

ACK_OR_TEXT = ("COMMAND_ACK", "STATUSTEXT")
REQUESTS = ("MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_ACK")
LATITUDE, LONGITUDE = 473977420, 85455940
Row = tuple[int, int, tuple[float, float, float, float], tuple[int, int, float]]


@dataclass(frozen=True)
class Answered:
    """What a vehicle answered: messages, or counts of messages."""

    name: str
    messages: tuple[Message, ...] = ()
    counts: Counter[str] | None = None
    text: str = ""


def ask_all(interview: Interview) -> Iterator[Answered]:
    """Ask everything, once, of a vehicle that has just been switched on."""
    for block in (_at_first, _messages_on_request, _commands, _on_the_ground, _parameters, _missions, _the_rest):
        yield from block(interview)


def _at_first(interview: Interview) -> Iterator[Answered]:
    yield Answered("HEARTBEAT", tuple(interview.listen(("HEARTBEAT",), 10.0)))
    yield Answered("heartbeats in 3.2s", counts=Counter(HEARTBEAT=len(interview.listen(("HEARTBEAT",), 3.2, 5))))
    interview.drain(2.0)
    yield Answered("unsolicited in 3s", counts=interview.count(3.0))


def _messages_on_request(interview: Interview) -> Iterator[Answered]:
    kinds = ("COMMAND_ACK", "AUTOPILOT_VERSION")
    yield Answered("REQUEST_MESSAGE AUTOPILOT_VERSION", tuple(interview.command(512, 148, kinds=kinds)))
    wanted = (
        (242, "HOME_POSITION"), (49, "GPS_GLOBAL_ORIGIN"), (300, "PROTOCOL_VERSION"), (395, "COMPONENT_INFORMATION"),
        (397, "COMPONENT_METADATA"), (435, "AVAILABLE_MODES"), (436, "CURRENT_MODE"),
        (437, "AVAILABLE_MODES_MONITOR"), (264, "FLIGHT_INFORMATION"), (244, "MESSAGE_INTERVAL"), (410, "EVENT?"),
        (9999, "bogus"),
    )  # fmt: skip
    for number, kind in wanted:
        heard = interview.command(512, number, kinds=("COMMAND_ACK", kind, "STATUSTEXT"))
        yield Answered(f"REQUEST_MESSAGE {kind}", tuple(heard))
    heard = interview.command(510, 33, kinds=("COMMAND_ACK", "MESSAGE_INTERVAL"))
    yield Answered("GET_MESSAGE_INTERVAL 33", tuple(heard))
    yield Answered("SET_MESSAGE_INTERVAL 33 10Hz", tuple(interview.command(511, 33, 100_000)))
    yield Answered("SET_MESSAGE_INTERVAL 331 (unsupported)", tuple(interview.command(511, 331, 100_000)))
    yield Answered("SET_MESSAGE_INTERVAL 33 -1", tuple(interview.command(511, 33, -1)))


def _commands(interview: Interview) -> Iterator[Answered]:
    version = ("COMMAND_ACK", "AUTOPILOT_VERSION")
    yield Answered("unsupported command DO_ORBIT", tuple(interview.command(34)))
    yield Answered("unknown command id 31999", tuple(interview.command(31999)))
    yield Answered("to wrong sysid 77", tuple(interview.command(512, 148, kinds=version, system=77)))
    yield Answered("to compid 100", tuple(interview.command(512, 148, kinds=version, component=100)))
    yield Answered("broadcast 0/0", tuple(interview.command(512, 148, kinds=version, system=0, component=0)))
    yield Answered("CMD 520 [1, 0]", tuple(interview.command(520, 1, kinds=version)))
    yield Answered("CMD 410 [0, 0]", tuple(interview.command(410, kinds=("COMMAND_ACK", "HOME_POSITION"))))
    yield Answered("DO_SEND_BANNER", tuple(interview.command(42428, most=6)))


def _on_the_ground(interview: Interview) -> Iterator[Answered]:
    yield Answered("RUN_PREARM_CHECKS", tuple(interview.command(401, most=3)))
    yield Answered("ARM before ready", tuple(interview.command(400, 1, most=3)))
    yield Answered("DO_SET_MODE bogus 99", tuple(interview.command(176, 1, 99)))
    yield Answered("TAKEOFF while disarmed", tuple(interview.command(22, 0, 0, 0, 0, 0, 0, 10)))
    interview.send(dialect.MAVLink_set_mode_message(interview.target, 1, 4))
    yield Answered("SET_MODE msg ->4", tuple(interview.listen(ACK_OR_TEXT, 1.0, 2)))
    nowhere = (interview.target, 1, 6, dialect.MAV_CMD_DO_REPOSITION, 0, 0, -1, 1, 0, math.nan, 0, 0, 10)
    interview.send(dialect.MAVLink_command_int_message(*nowhere))
    yield Answered("COMMAND_INT DO_REPOSITION 0,0 disarmed", tuple(interview.listen(ACK_OR_TEXT, 1.0, 2)))
    interview.drain(0.3)


def _parameters(interview: Interview) -> Iterator[Answered]:
    def read(name: bytes, index: int, kinds: tuple[str, ...] = ("PARAM_VALUE",)) -> tuple[Message, ...]:
        interview.send(dialect.MAVLink_param_request_read_message(interview.target, 1, name, index))
        return tuple(interview.listen(kinds, 1.5))

    failures = ("PARAM_VALUE", "STATUSTEXT", "PARAM_ERROR")
    yield Answered("PARAM_REQUEST_READ name", read(b"SYSID_THISMAV", -1))
    yield Answered("PARAM_REQUEST_READ unknown", read(b"NOPE", -1, failures))
    yield Answered("PARAM_REQUEST_READ idx 0", read(b"", 0))
    yield Answered("PARAM_REQUEST_READ idx 30000", read(b"", 30_000))
    interview.send(dialect.MAVLink_param_set_message(interview.target, 1, b"NOPE", 1.0, 9))
    yield Answered("PARAM_SET unknown", tuple(interview.listen(failures, 1.5)))
    interview.send(dialect.MAVLink_param_set_message(interview.target, 1, b"FS_GCS_TIMEOUT", 6.0, 9))
    yield Answered("PARAM_SET ok", tuple(interview.listen(("PARAM_VALUE",), 1.5)))
    interview.send(dialect.MAVLink_param_request_list_message(interview.target, 1))
    indices: set[int] = set()
    count = 1
    while len(indices) < count and (heard := interview.listen(("PARAM_VALUE",), 1.0)):
        count = heard[0].param_count
        indices.add(heard[0].param_index)
    yield Answered("PARAM_REQUEST_LIST", text=f"{len(indices)}/{count}")


def _missions(interview: Interview) -> Iterator[Answered]:
    target = interview.target
    for kind in range(4):
        interview.send(dialect.MAVLink_mission_request_list_message(target, 1, kind))
        heard = interview.listen(("MISSION_COUNT", "MISSION_ACK"), 1.0, 2)
        yield Answered(f"MISSION_REQUEST_LIST type {kind}", tuple(heard))
    interview.send(dialect.MAVLink_mission_request_int_message(target, 1, 50, 0))
    heard = interview.listen(("MISSION_ITEM_INT", "MISSION_ACK"), 1.0)
    yield Answered("MISSION_REQUEST_INT 50 out of range", tuple(heard))
    interview.send(dialect.MAVLink_mission_item_int_message(target, 1, 0, 3, 16, 0, 1, 0, 0, 0, 0, 1, 1, 1, 0))
    yield Answered("unsolicited MISSION_ITEM_INT", tuple(interview.listen(("MISSION_ACK",), 1.0)))
    interview.send(dialect.MAVLink_mission_count_message(target, 1, 2, 0))
    yield Answered("MISSION_COUNT 2", tuple(interview.listen(REQUESTS[:2], 2.0)))
    heard = interview.listen((*REQUESTS, "STATUSTEXT"), 13.0, 14)
    yield Answered("...no answer for 13s", tuple(heard))
    yield Answered("n retries", text=str(sum("REQUEST" in message.get_type() for message in heard)))
    interview.send(dialect.MAVLink_mission_clear_all_message(target, 1, 0))
    yield Answered("MISSION_CLEAR_ALL", tuple(interview.listen(("MISSION_ACK",), 1.0)))
    yield from _uploads(interview)
    interview.send(dialect.MAVLink_mission_request_list_message(target, 1, 1))
    yield Answered("FENCE list", tuple(interview.listen(("MISSION_COUNT",), 1.0)))
    interview.send(dialect.MAVLink_mission_set_current_message(target, 1, 1))
    heard = interview.listen(("MISSION_CURRENT", "MISSION_ACK", "STATUSTEXT"), 1.0, 2)
    yield Answered("MISSION_SET_CURRENT 1", tuple(heard))
    yield Answered("DO_SET_MISSION_CURRENT 1", tuple(interview.command(224, 1)))


def _uploads(interview: Interview) -> Iterator[Answered]:
    def corners(*places: tuple[int, int]) -> list[Row]:
        return [
            (0, 5001, (4, 0, 0, 0), (LATITUDE + north * 9000, LONGITUDE + east * 9000, 0.0)) for north, east in places
        ]

    here, none = (LATITUDE, LONGITUDE, 20.0), (0.0, 0.0, 0.0, 0.0)
    circle: Row = (0, 5003, (200, 0, 0, 0), (LATITUDE, LONGITUDE, 0.0))
    square = corners((1, 1), (1, -1), (-1, -1), (-1, 1))
    uploads: tuple[tuple[str, list[Row], int], ...] = (
        ("FENCE upload circle incl", [circle], 1),
        ("FENCE upload polygon incl", square, 1),
        ("FENCE polygon bad count", square[:3], 1),
        ("RALLY upload", [(3, 5100, none, here)], 2),
        ("MISSION with unsupported cmd", [(3, 16, none, here), (3, 31999, none, here)], 0),
        ("MISSION with invalid lat", [(3, 16, none, here), (3, 16, none, (2_000_000_000, LONGITUDE, 20.0))], 0),
    )
    for name, rows, kind in uploads:
        yield Answered(name, _upload(interview, rows, kind))


def _upload(interview: Interview, rows: list[Row], kind: int) -> tuple[Message, ...]:
    """Upload a list as clients do; returns the vehicle's last word."""
    interview.drain(0.2)
    interview.send(dialect.MAVLink_mission_count_message(interview.target, 1, len(rows), kind))
    while heard := interview.listen(REQUESTS, 3.0):
        if heard[0].get_type() == "MISSION_ACK":
            return tuple(heard)
        number = heard[0].seq
        frame, command, parameters, place = rows[number]
        interview.send(
            dialect.MAVLink_mission_item_int_message(
                interview.target, 1, number, frame, command, 0, 1, *parameters, *place, kind
            )
        )
    return ()


def _the_rest(interview: Interview) -> Iterator[Answered]:
    target = interview.target

    def ask(
        message: Message, kind: str, most: int = 1, which: Callable[[Message], bool] = lambda message: True
    ) -> tuple[Message, ...]:
        interview.send(message)
        return tuple(interview.listen((kind,), 1.0, most, which))

    sync = dialect.MAVLink_timesync_message(0, 123456789)
    yield Answered("TIMESYNC tc1=0", ask(sync, "TIMESYNC", 1, lambda message: message.ts1 == 123456789))
    yield Answered("PING", ask(dialect.MAVLink_ping_message(1, 7, 0, 0), "PING"))
    logs = dialect.MAVLink_log_request_list_message(target, 1, 0, 0xFFFF)
    yield Answered("LOG_REQUEST_LIST", ask(logs, "LOG_ENTRY", 2))
    extended = dialect.MAVLink_param_ext_request_list_message(target, 1)
    yield Answered("PARAM_EXT_REQUEST_LIST", ask(extended, "PARAM_EXT_VALUE"))
    interview.send(dialect.MAVLink_request_data_stream_message(target, 1, 0, 2, 1))
    interview.drain(2.0)
    yield Answered("after REQUEST_DATA_STREAM", counts=interview.count(4.0))
