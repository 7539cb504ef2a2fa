"""When a mission is over, from statuses and the simulator's reports alone."""

from __future__ import annotations

import itertools

import pytest

from missions.ending import (
    RETURN_ALLOWANCE_S,
    SILENT_AFTER_S,
    STANDSTILL_S,
    START_ALLOWANCE_S,
    Ending,
    MissionWatch,
    VehicleRecord,
)
from vehicle_agent.wire.messages import BodyReport, Stage, Status

TIME_LIMIT_S = 300.0
_sequence = itertools.count()


def watch(*names: str, simulated: bool = True) -> MissionWatch:
    records = {name: VehicleRecord(simulated) for name in names}
    return MissionWatch(records, TIME_LIMIT_S, 1.0 if simulated else None, started_s=0.0)


def status(name: str, stage: Stage, armed: bool, at_s: float, east_m: float = 0.0) -> Status:
    here = (round(100 * east_m), 0, 0)
    return Status(
        sender=name, boot_id=1, sequence=next(_sequence), stamp_ms=round(1000 * at_s), stage=stage, mode="guided",
        armed=armed, position_cm=here, velocity_cm_s=(0, 0, 0), heading_deg=0, battery_permille=900, leg_end_cm=here,
        home_cm=(0, 0, 0), known_permille=0, first_seen_cells=0, bytes_sent=0, messages_dropped=0, why="",
    )  # fmt: skip


def body(name: str, armed: bool, at_s: float, east_m: float = 0.0, crashed: bool = False) -> BodyReport:
    return BodyReport(
        sender="simulator", boot_id=1, sequence=next(_sequence), stamp_ms=round(1000 * at_s), vehicle=name,
        position_cm=(round(100 * east_m), 0, 0), armed=armed, has_flown=True, crashed=crashed, mode="guided",
    )  # fmt: skip


def fly(watched: MissionWatch, name: str, at_s: float, now_s: float) -> None:
    watched.hear([status(name, Stage.WORKING, True, at_s), body(name, True, at_s)], now_s)


def finish(watched: MissionWatch, name: str, at_s: float, now_s: float) -> None:
    watched.hear([status(name, Stage.DONE, False, at_s), body(name, False, at_s)], now_s)


def test_not_over_before_anything_is_heard():
    assert watch("one").ending(5.0) is None


def test_over_when_everybody_is_done_and_down():
    watched = watch("one", "two")
    fly(watched, "one", 10.0, 1.0)
    fly(watched, "two", 12.0, 1.2)
    finish(watched, "one", 70.0, 7.0)
    assert watched.ending(7.0) is None
    finish(watched, "two", 90.0, 9.0)
    over = watched.ending(9.0)
    assert over is not None
    assert over[0] is Ending.COMPLETE
    assert watched.elapsed_s == 80.0
    assert watched.first_airborne_s == 1.0


def test_done_is_not_believed_while_the_body_is_armed():
    watched = watch("one")
    fly(watched, "one", 10.0, 1.0)
    watched.hear([status("one", Stage.DONE, False, 20.0), body("one", True, 20.0)], 2.0)
    assert watched.ending(2.0) is None


def test_a_refused_vehicle_on_the_ground_holds_nobody_up():
    watched = watch("one", "two")
    watched.hear([status("one", Stage.REFUSED, False, 5.0), body("one", False, 5.0)], 0.5)
    fly(watched, "two", 10.0, 1.0)
    assert watched.ending(1.0) is None
    finish(watched, "two", 20.0, 2.0)
    assert watched.ending(2.0) is not None


def test_a_vehicle_whose_agent_died_is_waited_for_until_it_is_down():
    watched = watch("one", "two")
    fly(watched, "one", 10.0, 1.0)
    fly(watched, "two", 10.0, 1.0)
    watched.agent_ended("one")
    finish(watched, "two", 50.0, 5.0)
    assert watched.ending(5.0) is None
    watched.hear([body("one", False, 60.0)], 6.0)
    over = watched.ending(6.0)
    assert over is not None
    assert over[0] is Ending.COMPLETE


