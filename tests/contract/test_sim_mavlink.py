"""The simulated autopilot answers protocol questions as a real ArduCopter 4.7-development did; no sockets.

The expected answers are those recorded from ArduCopter; where this vehicle carries less (parameters, missions), the
shape of the answer is compared.
"""

from __future__ import annotations

import math
import random
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from sim_bridge.autopilot.dialect import mavlink, new_codec
from tests.fakes.sim_client import Asker, Bench, kinds, result
from vehicle_agent.domain.frames import Geodetic

ACCEPTED, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_nothing_but_heartbeats_is_said_unasked(bench: Bench) -> None:
    bench.wait(8.0)
    heard = Counter(kinds(bench.asker.heard()))
    assert heard.pop("HEARTBEAT") == 1 + 8
    assert set(heard) <= {"STATUSTEXT"}


def test_the_heartbeat_before_the_position_is_known(bench: Bench) -> None:
    bench.wait(0.1)
    heartbeat = bench.asker.heard()[0]
    fields = (heartbeat.type, heartbeat.autopilot, heartbeat.base_mode, heartbeat.custom_mode, heartbeat.system_status)
    assert fields == (2, 3, 89, 0, 1)
    assert (heartbeat.get_srcSystem(), heartbeat.get_srcComponent()) == (1, 1)


@pytest.mark.parametrize(
    ("message_id", "expected"),
    [(148, ACCEPTED), (242, ACCEPTED), (49, ACCEPTED), (300, FAILED), (395, FAILED), (397, FAILED), (436, FAILED),
     (264, FAILED), (244, FAILED), (410, FAILED), (9999, FAILED)],
)  # fmt: skip
def test_request_message_is_acknowledged_before_the_position_is_known(
    bench: Bench, message_id: int, expected: int
) -> None:
    answers = bench.asker.command(512, message_id)
    assert result(answers, 512) == expected
    assert kinds(answers) == (["COMMAND_ACK", "AUTOPILOT_VERSION"] if message_id == 148 else ["COMMAND_ACK"])


def test_home_is_told_once_it_is_known(bench: Bench) -> None:
    bench.wait(6.0)
    assert kinds(bench.asker.command(512, 242)) == ["COMMAND_ACK", "HOME_POSITION"]
    home, _ = bench.asker.command(410)
    assert home.altitude == 350_000
    assert math.isnan(home.q[0])


def test_message_intervals(bench: Bench) -> None:
    told, acknowledgement = bench.asker.command(510, 33)
    assert (told.message_id, told.interval_us, acknowledgement.result) == (33, -1, ACCEPTED)
    assert result(bench.asker.command(511, 33, 100_000), 511) == ACCEPTED
    assert bench.asker.command(510, 33)[0].interval_us == 100_000
    assert kinds(bench.asker.heard()) == []
    bench.wait(2.0)
    assert Counter(kinds(bench.asker.heard()))["GLOBAL_POSITION_INT"] == 1 + 20
    refused = bench.asker.command(511, 331, 100_000)
    assert result(refused, 511) == DENIED
    assert refused[-1].text == "No ap_message for mavlink id (331)"
    assert result(bench.asker.command(511, 33, -1), 511) == ACCEPTED
    bench.wait(1.0)
    assert "GLOBAL_POSITION_INT" not in kinds(bench.asker.heard())


@pytest.mark.parametrize(("number", "expected"), [(34, UNSUPPORTED), (31999, UNSUPPORTED), (401, ACCEPTED)])
def test_commands_it_has_not_and_has(bench: Bench, number: int, expected: int) -> None:
    bench.wait(6.0)
    assert result(bench.asker.command(number), number) == expected


@pytest.mark.parametrize(("system", "component", "answered"), [(77, 1, False), (1, 100, True), (0, 0, True)])
def test_whom_it_answers(bench: Bench, system: int, component: int, answered: bool) -> None:
    answers = bench.asker.command(512, 148, system=system, component=component)
    assert bool(answers) is answered


