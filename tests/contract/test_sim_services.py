"""The smaller services: signing, reboot, repeated commands, modes, instruments, ranges, logs, origin."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

from missions.bench.interview import dialect
from sim_bridge.autopilot.dialect import mavlink, new_codec
from sim_bridge.autopilot.node import Node
from sim_bridge.modes import Behaviour
from tests.fakes.sim_client import Asker, Bench, kinds, result
from tests.fakes.sim_teams import member, sea_fleet, until

ACCEPTED, DENIED, UNSUPPORTED, FAILED, IN_PROGRESS = 0, 2, 3, 4, 5
KEY = bytes(range(1, 33))


@pytest.fixture
def bench() -> Bench:
    return Bench()


def long(number: int, *parameters: float, confirmation: int = 0) -> Any:
    values = [*parameters, *[0.0] * (7 - len(parameters))]
    return mavlink.MAVLink_command_long_message(1, 1, number, confirmation, *values)


def texts(messages: list[Any]) -> list[str]:
    return [message.text for message in messages if message.get_type() == "STATUSTEXT"]


def sign_with(asker: Asker, key: bytes, stamp: int = 10_000) -> None:
    asker.codec.signing.secret_key = key
    asker.codec.signing.sign_outgoing = True
    asker.codec.signing.timestamp = stamp


# Signing


def signing_bench() -> Bench:
    bench = Bench()
    bench.asker.send(mavlink.MAVLink_setup_signing_message(1, 1, list(KEY), 5_000))
    return bench


def test_with_signing_on_only_signed_commands_are_obeyed() -> None:
    bench = signing_bench()
    assert bench.asker.command(512, 148) == []
    assert bench.asker.ask(mavlink.MAVLink_param_set_message(1, 1, b"RTL_ALT", 9.0, 9)) == []
    stranger = Asker(bench.node)
    sign_with(stranger, bytes(32)[:-1] + b"x")
    assert stranger.command(512, 148) == []
    sign_with(bench.asker, KEY)
    assert kinds(bench.asker.command(512, 148)) == ["COMMAND_ACK", "AUTOPILOT_VERSION"]


def test_signed_answers_bear_the_key() -> None:
    bench = signing_bench()
    sign_with(bench.asker, KEY)
    bench.asker.send(long(512, 148))
    data = bench.node.take_output(bench.asker.connection)
    for key, expected in ((KEY, ["COMMAND_ACK", "AUTOPILOT_VERSION"]), (bytes(32), ["BAD_DATA", "BAD_DATA"])):
        ears = dialect.MAVLink(None)  # pymavlink's own checks, not ours
        ears.robust_parsing = True
        ears.signing.secret_key = key
        assert kinds(ears.parse_buffer(data)) == expected


def test_a_replayed_frame_is_not_obeyed_on_any_connection() -> None:
    bench = signing_bench()
    sign_with(bench.asker, KEY)
    frame = mavlink.MAVLink_param_set_message(1, 1, b"RTL_ALT", 2_000.0, 9).pack(bench.asker.codec)
    bench.node.receive(bench.asker.connection, frame)
    assert bench.fleet.vehicles[0].parameters["RTL_ALT"] == 2_000.0
    bench.fleet.vehicles[0].set_parameter("RTL_ALT", 1_500.0)
    other = bench.node.connect()
    for client in (bench.asker.connection, other):
        bench.node.receive(client, frame)
    assert bench.fleet.vehicles[0].parameters["RTL_ALT"] == 1_500.0


def test_a_forged_time_in_the_future_does_not_lock_the_true_sender_out() -> None:
    bench = signing_bench()
    forger = new_codec(255, 190)
    forger.signing.secret_key, forger.signing.sign_outgoing, forger.signing.timestamp = bytes(32), True, 1 << 44
    bench.node.receive(bench.asker.connection, long(512, 148).pack(forger))
    sign_with(bench.asker, KEY)
    assert kinds(bench.asker.command(512, 148)) == ["COMMAND_ACK", "AUTOPILOT_VERSION"]


def test_a_key_of_zeros_switches_signing_off_and_running_motors_forbid_it() -> None:
    bench = signing_bench()
    sign_with(bench.asker, KEY)
    bench.asker.send(mavlink.MAVLink_setup_signing_message(1, 1, [0] * 32, 0))
    bench.asker.codec.signing.sign_outgoing = False
    assert kinds(bench.asker.command(512, 148)) == ["COMMAND_ACK", "AUTOPILOT_VERSION"]
    assert result(bench.asker.command(400, 1), 400) == ACCEPTED
    answers = bench.asker.ask(mavlink.MAVLink_setup_signing_message(1, 1, list(KEY), 0))
    assert texts(answers) == ["ERROR: Won't setup signing when armed"]
    assert kinds(bench.asker.command(512, 148)) == ["COMMAND_ACK", "AUTOPILOT_VERSION"]


def test_a_setup_for_another_system_is_none_of_ours(bench: Bench) -> None:
    bench.asker.send(mavlink.MAVLink_setup_signing_message(7, 1, list(KEY), 5_000))
    assert kinds(bench.asker.command(512, 148)) == ["COMMAND_ACK", "AUTOPILOT_VERSION"]


# Commands


def test_a_command_repeated_after_a_lost_answer_is_answered_and_not_done_twice(bench: Bench) -> None:
    bench.wait(6.0)
    vehicle = bench.fleet.vehicles[0]
    assert vehicle.arm().accepted
    assert result(bench.asker.ask(long(22, 0, 0, 0, 0, 0, 0, 12.0)), 22) == ACCEPTED
    bench.wait(2.0)
    assert result(bench.asker.ask(long(22, 0, 0, 0, 0, 0, 0, 12.0, confirmation=1)), 22) == ACCEPTED
    assert result(bench.asker.ask(long(22, 0, 0, 0, 0, 0, 0, 12.0, confirmation=2)), 22) == ACCEPTED
    assert result(bench.asker.ask(long(22, 0, 0, 0, 0, 0, 0, 12.0)), 22) == FAILED
    assert result(bench.asker.ask(long(22, 0, 0, 0, 0, 0, 0, 13.0, confirmation=1)), 22) == FAILED


def test_calibrating_the_barometer_takes_its_time(bench: Bench) -> None:
    assert result(bench.asker.command(241, 0, 0, 1), 241) == IN_PROGRESS
    bench.wait(3.0)
    heard = bench.asker.heard()
    assert [m.result for m in heard if m.get_type() == "COMMAND_ACK"] == [ACCEPTED]
    assert result(bench.asker.command(241, 1), 241) == ACCEPTED
    assert result(bench.asker.command(400, 1), 400) == ACCEPTED
    assert result(bench.asker.command(241, 1), 241) == FAILED


def test_a_reboot_breaks_connections_off_and_begins_anew(bench: Bench) -> None:
    bench.wait(8.0)
    vehicle = bench.fleet.vehicles[0]
    assert vehicle.set_parameter("RTL_ALT", 4_321.0).accepted
    gone: list[str] = []
    bench.asker.connection.hang_up = lambda: gone.append("closed")
    assert result(bench.asker.command(246, 1), 246) == ACCEPTED
    bench.wait(1.0)
    assert gone == ["closed"]
    assert bench.node.clients == []
    again = Asker(bench.node)
    assert vehicle.home_enu_m is None
    assert again.command(512, 2)[-1].time_boot_ms < 2_000
    assert vehicle.parameters["RTL_ALT"] == 4_321.0
    bench.wait(6.0)
    assert vehicle.arm().accepted


def test_running_motors_forbid_a_reboot_unless_forced(bench: Bench) -> None:
    bench.wait(6.0)
    assert bench.fleet.vehicles[0].arm().accepted
    assert result(bench.asker.command(246, 1), 246) == FAILED
    assert result(bench.asker.command(246, 2), 246) == UNSUPPORTED
    assert result(bench.asker.command(246, 1, 0, 0, 0, 0, 20190226), 246) == ACCEPTED
    bench.wait(1.0)
    assert not bench.fleet.vehicles[0].armed


# Messages


def modes(asker: Asker, index: float) -> list[Any]:
    asker.node.take_output(asker.connection)
    asker.send(long(512, 435, index))
    ears = dialect.MAVLink(None)
    ears.robust_parsing = True
    heard = ears.parse_buffer(asker.node.take_output(asker.connection))
    return [message for message in heard if message.get_type() == "AVAILABLE_MODES"]


def test_modes_are_told_all_or_one(bench: Bench) -> None:
    told = modes(bench.asker, 0)
    assert [message.mode_index for message in told] == list(range(1, len(told) + 1))
    assert {message.number_modes for message in told} == {len(told)}
    named = {message.mode_name: message.custom_mode for message in told}
    assert (named["GUIDED"], named["AUTO"], named["RTL"]) == (4, 3, 6)
    (second,) = modes(bench.asker, 2)
    assert second.to_dict() == told[1].to_dict()
    assert modes(bench.asker, 200) == []


@pytest.mark.parametrize("table", [
    {"type": "multicopter"}, {"type": "surface-vessel"}, {"type": "underwater-vehicle"}, {"autopilot": "px4"},
])  # fmt: skip
def test_every_mode_that_can_be_flown_is_told(table: dict[str, str]) -> None:
    fleet = sea_fleet(member("one", **table))
    vehicle = fleet.vehicles[0]
    told = {message.custom_mode: message.mode_name for message in modes(Asker(Node(vehicle, fleet.plan.datum)), 0)}
    assert told == {int(mode): traits.title for mode, traits in vehicle.personality.modes.items()}
    until(fleet, lambda v: v.ready_to_arm)
    for number in told:
        vehicle.note_target()
        if vehicle.set_mode(number).accepted:
            fleet.step(0.1)
            assert int(vehicle.mode) == number
    assert int(vehicle.personality.mode_of[Behaviour.HOLD]) in told


def test_a_rate_of_zero_means_the_usual_one(bench: Bench) -> None:
    bench.fleet.vehicles[0].set_parameter("SR0_POSITION", 5)
    assert result(bench.asker.command(511, 33, 100_000), 511) == ACCEPTED
    assert result(bench.asker.command(511, 33, 0), 511) == ACCEPTED
    assert bench.asker.command(510, 33)[0].interval_us == 200_000
    assert result(bench.asker.command(511, 30, 0), 511) == ACCEPTED
    assert bench.asker.command(510, 30)[0].interval_us == -1
    unknown = bench.asker.command(510, 4242)
    assert (unknown[0].interval_us, unknown[1].result) == (0, FAILED)


def test_streams_of_the_parameters_begin_with_the_connection(bench: Bench) -> None:
    for name in ("SR0_EXTRA1", "SR0_RAW_SENS"):
        bench.fleet.vehicles[0].set_parameter(name, 2)
    late = Asker(bench.node)
    bench.wait(4.0)
    heard = Counter(kinds(late.heard()))
    assert (heard["ATTITUDE"], heard["RAW_IMU"], heard["VFR_HUD"]) == (9, 9, 0)


@pytest.mark.parametrize("message_id", [27, 116, 129, 29, 137, 36, 65, 125, 152, 62, 163, 178, 241, 136, 164])
def test_instruments_tell_something(bench: Bench, message_id: int) -> None:
    bench.airborne()
    answers = bench.asker.command(512, message_id)
    assert [answers[0].result, answers[1].get_msgId()] == [ACCEPTED, message_id]


def test_ranges_are_told_once_there_is_a_sensor(bench: Bench) -> None:
    bench.airborne()
    assert kinds(bench.asker.command(512, 132)) == ["COMMAND_ACK"]
    assert kinds(bench.asker.command(512, 330)) == ["COMMAND_ACK"]
    vehicle = bench.fleet.vehicles[0]
    for name, value in (("RNGFND1_TYPE", 1), ("RNGFND1_MAX_CM", 10_000), ("PRX1_TYPE", 2)):
        assert vehicle.set_parameter(name, value).accepted
    told = bench.asker.command(512, 132)[1]
    assert told.current_distance == pytest.approx(2_000, abs=60)
    assert bench.asker.command(512, 173)[1].distance == pytest.approx(20.0, abs=0.6)
    around = bench.asker.command(512, 330)[1]
    assert set(around.distances) == {65_535}
    vehicle.set_parameter("RNGFND1_MAX_CM", 700)
    assert bench.asker.command(512, 132)[1].current_distance == 701


def test_logs_are_listed_while_disarmed(bench: Bench) -> None:
    request = mavlink.MAVLink_log_request_list_message(1, 1, 0, 0xFFFF)
    assert [entry.num_logs for entry in bench.asker.ask(request)] == [0]
    bench.airborne()
    assert texts(bench.asker.ask(request)) == ["Disarm for log download"]
    assert bench.fleet.vehicles[0].land().accepted
    bench.wait(60.0)
    (entry,) = bench.asker.ask(request)
    assert (entry.id, entry.num_logs, entry.last_log_num) == (1, 1, 1)
    bench.asker.send(mavlink.MAVLink_log_request_data_message(1, 1, 1, 0, entry.size))
    bench.wait(0.5)
    pieces = [m for m in bench.asker.heard() if m.get_type() == "LOG_DATA"]
    content = b"".join(bytes(piece.data[: piece.count]) for piece in pieces)
    assert len(content) == entry.size
    assert b"Disarming motors" in content or b"landed" in content or b"simulated flight" in content


def test_the_origin_is_taken_before_it_is_known_and_never_after(bench: Bench) -> None:
    place = bench.node.datum.to_geodetic((10.0, 20.0, 30.0))
    message = mavlink.MAVLink_set_gps_global_origin_message(
        1, round(place.latitude_deg * 1e7), round(place.longitude_deg * 1e7), round(place.altitude_amsl_m * 1e3)
    )
    assert kinds(bench.asker.ask(message)) == ["GPS_GLOBAL_ORIGIN"]
    assert bench.asker.ask(message) == []
    bench.wait(6.0)
    assert bench.fleet.vehicles[0].origin_enu_m == pytest.approx((10.0, 20.0, 30.0), abs=0.02)
    assert bench.fleet.vehicles[0].arm().accepted


# Parameters


def test_a_parameter_out_of_range_is_refused_with_its_old_value_and_a_log_line(bench: Bench) -> None:
    answers = bench.asker.ask(mavlink.MAVLink_param_set_message(1, 1, b"WPNAV_SPEED", -5.0, 9))
    (echo,) = [m for m in answers if m.get_type() == "PARAM_VALUE"]
    assert (echo.param_value, echo.param_index) == (1_000.0, 65535)
    bench.wait(0.1)
    assert "Param write denied (WPNAV_SPEED)" in texts(answers + bench.asker.heard())
    (line,) = bench.logged
    assert "WPNAV_SPEED" in line
    assert "-5" in line


# Fence


def test_the_fence_is_told_once_it_is_on(bench: Bench) -> None:
    bench.airborne()
    geofence = mavlink.MAV_SYS_STATUS_GEOFENCE
    before = bench.asker.command(512, 1)[1]
    assert not before.onboard_control_sensors_enabled & geofence
    assert before.onboard_control_sensors_health & geofence
    assert kinds(bench.asker.command(512, 162)) == ["COMMAND_ACK"]
    vehicle = bench.fleet.vehicles[0]
    assert vehicle.set_parameter("FENCE_ALT_MAX", 10).accepted
    assert result(bench.asker.command(207, 1), 207) == ACCEPTED
    bench.wait(1.0)
    during = bench.asker.command(512, 1)[1]
    assert during.onboard_control_sensors_enabled & geofence
    assert not during.onboard_control_sensors_health & geofence
    told = bench.asker.command(512, 162)[1]
    assert (told.breach_status, told.breach_count, told.breach_type) == (1, 1, mavlink.FENCE_BREACH_MAXALT)
    assert result(bench.asker.command(207, 0), 207) == ACCEPTED
    assert kinds(bench.asker.command(512, 162)) == ["COMMAND_ACK"]
    assert result(bench.asker.command(207, 9), 207) == DENIED


def test_px4_tells_a_checksum_that_changes_with_the_parameters() -> None:
    vehicle = {
        "name": "gull", "autopilot": "px4", "start_enu_m": [200.0, 200.0], "speed_m_s": 5.0,
        "sensor": {"kind": "range", "range_m": 100.0}, "min_above_terrain_m": 5.0, "max_above_terrain_m": 100.0,
    }  # fmt: skip
    bench = Bench(team=[vehicle])
    request = mavlink.MAVLink_param_request_read_message(1, 1, b"_HASH_CHECK", -1)
    (before,) = bench.asker.ask(request)
    assert (before.param_id, before.param_type, before.param_index) == ("_HASH_CHECK", 5, 65535)
    assert bench.asker.ask(request)[0].param_value == before.param_value
    bench.asker.ask(mavlink.MAVLink_param_set_message(1, 1, b"MIS_TAKEOFF_ALT", 7.25, 9))
    assert bench.asker.ask(request)[0].param_value != before.param_value


def test_ardupilot_has_no_checksum(bench: Bench) -> None:
    assert bench.asker.ask(mavlink.MAVLink_param_request_read_message(1, 1, b"_HASH_CHECK", -1)) == []