def test_a_vehicle_without_agent_that_never_lands_ends_the_mission_with_its_name():
    watched = watch("one", "two")
    fly(watched, "one", 10.0, 1.0)
    fly(watched, "two", 10.0, 1.0)
    watched.agent_ended("one")
    finish(watched, "two", 50.0, 5.0)
    assert watched.ending(5.0) is None
    watched.hear([body("one", True, 51.0 + RETURN_ALLOWANCE_S)], 6.0)
    over = watched.ending(6.0)
    assert over is not None
    assert over[0] is Ending.NOT_LANDED
    assert "one" in over[1]


def test_a_frozen_agent_counts_as_gone_and_speaks_again():
    watched = watch("one")
    fly(watched, "one", 10.0, 1.0)
    record = watched.vehicles["one"]
    assert record.agent_lives(1.0 + SILENT_AFTER_S)
    assert not record.agent_lives(1.1 + SILENT_AFTER_S)
    fly(watched, "one", 200.0, 20.0)
    assert record.agent_lives(20.0)


def test_a_crash_settles_a_vehicle_whatever_its_agent_believes():
    watched = watch("one")
    fly(watched, "one", 10.0, 1.0)
    watched.hear([body("one", False, 11.0, crashed=True)], 1.1)
    assert watched.ending(1.1) is not None


def test_far_beyond_the_time_limit_the_mission_is_given_up():
    watched = watch("one")
    fly(watched, "one", 10.0, 1.0)
    fly(watched, "one", 10.0 + TIME_LIMIT_S + RETURN_ALLOWANCE_S, 100.0)
    assert watched.ending(100.0) is None
    fly(watched, "one", 10.1 + TIME_LIMIT_S + RETURN_ALLOWANCE_S, 100.1)
    over = watched.ending(100.1)
    assert over is not None
    assert over[0] is Ending.TIME_LIMIT


def test_a_simulated_fleet_that_never_takes_off_is_given_up_and_a_real_one_waits_for_people():
    for simulated, expected in ((True, Ending.NO_TAKEOFF), (False, None)):
        watched = watch("one", simulated=simulated)
        watched.hear([status("one", Stage.CONNECTING, False, 1.0)], 1.0 + START_ALLOWANCE_S)
        over = watched.ending(2.0 + START_ALLOWANCE_S)
        assert (over[0] if over else None) is expected


def test_a_fleet_of_which_nothing_more_is_heard_is_given_up():
    watched = watch("one")
    fly(watched, "one", 10.0, 1.0)
    assert watched.ending(1.0 + STANDSTILL_S) is None
    over = watched.ending(1.1 + STANDSTILL_S)
    assert over is not None
    assert over[0] is Ending.STANDSTILL


def test_a_real_vehicle_is_followed_by_its_own_word():
    watched = watch("one", simulated=False)
    watched.hear([status("one", Stage.WORKING, True, 10.0), status("one", Stage.WORKING, True, 12.0, 30.0)], 1.0)
    assert watched.vehicles["one"].flown_m == pytest.approx(30.0)
    watched.hear([status("one", Stage.DONE, False, 20.0, 30.0)], 2.0)
    assert watched.ending(2.0) is not None
    assert watched.elapsed_s == 10.0


def test_the_track_counts_from_arming_only():
    watched = watch("one")
    watched.hear([body("one", False, 1.0, 500.0), body("one", True, 2.0), body("one", True, 3.0, 20.0)], 0.3)
    watched.hear([body("one", True, 4.0, 50.0), body("one", False, 5.0, 50.0), body("one", False, 6.0, 90.0)], 0.6)
    assert watched.vehicles["one"].flown_m == pytest.approx(50.0)


def test_strangers_are_not_followed():
    watched = watch("one")
    fly(watched, "stranger", 10.0, 1.0)
    assert watched.first_take_off_ms is None