def test_capabilities_and_banner(bench: Bench) -> None:
    assert kinds(bench.asker.command(520, 1)) == ["COMMAND_ACK", "AUTOPILOT_VERSION"]
    banner = bench.asker.command(42428)
    assert banner[0].get_type() == "COMMAND_ACK"
    assert banner[1].text.startswith("ArduCopter V4.7.0-dev")


def test_what_is_refused_on_the_ground(bench: Bench) -> None:
    """Bogus mode, take-off while disarmed, guided before the position, reposition to 0, 0."""
    answers = bench.asker.command(176, 1, 99)
    assert result(answers, 176) == FAILED
    assert result(bench.asker.command(22, 0, 0, 0, 0, 0, 0, 10), 22) == FAILED
    assert bench.asker.ask(mavlink.MAVLink_set_mode_message(1, 1, 4)) == []
    nowhere = mavlink.MAVLink_command_int_message(1, 1, 6, 192, 0, 0, -1, 1, 0, math.nan, 0, 0, 10)
    assert result(bench.asker.ask(nowhere), 192) == DENIED
    bench.wait(0.1)
    said = [(m.severity, m.text) for m in bench.asker.heard() if m.get_type() == "STATUSTEXT"]
    assert said == [(4, "No such mode 99"), (4, "Mode change to GUIDED failed: requires position")]


def test_arming_in_stabilize_is_accepted_with_a_text(bench: Bench) -> None:
    assert result(bench.asker.command(400, 1), 400) == ACCEPTED
    bench.wait(0.1)
    assert [m.text for m in bench.asker.heard() if m.get_type() == "STATUSTEXT"] == ["Arming motors"]


def test_parameters_by_name_and_index(bench: Bench) -> None:
    def read(name: bytes, index: int) -> list[Any]:
        return bench.asker.ask(mavlink.MAVLink_param_request_read_message(1, 1, name, index))

    (by_name,) = read(b"SYSID_THISMAV", -1)
    assert (by_name.param_id, by_name.param_value, by_name.param_type, by_name.param_index) == (
        "SYSID_THISMAV", 1.0, 4, 65535,
    )  # fmt: skip
    (by_index,) = read(b"", 0)
    assert (by_index.param_id, by_index.param_value, by_index.param_type, by_index.param_index) == (
        "FORMAT_VERSION", 120.0, 4, 0,
    )  # fmt: skip
    assert read(b"NOPE", -1) == []
    assert read(b"", 30_000) == []
    assert bench.asker.ask(mavlink.MAVLink_param_set_message(1, 1, b"NOPE", 1.0, 9)) == []
    (echo,) = bench.asker.ask(mavlink.MAVLink_param_set_message(1, 1, b"FS_GCS_TIMEOUT", 6.0, 9))
    assert (echo.param_value, echo.param_index) == (6.0, 65535)
    (rounded,) = bench.asker.ask(mavlink.MAVLink_param_set_message(1, 1, b"FS_GCS_ENABLE", 300.0, 9))
    assert rounded.param_value == 127.0


def test_a_listing_has_every_index_once_and_one_count(bench: Bench) -> None:
    bench.asker.heard()
    bench.asker.send(mavlink.MAVLink_param_request_list_message(1, 1))
    bench.wait(1.0)
    values = [m for m in bench.asker.heard() if m.get_type() == "PARAM_VALUE"]
    assert {value.param_count for value in values} == {len(values)}
    assert [value.param_index for value in values] == list(range(len(values)))
    assert len({value.param_id for value in values}) == len(values)


@pytest.mark.parametrize("mission_type", [0, 1, 2, 3])
def test_mission_lists_are_empty_and_echo_their_type(bench: Bench, mission_type: int) -> None:
    (answer,) = bench.asker.ask(mavlink.MAVLink_mission_request_list_message(1, 1, mission_type))
    assert answer.mission_type == mission_type
    if mission_type == 3:
        assert (answer.get_type(), answer.type) == ("MISSION_ACK", 3)
    else:
        assert (answer.get_type(), answer.count) == ("MISSION_COUNT", 0)


