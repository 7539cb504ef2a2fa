"""A mapping team that cannot start, speak or measure is refused with one sentence that names the key and the mend."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest

from tests.fakes.map_missions import BEAM, diver, map_mission, map_plan
from vehicle_agent.mission.load import MissionError, check_task, plan_mission
from vehicle_agent.mission.model import RadioTable
from vehicle_agent.mission.tasks import MapTask
from vehicle_agent.mission.vehicles import RangeSensor


def refusal(**changes: Any) -> str:
    with pytest.raises(MissionError) as caught:
        check_task(map_plan(**changes))
    text = str(caught.value)
    assert "\n" not in text
    return text


def test_the_mission_itself_is_good() -> None:
    check_task(map_plan())


def test_a_start_out_of_everyones_radio_range() -> None:
    text = refusal(radio=RadioTable(packet_bytes=200, range_m=10.0))
    assert "vehicles[0].start_enu_m" in text
    assert "out of everyone's radio range" in text


def test_a_capacity_of_nothing() -> None:
    with pytest.raises(MissionError, match=r"task\.capacity: .*>= 1"):
        plan_mission(map_mission(task=msgspec.structs.replace(MapTask(), capacity=0)))


def test_a_vehicle_that_stays_down_and_does_not_exist() -> None:
    text = refusal(task=MapTask(stays_down=("brisa", "carla")))
    assert "task.stays_down" in text
    assert "'carla'" in text
    assert "alba, brisa" in text


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"type": "multicopter"}, "vehicles[1].type"),
        ({"sensor": RangeSensor(range_m=40.0)}, "vehicles[1].sensor.kind"),
        ({"sensor": msgspec.structs.replace(BEAM, noise_fraction=0.0)}, "vehicles[1].sensor.noise_fraction"),
        ({"depth_m": None}, "vehicles[1].depth_m"),
        ({"depth_m": 2.5}, "vehicles[1].depth_m"),
    ],
)
def test_a_vehicle_that_cannot_map(changes: dict[str, Any], key: str) -> None:
    vehicles = (diver("alba", 10.0, 2.0), msgspec.structs.replace(diver("brisa", 30.0, 3.5), **changes))
    assert key in refusal(vehicles=vehicles)


def test_a_sensor_that_sees_nothing_from_the_least_height_allowed() -> None:
    blind = diver("brisa", 30.0, 3.5, sensor=msgspec.structs.replace(BEAM, range_m=0.9))
    assert "vehicles[1].sensor.range_m" in refusal(vehicles=(diver("alba", 10.0, 2.0), blind))


def test_a_sensor_that_sees_nothing_from_the_depth_ordered() -> None:
    """The floor is the simulator's to know: it says so when it is asked."""
    from missions.yardstick import observable
    from sim_bridge.world import World

    short = msgspec.structs.replace(BEAM, range_m=2.0)
    plan = map_plan(vehicles=(diver("alba", 10.0, 2.0, sensor=short), diver("brisa", 30.0, 3.5, sensor=short)))
    with pytest.raises(MissionError, match=r"vehicles\[0\]\.sensor\.range_m: .* sees nothing of the floor"):
        observable(plan, World.of(plan))
