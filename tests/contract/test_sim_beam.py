"""What a vehicle tells of its single beam over MAVLink: distances along the beam, limits, noise, and who tells what."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sim_bridge.autopilot.node import Node
from sim_bridge.fleet import Fleet
from sim_bridge.payload import Payload
from sim_bridge.world import World
from tests.fakes.sim_client import Asker, kinds
from tests.fakes.sim_missions import GROUND_M, sim_plan
from tests.fakes.sim_teams import SEA_FLOOR_M, armed, member, sea_fleet, until
from vehicle_agent.domain.grid import Grid
from vehicle_agent.mission.load import MissionError

RANGEFINDER, DISTANCE_SENSOR, WATER_DEPTH, OBSTACLE_DISTANCE = 173, 132, 11038, 330


def beam(range_m: float = 50.0, **changes: Any) -> dict[str, Any]:
    return {"kind": "single-beam", "range_m": range_m, **changes}


def told(fleet: Fleet, message_id: int) -> list[Any]:
    """Answers of vehicle 0 to a request, without the acknowledgement."""
    asker = Asker(Node(fleet.vehicles[0], fleet.plan.datum))
    return asker.command(512, message_id)[1:]


def dived(depth_m: float, sensor: dict[str, Any]) -> Fleet:
    """An underwater vehicle at a depth, 40 m of water over the ground."""
    fleet = sea_fleet(member("seal", type="underwater-vehicle", sensor=sensor))
    vehicle = armed(fleet)
    east_m, north_m, _ = vehicle.pilot.position_enu_m
    assert vehicle.go_to((east_m, north_m, -depth_m)).accepted
    until(fleet, lambda v: abs(v.true_position_enu_m[2] + depth_m) < 0.02)
    return fleet


def test_an_underwater_vehicle_tells_how_far_the_floor_is_without_being_set_up_first() -> None:
    fleet = dived(12.0, beam(60.0, min_range_m=0.5))
    (sounding,) = told(fleet, DISTANCE_SENSOR)
    assert sounding.current_distance == pytest.approx(100 * (-12.0 - SEA_FLOOR_M), abs=5)
    assert (sounding.min_distance, sounding.max_distance) == (50, 6000)
    assert sounding.orientation == 25  # MAV_SENSOR_ROTATION_PITCH_270: downwards
    (distance,) = told(fleet, RANGEFINDER)
    assert distance.distance == pytest.approx(28.0, abs=0.05)
    assert told(fleet, WATER_DEPTH) == []


def test_a_boat_tells_the_depth_of_water() -> None:
    fleet = sea_fleet(member("tern", type="surface-vessel", sensor=beam()))
    fleet.step(6.0)
    (sounding,) = told(fleet, WATER_DEPTH)
    assert (sounding.distance, sounding.healthy) == (pytest.approx(-SEA_FLOOR_M), 1)


@pytest.mark.parametrize("sensor", [beam(30.0), beam(39.9)])
def test_beyond_its_range_a_beam_tells_more_than_its_range(sensor: dict[str, Any]) -> None:
    fleet = sea_fleet(member("tern", type="surface-vessel", sensor=sensor))
    fleet.step(6.0)
    (sounding,) = told(fleet, DISTANCE_SENSOR)
    assert sounding.current_distance == sounding.max_distance + 1
    (depth,) = told(fleet, WATER_DEPTH)
    assert depth.healthy == 0


def test_too_near_a_beam_tells_less_than_it_can_measure() -> None:
    fleet = dived(37.0, beam(min_range_m=5.0))
    (sounding,) = told(fleet, DISTANCE_SENSOR)
    assert sounding.current_distance < sounding.min_distance


def test_the_noise_is_a_share_of_the_distance_and_the_same_for_everybody() -> None:
    fleet = sea_fleet(member("tern", type="surface-vessel", sensor=beam(noise_fraction=0.05, period_s=0.1)))
    vehicle = fleet.vehicles[0]
    readings = []
    for _ in range(2000):
        fleet.step(0.1)
        readings.append(vehicle.range_down_m())
    inside = [reading for reading in readings if math.isfinite(reading)]
    assert np.mean(inside) == pytest.approx(40.0, abs=0.3)
    assert np.std(inside) == pytest.approx(0.05 * 40.0, rel=0.1)
    (first,), (second,) = told(fleet, DISTANCE_SENSOR), told(fleet, DISTANCE_SENSOR)
    assert first.current_distance == second.current_distance == round(100 * readings[-1])


def test_readings_repeat_with_the_seed_whoever_listens() -> None:
    def readings(listens: bool) -> list[float]:
        fleet = sea_fleet(member("tern", type="surface-vessel", sensor=beam(noise_fraction=0.05)))
        node = Node(fleet.vehicles[0], fleet.plan.datum)
        asker = Asker(node)
        heard = []
        for _ in range(50):
            fleet.step(0.1)
            if listens:
                asker.command(512, DISTANCE_SENSOR)
            heard.append(fleet.vehicles[0].range_down_m())
        return heard

    assert readings(False) == readings(True)


def test_a_copter_measures_along_its_tilted_beam() -> None:
    plan = sim_plan(
        team=[member("gull", speed_m_s=15.0, start_enu_m=[200.0, 200.0], sensor=beam(200.0, period_s=0.05))]
    )
    fleet = Fleet(plan, World.of(plan))
    vehicle = armed(fleet)
    assert vehicle.take_off(40.0).accepted
    until(fleet, lambda v: v.pilot.height_above_ground_m() > 39.5)
    assert vehicle.range_down_m() == pytest.approx(vehicle.pilot.height_above_ground_m(), abs=0.2)
    assert vehicle.go_to((900.0, 900.0, GROUND_M + 40.0)).accepted
    until(fleet, lambda v: math.hypot(*v.attitude_rad) > 0.15)
    roll, pitch = vehicle.attitude_rad
    upright_m = vehicle.pilot.height_above_ground_m()
    assert vehicle.range_down_m() == pytest.approx(upright_m / (math.cos(roll) * math.cos(pitch)), abs=0.1)


def test_a_slanted_ray_meets_the_slope_where_geometry_says() -> None:
    grid = Grid(0.0, 0.0, 1.0, 100, 100)
    world = World(grid, np.broadcast_to(0.5 * grid.centres_east_m()[:, None], grid.shape).copy())
    direction = (math.sin(0.4), 0.0, -math.cos(0.4))
    east_m, up_m = 20.0, 40.0
    expected_m = (up_m - 0.5 * east_m) / (math.cos(0.4) + 0.5 * math.sin(0.4))
    assert world.distance_along_m((east_m, 50.0, up_m), direction, 100.0) == pytest.approx(expected_m, abs=1e-3)
    assert world.distance_along_m((east_m, 50.0, up_m), direction, expected_m - 0.1) == math.inf
    assert world.distance_along_m((east_m, 50.0, up_m), (0.0, 0.0, 1.0), 100.0) == math.inf
    assert world.distance_along_m((east_m, 50.0, 5.0), direction, 100.0) == 0.0


def test_obstacles_around_are_told_by_sector_from_the_nose(tmp_path: Path) -> None:
    """A cliff in the east, 100 m high from 60 m away; the nose points north."""
    east_m = 2.5 + 5.0 * np.arange(200)
    elevation_m = np.where(east_m[:, None] > 260.0, 100.0, 0.0) * np.ones((1, 200))
    np.savez(tmp_path / "cliff.npz", elevation_amsl_m=elevation_m, west_m=0.0, south_m=0.0, cell_m=5.0)
    plan = sim_plan(
        tmp_path / "mission.toml",
        team=[member("gull", start_enu_m=[200.0, 200.0])],
        datum={"latitude_deg": 36.57, "longitude_deg": -84.27},
        area={"cell_m": 5.0, "rectangle_enu_m": [2.5, 2.5, 997.5, 997.5]},
        terrain={"kind": "grid", "file": "cliff.npz"},
    )
    fleet = Fleet(plan, World.of(plan))
    vehicle = armed(fleet)
    assert vehicle.set_parameter("PRX1_TYPE", 2).accepted
    assert vehicle.take_off(30.0).accepted
    until(fleet, lambda v: v.true_position_enu_m[2] > 29.0)
    (around,) = told(fleet, OBSTACLE_DISTANCE)
    north, east, south = around.distances[0], around.distances[18], around.distances[36]
    assert (north, south) == (65_535, 65_535)
    assert east == pytest.approx(6_000, abs=500)
    assert around.increment_f == pytest.approx(5.0)


def test_the_payload_says_no_scans_for_a_beam() -> None:
    fleet = sea_fleet(member("tern", type="surface-vessel", sensor=beam()))
    said: list[str] = []

    class Link:
        def publish(self, message: object, participant: str | None = None) -> None:
            said.append(type(message).__name__)

    payload = Payload(fleet, Link(), 1)
    armed(fleet)
    for _ in range(100):
        fleet.step(0.05)
        payload.tick()
    assert set(said) == {"BodyReport"}


def test_a_beam_that_measures_nothing_is_refused() -> None:
    with pytest.raises(MissionError, match=r"vehicles\[0\]\.sensor\.min_range_m: must be smaller than range_m"):
        sea_fleet(member("tern", type="surface-vessel", sensor=beam(50.0, min_range_m=50.0)))


def test_without_a_rangefinder_nothing_is_told() -> None:
    fleet = sea_fleet(member("tern", type="surface-vessel"))
    fleet.step(6.0)
    assert kinds(told(fleet, DISTANCE_SENSOR) + told(fleet, WATER_DEPTH) + told(fleet, RANGEFINDER)) == []