def test_mission_items_out_of_range_and_unsolicited_are_errors(bench: Bench) -> None:
    (answer,) = bench.asker.ask(mavlink.MAVLink_mission_request_int_message(1, 1, 50, 0))
    assert (answer.get_type(), answer.type) == ("MISSION_ACK", 1)
    item = mavlink.MAVLink_mission_item_int_message(1, 1, 0, 3, 16, 0, 1, 0, 0, 0, 0, 1, 1, 1, 0)
    (answer,) = bench.asker.ask(item)
    assert (answer.get_type(), answer.type) == ("MISSION_ACK", 1)


def test_timesync_answers_in_time_since_boot(bench: Bench) -> None:
    bench.wait(2.0)
    (answer,) = bench.asker.ask(mavlink.MAVLink_timesync_message(0, 123456789))
    assert (answer.tc1, answer.ts1) == (2_000_000_000, 123456789)


def test_ping_and_extended_parameters_get_silence(bench: Bench) -> None:
    assert bench.asker.ask(mavlink.MAVLink_ping_message(1, 7, 0, 0)) == []
    assert bench.asker.ask(mavlink.MAVLink_param_ext_request_list_message(1, 1)) == []


def test_data_streams_run_at_their_rate_for_who_asked(bench: Bench) -> None:
    other = Asker(bench.node, 254)
    bench.asker.send(mavlink.MAVLink_request_data_stream_message(1, 1, 0, 4, 1))
    bench.wait(5.0)
    heard = Counter(kinds(bench.asker.heard()))
    for kind in ("GLOBAL_POSITION_INT", "ATTITUDE", "SYS_STATUS", "BATTERY_STATUS", "SYSTEM_TIME", "VFR_HUD"):
        assert heard[kind] == 1 + 20
    assert "ATTITUDE" not in kinds(other.heard())
    bench.asker.send(mavlink.MAVLink_request_data_stream_message(1, 1, 0, 4, 0))
    bench.asker.heard()
    bench.wait(2.0)
    assert set(kinds(bench.asker.heard())) <= {"HEARTBEAT", "STATUSTEXT"}


def test_system_time_tells_unix_time_once_the_position_is_known(bench: Bench) -> None:
    assert bench.asker.command(512, 2)[1].time_unix_usec == 0
    bench.wait(6.0)
    told = bench.asker.command(512, 2)[1]
    assert (told.time_unix_usec, told.time_boot_ms) == (1_767_225_606_000_000, 6_000)


def reposition(bench: Bench, frame: int, altitude_m: float) -> list[Any]:
    place = bench.node.datum.to_geodetic((300.0, 400.0, 0.0))
    message = mavlink.MAVLink_command_int_message(
        1, 1, frame, 192, 0, 0, -1, 1, 0, math.nan,
        round(place.latitude_deg * 1e7), round(place.longitude_deg * 1e7), altitude_m,
    )  # fmt: skip
    return bench.asker.ask(message)


@pytest.mark.parametrize(("frame", "altitude_m"), [(0, 410.0), (5, 410.0), (3, 60.0), (6, 60.0)])
def test_reposition_in_every_frame_of_altitude(bench: Bench, frame: int, altitude_m: float) -> None:
    bench.airborne()
    assert result(reposition(bench, frame, altitude_m), 192) == ACCEPTED
    bench.wait(60.0)
    assert bench.fleet.vehicles[0].snapshot.position_enu_m == pytest.approx((300.0, 400.0, 110.0), abs=0.1)


def test_reposition_above_terrain_or_nowhere_is_denied(bench: Bench) -> None:
    bench.airborne()
    assert result(reposition(bench, 10, 60.0), 192) == DENIED
    assert result(reposition(bench, 0, math.nan), 192) == DENIED


