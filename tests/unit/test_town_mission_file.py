"""Mission files of towns: what contradicts itself is a sentence with the key and the mend."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest

from tests.fakes.hill_missions import hill_mission
from tests.fakes.town_missions import town_content, town_plan
from vehicle_agent.behaviour.preflight import parameters_before_arming, return_height_m, take_off_height_m
from vehicle_agent.mission.load import MissionError, check_task, plan_mission
from vehicle_agent.mission.model import Mission
from vehicle_agent.mission.tasks import ExploreTask

AREA = {"cell_m": 1.0, "rectangle_enu_m": [0.0, 0.0, 40.0, 40.0], "fence_margin_m": 1.0, "up_m": [-1.0, 17.0]}


def check(content: dict[str, Any]) -> None:
    check_task(plan_mission(msgspec.convert(content, Mission)))


def test_a_town_has_voxels_over_its_cells() -> None:
    plan = town_plan()
    assert plan.voxel_grid is not None
    assert plan.voxel_grid.shape == (40, 40, 18)
    assert plan.voxel_grid.shape[:2] == plan.grid.shape
    check(town_content())
    check(town_content(task={"kind": "cover", "explore_first": True}))


def test_planner_left_out_is_the_best_for_the_ground() -> None:
    town = plan_mission(msgspec.convert(town_content(task={"kind": "explore"}), Mission)).mission.task
    hills = plan_mission(hill_mission(task={"kind": "explore"})).mission.task
    assert isinstance(town, ExploreTask)
    assert isinstance(hills, ExploreTask)
    assert (town.planner, hills.planner) == ("tours", "lanes")


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"area": {**AREA, "up_m": None}}, r"area.up_m: missing; a town needs"),
        ({"area": {**AREA, "up_m": [0.0, 17.0]}}, r"area.up_m: must be \[-1, highest\]"),
        ({"area": {**AREA, "up_m": [-1.0, 14.0]}}, r"vehicles\[0\].max_above_terrain_m: must be at most 12 m"),
        (
            {"area": {**AREA, "cell_m": 0.05, "up_m": [-0.05, 17.0]}},
            r"area.cell_m: 0.05 m makes \d+ voxels; choose 0.1",
        ),
        ({"terrain": {"kind": "town", "height_m": [9.0, 5.0]}}, r"terrain.height_m: must be \[lowest, highest\]"),
        ({"terrain": {"kind": "town", "street_m": [8.0, 40.0]}}, r"terrain.street_m: must be \[narrowest, widest\]"),
        ({"task": {"kind": "explore", "planner": "claims"}}, "task.planner: towns can be explored by planner 'tours'"),
        (
            {"task": {"kind": "cover", "known_points_enu_m": [[1.0, 1.0, 0.0]]}},
            "task.known_points_enu_m: a few points say nothing of a town's buildings; leave them out",
        ),
    ],
)
def test_what_no_team_could_fly_is_a_sentence(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(MissionError, match=sentence):
        check(town_content(**changes))


@pytest.mark.parametrize(
    ("sensor", "up_m", "sentence"),
    [
        ({"kind": "range", "range_m": 10.0}, [-1.0, 17.0], "a map of voxels is seen by 'half-sphere' only"),
        ({"kind": "half-sphere", "range_m": 10.0}, None, "'half-sphere' sees voxels; give area.up_m"),
    ],
)
def test_a_sensor_must_see_what_the_map_is_made_of(sensor: dict[str, Any], up_m: Any, sentence: str) -> None:
    content = town_content(area={**AREA, "up_m": up_m}, terrain={"kind": "flat"} if up_m is None else {"kind": "town"})
    content["vehicles"][1]["sensor"] = sensor
    if up_m is None:
        content["vehicles"][0]["sensor"] = {"kind": "range", "range_m": 10.0}
    with pytest.raises(MissionError, match=r"vehicles\[1\].sensor.kind: " + sentence):
        check(content)


def test_vehicles_work_below_where_their_autopilots_return_by_themselves() -> None:
    plan = town_plan(vehicles=3)
    heights = [return_height_m(plan, index, 0.0, 0.0) for index in range(3)]
    assert take_off_height_m(plan, 0) == 13.5
    assert min(heights) > 13.5
    assert len(set(heights)) == 3
    asked = [{p.name: p.value for p in parameters_before_arming(plan, index)}["RTL_ALT"] for index in range(3)]
    assert asked == [round(100.0 * height) for height in heights]
