"""Missions, fences and rally points go up and down as with a real ArduPilot; what is refused leaves the old list."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import pytest

from sim_bridge.autopilot.dialect import mavlink
from tests.fakes.sim_client import Asker, Bench, kinds

ACCEPTED, ERROR, FRAME, UNSUPPORTED, INVALID_X, SEQUENCE, DENIED, CANCELLED = 0, 1, 2, 3, 10, 13, 14, 15
MISSION, FENCE, RALLY = 0, 1, 2
LATITUDE, LONGITUDE = 365700000, -842700000

Row = tuple[int, int, tuple[float, float, float, float], tuple[float, float, float]]


@pytest.fixture
def bench() -> Bench:
    return Bench()


def waypoint(north_e7: int = 0, altitude_m: float = 20.0, frame: int = 6, command: int = 16) -> Row:
    return (frame, command, (0.0, 0.0, 0.0, 0.0), (LATITUDE + north_e7, LONGITUDE, altitude_m))


def corner(dx: int, dy: int, count: int, command: int = 5001) -> Row:
    return (0, command, (count, 0.0, 0.0, 0.0), (LATITUDE + dx * 9000, LONGITUDE + dy * 9000, 0.0))


SQUARE = [(1, 1), (1, -1), (-1, -1), (-1, 1)]


def item(sequence: int, row: Row, mission_type: int) -> Any:
    frame, command, parameters, place = row
    return mavlink.MAVLink_mission_item_int_message(
        1, 1, sequence, frame, command, 0, 1, *parameters, int(place[0]), int(place[1]), place[2], mission_type
    )


def answers(asker: Asker) -> list[Any]:
    return [m for m in asker.heard() if m.get_type().startswith("MISSION") and m.get_type() != "MISSION_CURRENT"]


def upload(asker: Asker, rows: Sequence[Row], mission_type: int = MISSION) -> int:
    """Upload as a client does and return the result."""
    asker.heard()
    asker.send(mavlink.MAVLink_mission_count_message(1, 1, len(rows), mission_type))
    for _ in range(len(rows) + 1):
        (answer,) = answers(asker)
        assert answer.mission_type == mission_type
        assert (answer.target_system, answer.target_component) == (255, 190)
        if answer.get_type() == "MISSION_ACK":
            return int(answer.type)
        assert answer.get_type() == "MISSION_REQUEST"
        asker.send(item(answer.seq, rows[answer.seq], mission_type))
    (answer,) = answers(asker)
    return int(answer.type)


def download(asker: Asker, mission_type: int = MISSION) -> list[Any]:
    (count,) = asker.ask(mavlink.MAVLink_mission_request_list_message(1, 1, mission_type))
    assert (count.get_type(), count.mission_type) == ("MISSION_COUNT", mission_type)
    items = []
    for number in range(count.count):
        (told,) = asker.ask(mavlink.MAVLink_mission_request_int_message(1, 1, number, mission_type))
        assert (told.get_type(), told.seq, told.mission_type) == ("MISSION_ITEM_INT", number, mission_type)
        items.append(told)
    asker.send(mavlink.MAVLink_mission_ack_message(1, 1, 0, mission_type))
    assert answers(asker) == []
    return items


def test_a_mission_comes_back_with_home_in_front_and_frames_that_are_not_int(bench: Bench) -> None:
    bench.wait(6.0)
    rows = [waypoint(), waypoint(1000, frame=6), waypoint(2000, 50.0, frame=5), waypoint(3000, frame=3)]
    rows.append((2, 177, (1.0, 2.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    assert upload(bench.asker, rows) == ACCEPTED
    home, *items = download(bench.asker)
    assert (home.frame, home.command, home.z) == (0, 16, 350.0)
    assert (home.x, home.y) != (LATITUDE, LONGITUDE)
    assert [told.frame for told in items] == [3, 0, 3, 0]
    assert [told.command for told in items] == [16, 16, 16, 177]
    assert [told.x for told in items[:3]] == [LATITUDE + 1000, LATITUDE + 2000, LATITUDE + 3000]
    assert (items[3].param1, items[3].param2) == (1.0, 2.0)


def test_old_clients_get_items_with_floating_point_places(bench: Bench) -> None:
    assert upload(bench.asker, [waypoint(), waypoint(1000)]) == ACCEPTED
    (told,) = bench.asker.ask(mavlink.MAVLink_mission_request_message(1, 1, 1, MISSION))
    assert told.get_type() == "MISSION_ITEM"
    assert told.x == pytest.approx((LATITUDE + 1000) * 1e-7, abs=1e-5)


def test_old_clients_may_upload_items_with_floating_point_places(bench: Bench) -> None:
    bench.asker.send(mavlink.MAVLink_mission_count_message(1, 1, 1, RALLY))
    old = mavlink.MAVLink_mission_item_message(1, 1, 0, 3, 5100, 0, 1, 0, 0, 0, 0, 36.57, -84.27, 30.0, RALLY)
    assert bench.asker.ask(old)[0].type == ACCEPTED
    (point,) = download(bench.asker, RALLY)
    assert point.x == pytest.approx(LATITUDE, abs=100)


def test_without_answers_it_asks_seven_times_more_and_gives_up(bench: Bench) -> None:
    bench.asker.send(mavlink.MAVLink_mission_count_message(1, 1, 2, MISSION))
    bench.wait(13.0)
    heard = answers(bench.asker)
    assert kinds(heard) == ["MISSION_REQUEST"] * 8 + ["MISSION_ACK"]
    assert {request.seq for request in heard[:-1]} == {0}
    assert (heard[-1].type, heard[-1].mission_type) == (CANCELLED, MISSION)


def test_a_lost_item_is_asked_for_again_and_the_upload_goes_on(bench: Bench) -> None:
    bench.asker.send(mavlink.MAVLink_mission_count_message(1, 1, 2, MISSION))
    bench.asker.send(item(0, waypoint(), MISSION))
    bench.asker.heard()
    bench.wait(1.2)
    (again,) = answers(bench.asker)
    assert again.seq == 1
    bench.asker.send(item(1, waypoint(500), MISSION))
    assert answers(bench.asker)[-1].type == ACCEPTED


@pytest.mark.parametrize(
    ("rows", "mission_type", "expected"),
    [
        ([waypoint(), waypoint(command=31999)], MISSION, UNSUPPORTED),
        ([waypoint(), (3, 16, (0, 0, 0, 0), (2_000_000_000, LONGITUDE, 20.0))], MISSION, INVALID_X),
        ([waypoint(), (3, 16, (0, 0, 0, 0), (LATITUDE, 2_000_000_000, 20.0))], MISSION, 11),
        ([waypoint(), (3, 16, (0, 0, 0, 0), (LATITUDE, LONGITUDE, math.nan))], MISSION, 12),
        ([waypoint(), (3, 16, (math.nan, 0, 0, 0), (LATITUDE, LONGITUDE, 20.0))], MISSION, 6),
        ([waypoint(), waypoint(frame=8)], MISSION, FRAME),
        ([waypoint(command=5100)], MISSION, UNSUPPORTED),
        ([waypoint(command=16)], RALLY, UNSUPPORTED),
        ([corner(*place, 4) for place in SQUARE[:3]], FENCE, ERROR),
        ([corner(*place, 2) for place in SQUARE[:2]], FENCE, ERROR),
        ([corner(1, 1, 4), corner(1, -1, 3), corner(-1, -1, 4), corner(-1, 1, 4)], FENCE, ERROR),
        ([corner(1, 1, 300)], FENCE, 6),
        ([(0, 5003, (0.0, 0.0, 0.0, 0.0), (LATITUDE, LONGITUDE, 0.0))], FENCE, ERROR),
    ],
)
def test_what_is_refused_leaves_the_old_list_and_a_log_line(
    bench: Bench, rows: list[Row], mission_type: int, expected: int
) -> None:
    old = {
        MISSION: [waypoint(), waypoint(1000)],
        FENCE: [corner(*place, 4) for place in SQUARE],
        RALLY: [waypoint(command=5100)],
    }[mission_type]
    assert upload(bench.asker, old, mission_type) == ACCEPTED
    before = [told.to_dict() for told in download(bench.asker, mission_type)]
    bench.logged.clear()
    assert upload(bench.asker, rows, mission_type) == expected
    assert [told.to_dict() for told in download(bench.asker, mission_type)] == before
    (line,) = bench.logged
    assert f"result {expected}" in line


def test_yaw_of_a_waypoint_may_be_none(bench: Bench) -> None:
    rows = [waypoint(), (6, 16, (0.0, 0.0, 0.0, math.nan), (LATITUDE, LONGITUDE, 20.0))]
    assert upload(bench.asker, rows) == ACCEPTED


def test_items_out_of_order_or_from_strangers_are_refused(bench: Bench) -> None:
    bench.asker.send(mavlink.MAVLink_mission_count_message(1, 1, 2, MISSION))
    stranger = Asker(bench.node, 254, 190)
    (answer,) = bench.asker.ask(item(1, waypoint(), MISSION))
    assert answer.type == SEQUENCE
    (answer,) = stranger.ask(item(0, waypoint(), MISSION))
    assert answer.type == DENIED
    (answer,) = stranger.ask(mavlink.MAVLink_mission_count_message(1, 1, 1, MISSION))
    assert answer.type == DENIED
    (answer,) = stranger.ask(mavlink.MAVLink_mission_request_list_message(1, 1, MISSION))
    assert answer.type == DENIED
    (count,) = stranger.ask(mavlink.MAVLink_mission_request_list_message(1, 1, FENCE))
    assert count.get_type() == "MISSION_COUNT"


def test_an_upload_may_begin_anew(bench: Bench) -> None:
    bench.asker.send(mavlink.MAVLink_mission_count_message(1, 1, 5, MISSION))
    bench.asker.send(item(0, waypoint(), MISSION))
    assert upload(bench.asker, [waypoint(), waypoint(10), waypoint(20)]) == ACCEPTED
    assert len(download(bench.asker)) == 3


def test_a_part_of_a_mission_can_be_replaced(bench: Bench) -> None:
    assert upload(bench.asker, [waypoint(number) for number in range(5)]) == ACCEPTED
    bench.asker.heard()
    bench.asker.send(mavlink.MAVLink_mission_write_partial_list_message(1, 1, 2, 3, MISSION))
    for number in (2, 3):
        (request,) = answers(bench.asker)
        assert (request.get_type(), request.seq) == ("MISSION_REQUEST", number)
        bench.asker.send(item(number, waypoint(700 + number), MISSION))
    assert answers(bench.asker)[-1].type == ACCEPTED
    assert [told.x - LATITUDE for told in download(bench.asker)[1:]] == [1, 702, 703, 4]
    bench.asker.send(mavlink.MAVLink_mission_write_partial_list_message(1, 1, 4, 5, MISSION))
    assert answers(bench.asker)[-1].type == ERROR


def test_clearing_echoes_the_type_and_clears_one_list_or_all(bench: Bench) -> None:
    assert upload(bench.asker, [waypoint(), waypoint(1)]) == ACCEPTED
    assert upload(bench.asker, [waypoint(command=5100)], RALLY) == ACCEPTED
    (answer,) = bench.asker.ask(mavlink.MAVLink_mission_clear_all_message(1, 1, RALLY))
    assert (answer.type, answer.mission_type) == (ACCEPTED, RALLY)
    assert [len(download(bench.asker, number)) for number in (MISSION, RALLY)] == [2, 0]
    (answer,) = bench.asker.ask(mavlink.MAVLink_mission_clear_all_message(1, 1, 255))
    assert (answer.type, answer.mission_type) == (ACCEPTED, 255)
    assert download(bench.asker) == []
    (answer,) = bench.asker.ask(mavlink.MAVLink_mission_clear_all_message(1, 1, 7))
    assert answer.type == UNSUPPORTED


def test_fence_items_come_back_and_become_zones(bench: Bench) -> None:
    rows = [corner(*place, 4) for place in SQUARE]
    rows.append((0, 5004, (30.0, 0.0, 0.0, 0.0), (LATITUDE, LONGITUDE, 0.0)))
    assert upload(bench.asker, rows, FENCE) == ACCEPTED
    items = download(bench.asker, FENCE)
    assert [(told.command, told.param1, told.frame) for told in items] == [(5001, 4.0, 0)] * 4 + [(5004, 30.0, 0)]
    polygon, circle = bench.fleet.vehicles[0].flight_plan.fence_zones
    middle = bench.node.datum.to_enu(bench.node.datum.to_geodetic((0.0, 0.0, 0.0)))
    assert not polygon.breached(middle[0], middle[1])
    assert polygon.breached(middle[0] + 500.0, middle[1])
    assert circle.breached(middle[0], middle[1])


def test_an_upload_dies_with_its_connection(bench: Bench) -> None:
    bench.asker.send(mavlink.MAVLink_mission_count_message(1, 1, 2, MISSION))
    bench.node.disconnect(bench.asker.connection)
    other = Asker(bench.node, 9)
    (count,) = other.ask(mavlink.MAVLink_mission_request_list_message(1, 1, MISSION))
    assert count.count == 0
    bench.wait(9.0)
    assert "MISSION_ACK" not in kinds(other.heard())