def test_position_and_velocity_targets_are_flown_in_guided_only(bench: Bench) -> None:
    bench.airborne()
    place = bench.node.datum.to_geodetic((250.0, 150.0, 0.0))
    target = mavlink.MAVLink_set_position_target_global_int_message(
        0, 1, 1, 6, 0x0DF8, round(place.latitude_deg * 1e7), round(place.longitude_deg * 1e7), 30.0, *[0.0] * 8
    )
    assert bench.asker.ask(target) == []
    bench.wait(40.0)
    position = bench.fleet.vehicles[0].snapshot.position_enu_m
    assert position == pytest.approx((250.0, 150.0, 80.0), abs=0.1)
    north = mavlink.MAVLink_set_position_target_local_ned_message(0, 1, 1, 1, 0x0DC7, 0, 0, 0, 3.0, 0, 0, *[0.0] * 5)
    bench.asker.send(north)
    bench.wait(2.5)
    assert bench.fleet.vehicles[0].snapshot.velocity_enu_m_s == pytest.approx((0.0, 3.0, 0.0), abs=0.01)
    assert result(bench.asker.command(17), 17) == ACCEPTED
    bench.asker.send(north)
    bench.wait(5.0)
    assert max(map(abs, bench.fleet.vehicles[0].snapshot.velocity_enu_m_s)) < 0.05


@pytest.mark.parametrize(("frame", "turned"), [(7, False), (8, True), (9, True)])
def test_targets_may_count_from_the_vehicle_and_its_nose(bench: Bench, frame: int, turned: bool) -> None:
    """LOCAL_OFFSET_NED counts from the vehicle, BODY_NED and BODY_OFFSET_NED along its nose too."""
    bench.airborne()
    vehicle = bench.fleet.vehicles[0]
    assert vehicle.go_to((260.0, 200.0, 70.0)).accepted
    bench.wait(20.0)
    assert vehicle.heading_deg == pytest.approx(90.0, abs=1.0)
    start = vehicle.snapshot.position_enu_m
    offset = mavlink.MAVLink_set_position_target_local_ned_message(0, 1, 1, frame, 0x0DF8, 20.0, 5.0, -10.0, *[0.0] * 8)
    bench.asker.send(offset)
    bench.wait(20.0)
    moved = np.subtract(vehicle.snapshot.position_enu_m, start)
    assert moved == pytest.approx((20.0, -5.0, 10.0) if turned else (5.0, 20.0, 10.0), abs=0.4)
    heading_deg = vehicle.heading_deg
    bench.asker.send(
        mavlink.MAVLink_set_position_target_local_ned_message(0, 1, 1, frame, 0x0DC7, 0, 0, 0, 3.0, 0, 0, *[0.0] * 5)
    )
    bench.wait(2.5)
    course_deg = heading_deg if turned else 0.0
    along = (3.0 * math.sin(math.radians(course_deg)), 3.0 * math.cos(math.radians(course_deg)), 0.0)
    assert vehicle.snapshot.velocity_enu_m_s == pytest.approx(along, abs=0.05)


def test_telemetry_tells_where_it_is(bench: Bench) -> None:
    bench.airborne()
    position = bench.asker.command(512, 33)[1]
    truth = bench.fleet.vehicles[0].snapshot.position_enu_m
    told = bench.node.datum.to_enu(Geodetic(position.lat * 1e-7, position.lon * 1e-7, position.alt * 1e-3))
    assert told == pytest.approx(truth, abs=0.02)
    assert position.relative_alt == pytest.approx(20_000, abs=600)
    assert bench.asker.command(512, 245)[1].landed_state == mavlink.MAV_LANDED_STATE_IN_AIR
    local = bench.asker.command(512, 32)[1]
    assert (local.x, local.y, local.z) == pytest.approx((0.0, 0.0, -position.relative_alt / 1000), abs=0.01)


def test_long_texts_come_in_chunks(bench: Bench) -> None:
    bench.wait(0.1)
    bench.asker.heard()
    text = "x" * 50 + "y" * 20
    bench.fleet.vehicles[0].say(6, text)
    bench.wait(0.05)
    chunks = [m for m in bench.asker.heard() if m.get_type() == "STATUSTEXT"]
    assert [chunk.chunk_seq for chunk in chunks] == [0, 1]
    assert len({chunk.id for chunk in chunks} - {0}) == 1
    assert "".join(chunk.text for chunk in chunks) == text


