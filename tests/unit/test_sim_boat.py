"""A simulated surface vessel: its turning circle, the current, the ground, and failsafes as ArduRover has them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim_bridge.modes import Behaviour
from sim_bridge.personalities.ardupilot_rover import RoverMode
from sim_bridge.reply import Outcome
from tests.fakes.sim_teams import armed, boat_fleet, member, sea_fleet, texts, until


def test_it_starts_as_a_rover_does() -> None:
    fleet = boat_fleet()
    boat = fleet.vehicles[0]
    assert boat.mode is RoverMode.INITIALISING
    fleet.step(1.0)
    assert boat.mode is RoverMode.MANUAL
    assert boat.set_mode(RoverMode.HOLD).accepted
    assert boat.set_mode(RoverMode.GUIDED).outcome is Outcome.FAILED
    assert "Flight mode change failed" in texts(boat)
    assert boat.start_takeoff(10.0).outcome is Outcome.UNSUPPORTED
    assert boat.land().outcome is Outcome.UNSUPPORTED


def test_it_goes_to_its_target_and_returns_on_the_water() -> None:
    fleet = boat_fleet()
    boat = armed(fleet)
    assert "Throttle armed" in texts(boat)
    boat.set_parameter("WP_SPEED", 4.0)
    assert boat.go_to((300.0, 280.0, 25.0)).accepted
    fleet.step(90.0)
    east_m, north_m, up_m = boat.true_position_enu_m
    assert math.hypot(east_m - 300.0, north_m - 280.0) < 3.0
    assert up_m == 0.0
    assert boat.return_home().accepted
    until(fleet, lambda b: math.hypot(b.true_position_enu_m[0] - 200.0, b.true_position_enu_m[1] - 200.0) < 3.0)
    assert boat.disarm().accepted
    assert boat.has_flown
    assert not boat.crashed


def test_its_turning_circle_has_the_radius_of_the_parameter() -> None:
    fleet = boat_fleet()
    boat = armed(fleet)
    for name, value in (("TURN_RADIUS", 20.0), ("WP_SPEED", 3.0)):
        assert boat.set_parameter(name, value).accepted
    boat.go_to((200.0, 400.0, 0.0))
    fleet.step(20.0)
    boat.go_to((200.0, 0.0, 0.0))
    track = []
    for _ in range(300):
        fleet.step(0.2)
        track.append(boat.true_position_enu_m[0])
    # It comes about within a circle of twice the radius, and cannot turn on the spot.
    width_m = max(track) - min(track)
    assert 20.0 < width_m < 45.0


@pytest.mark.parametrize("behaviour", [Behaviour.PILOTED, Behaviour.BRAKE])
def test_an_idle_boat_is_carried_off_by_the_current(behaviour: Behaviour) -> None:
    fleet = boat_fleet(current_m_s=[0.5, -0.25])
    boat = armed(fleet)
    assert boat.enter(behaviour).accepted
    before = np.array(boat.true_position_enu_m)
    fleet.step(40.0)
    np.testing.assert_allclose(np.array(boat.true_position_enu_m) - before, [20.0, -10.0, 0.0], atol=1.5)


def test_it_holds_its_place_and_its_course_against_the_current() -> None:
    fleet = boat_fleet(current_m_s=[0.5, 0.0])
    boat = armed(fleet)
    boat.go_to((200.0, 300.0, 0.0))
    aside = []
    for _ in range(300):
        fleet.step(0.2)
        aside.append(abs(boat.true_position_enu_m[0] - 200.0))
    assert max(aside) < 12.0
    assert boat.hold().accepted
    place = np.array(boat.true_position_enu_m)
    for _ in range(100):
        fleet.step(1.0)
        assert float(np.linalg.norm(np.array(boat.true_position_enu_m) - place)) < 15.0


def test_running_aground_at_speed_wrecks_it() -> None:
    fleet = sea_fleet(member("tern", type="surface-vessel"))
    fleet.world.elevation_m[20:, :] = 1.0
    boat = armed(fleet)
    boat.set_parameter("WP_SPEED", 5.0)
    boat.go_to((700.0, 210.0, 0.0))
    until(fleet, lambda b: b.crashed)
    assert not boat.armed
    assert boat.true_position_enu_m[0] < 410.0


def test_silence_of_the_controller_stops_it() -> None:
    fleet = boat_fleet()
    boat = armed(fleet)
    for name, value in (("SYSID_MYGCS", 101), ("FS_GCS_ENABLE", 1), ("FS_ACTION", 2)):
        assert boat.set_parameter(name, value).accepted
    boat.heard_controller(101)
    boat.go_to((400.0, 400.0, 0.0))
    fleet.step(5.4)
    assert boat.mode is RoverMode.HOLD
    assert "GCS Failsafe" in texts(boat)


def test_it_draws_with_the_cube_of_its_speed() -> None:
    used = []
    for speed in (1.0, 2.0):
        fleet = boat_fleet(endurance_s=1000.0)
        boat = armed(fleet)
        boat.set_parameter("CRUISE_SPEED", 2.0)
        boat.go_to((200.0, 900.0, 0.0))
        boat.set_speed(speed)
        fleet.step(20.0)
        before = boat.battery.remaining
        fleet.step(20.0)
        used.append(before - boat.battery.remaining)
    assert used[1] == pytest.approx(20.0 / 1000.0, rel=0.02)
    assert used[1] / used[0] > 4.0
