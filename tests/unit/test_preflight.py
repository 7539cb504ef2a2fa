"""Parameters before arming, and the height of the autopilot's own return."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.fakes.sim_missions import sim_plan
from vehicle_agent.behaviour.elevation_share import ElevationShare
from vehicle_agent.behaviour.preflight import ATTEMPTS, Checklist, parameters_before_arming, return_height_m
from vehicle_agent.behaviour.return_height import ReturnHeight
from vehicle_agent.domain.elevation import CellObservations
from vehicle_agent.ports import ActionResult, SensorScan

PLAN = sim_plan(vehicles=3)


def test_the_autopilot_is_told_whom_to_watch_before_anything_else() -> None:
    for index in range(3):
        parameters = parameters_before_arming(PLAN, index)
        values = {parameter.name: parameter.value for parameter in parameters}
        assert parameters[0].name == "SYSID_MYGCS"
        assert values["SYSID_MYGCS"] == PLAN.controller_system_id(index)
        assert values["FS_GCS_ENABLE"] == 1.0
        assert values["FS_GCS_TIMEOUT"] == 5.0
        assert values["WPNAV_SPEED"] == 1_500.0


@given(st.lists(st.tuples(st.floats(-100.0, 900.0), st.floats(-50.0, 300.0)), min_size=3, max_size=3))
def test_vehicles_return_at_heights_of_their_own_whatever_each_knows(known: list[tuple[float, float]]) -> None:
    separation_m = PLAN.mission.safety.separation_m
    above_m = [return_height_m(PLAN, index, highest, home) for index, (highest, home) in enumerate(known)]
    heights = [home + above for above, (_, home) in zip(above_m, known, strict=True)]
    for height, (highest, home) in zip(heights, known, strict=True):
        assert max(highest, home) + 30.0 <= height + 1e-6 <= max(highest, home) + 30.0 + 3 * 2.0 * separation_m
    assert all(abs(one - other) > separation_m for one, other in itertools.combinations(heights, 2))


def play(checklist: Checklist, answers: dict[str, bool]) -> list[str]:
    asked = []
    for action_id in range(100):
        order = checklist.next_order()
        if order is None:
            break
        asked.append(order.name)
        checklist.submitted(action_id)
        assert checklist.next_order() is None
        checklist.hear(ActionResult(action_id + 1_000, True))  # somebody else's
        assert checklist.next_order() is None
        checklist.hear(ActionResult(action_id, answers.get(order.name, True), "no such parameter"))
    return asked


def test_every_parameter_is_set_once_in_order() -> None:
    parameters = parameters_before_arming(PLAN, 0)
    checklist = Checklist(parameters)
    assert play(checklist, {}) == [parameter.name for parameter in parameters]
    assert checklist.done
    assert not checklist.failed


def test_a_refused_parameter_is_tried_again_and_then_named() -> None:
    checklist = Checklist(parameters_before_arming(PLAN, 0))
    asked = play(checklist, {"FS_GCS_ENABLE": False})
    assert asked == ["SYSID_MYGCS"] + ["FS_GCS_ENABLE"] * ATTEMPTS
    assert not checklist.done
    assert "FS_GCS_ENABLE" in checklist.failed
    assert "no such parameter" in checklist.failed


def mapped(elevation_dm: int) -> ElevationShare:
    shared = ElevationShare(PLAN.grid, 0)
    shared.take_scan(
        SensorScan(CellObservations(np.array([5]), np.array([elevation_dm], dtype=np.int32), np.array([1])))
    )
    return shared


def test_the_return_height_rises_with_the_known_ground_and_not_too_often() -> None:
    height = ReturnHeight(PLAN, 0)
    before_m = height.height_m
    assert height.due_m(0.0, ElevationShare(PLAN.grid, 0), 0.0) is None
    assert height.due_m(1.0, mapped(2_000), 50.0) is None  # not yet time
    wanted_m = height.due_m(4.0, mapped(2_000), 50.0)
    assert wanted_m is not None
    assert wanted_m >= 200.0 - 50.0 + 30.0
    assert height.height_m == before_m
    height.asked(7, wanted_m)
    height.hear(ActionResult(6, True))
    assert height.height_m == before_m
    height.hear(ActionResult(7, True))
    assert height.height_m == wanted_m
    assert height.due_m(8.0, mapped(2_000), 50.0) is None
    assert height.due_m(12.0, mapped(2_050), 50.0) is None  # a little higher: its lane is still above


def test_a_refused_return_height_is_asked_for_again() -> None:
    height = ReturnHeight(PLAN, 0)
    before_m = height.height_m
    first_m = height.due_m(0.0, mapped(2_000), 50.0)
    assert first_m is not None
    height.asked(7, first_m)
    height.hear(ActionResult(7, False, "busy"))
    assert height.height_m == before_m
    assert height.due_m(5.0, mapped(2_000), 50.0) == pytest.approx(first_m)