def heartbeats_of(asker: Asker, system_id: int) -> int:
    return sum(m.get_type() == "HEARTBEAT" and m.get_srcSystem() == system_id for m in asker.heard())


@pytest.mark.parametrize(("rival_component", "heard"), [(190, 1), (191, 0)])
def test_a_rival_with_the_same_system_id_is_heard_as_ardupilot_routes_it(
    bench: Bench, rival_component: int, heard: int
) -> None:
    """Heartbeats go where their sender has not been heard; other broadcasts go everywhere."""
    agent, rival = Asker(bench.node, 101, 191), Asker(bench.node, 101, rival_component)
    heartbeat = mavlink.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3)
    agent.send(heartbeat)
    rival.heard()
    rival.send(heartbeat)
    assert heartbeats_of(agent, 101) == heard
    rival.send(mavlink.MAVLink_system_time_message(1, 2))
    assert kinds(agent.heard()) == ["SYSTEM_TIME"]
    assert rival.heard() == []


def test_messages_for_one_client_reach_only_it(bench: Bench) -> None:
    first, second, third = (Asker(bench.node, number) for number in (101, 102, 103))
    for asker in (first, second, third):
        asker.send(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
    for asker in (first, second, third):
        asker.heard()
    first.send(mavlink.MAVLink_command_long_message(102, 190, 512, 0, 148, 0, 0, 0, 0, 0, 0))
    assert kinds(second.heard()) == ["COMMAND_LONG"]
    assert first.heard() == []
    assert third.heard() == []


def test_a_client_that_left_gets_nothing_and_takes_its_streams_along(bench: Bench) -> None:
    bench.asker.send(mavlink.MAVLink_request_data_stream_message(1, 1, 0, 10, 1))
    bench.asker.send(mavlink.MAVLink_param_request_list_message(1, 1))
    bench.asker.heard()
    bench.node.disconnect(bench.asker.connection)
    bench.wait(1.0)
    assert bench.asker.heard() == []


def _flip(data: bytearray, rng: random.Random) -> bytes:
    for _ in range(rng.randint(1, 6)):
        data[rng.randrange(len(data))] = rng.randrange(256)
    return bytes(data)


def _with_right_checksum(rng: random.Random) -> bytes:
    """A well-formed frame of a random known message with random content."""
    codec = new_codec(rng.randrange(256), rng.randrange(256))
    kind = mavlink.mavlink_map[rng.choice(sorted(mavlink.mavlink_map))]
    message = kind.__new__(kind)
    mavlink.MAVLink_message.__init__(message, kind.id, kind.msgname)
    payload = bytes(rng.choice((0, 1, rng.randrange(256), 255)) for _ in range(kind.unpacker.size))
    return bytes(message._pack(codec, kind.crc_extra, payload))


@pytest.mark.parametrize("make", [
    lambda rng: rng.randbytes(rng.randint(1, 200)),
    lambda rng: _flip(bytearray(mavlink.MAVLink_param_request_list_message(1, 1).pack(new_codec(255))), rng),
    _with_right_checksum,
])  # fmt: skip
def test_no_bytes_break_it(bench: Bench, make: Callable[[random.Random], bytes]) -> None:
    bench.airborne()
    other = Asker(bench.node, 9)
    rng = random.Random(5)
    for round_number in range(3_000):
        bench.node.receive(bench.asker.connection, make(rng))
        if round_number % 50 == 0:
            bench.wait(0.05)
            bench.asker.heard()
            other.heard()
    fresh = Asker(bench.node)
    assert kinds(fresh.command(512, 148)) == ["COMMAND_ACK", "AUTOPILOT_VERSION"]
    bench.wait(2.0)
    assert "HEARTBEAT" in kinds(fresh.heard())
