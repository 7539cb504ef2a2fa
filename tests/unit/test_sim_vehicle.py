"""The simulated copter's flight modes, arming rules and failsafes, against what ArduCopter does."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from sim_bridge.fleet import Fleet
from sim_bridge.modes import LandedState
from sim_bridge.personalities.ardupilot_copter import CopterMode
from sim_bridge.reply import Outcome
from sim_bridge.vehicle import Vehicle
from sim_bridge.world import World
from tests.fakes.sim_missions import GROUND_M, sim_plan

CONTROLLER_ID = 101


@pytest.fixture
def fleet() -> Fleet:
    plan = sim_plan()
    return Fleet(plan, World.of(plan))


def until(fleet: Fleet, condition: Callable[[Vehicle], bool], limit_s: float = 600.0, beat: bool = False) -> None:
    """Let time pass until vehicle 0 satisfies the condition."""
    end_s = fleet.time_s + limit_s
    while not condition(fleet.vehicles[0]):
        assert fleet.time_s < end_s, "it never came about"
        if beat:
            fleet.vehicles[0].heard_controller(CONTROLLER_ID)
        fleet.step(0.25)


def flying(fleet: Fleet, height_m: float = 30.0) -> Vehicle:
    """Vehicle 0 in the air at a height above home, watched by no one yet."""
    copter = fleet.vehicles[0]
    for name, value in (("SYSID_MYGCS", CONTROLLER_ID), ("WPNAV_SPEED_UP", 500.0), ("WPNAV_SPEED_DN", 400.0)):
        assert copter.set_parameter(name, value).accepted
    until(fleet, lambda c: c.ready_to_arm)
    assert copter.arm().accepted
    assert copter.take_off(height_m).accepted
    until(fleet, lambda c: c.landed_state is LandedState.IN_AIR)
    return copter


def texts(copter: Vehicle) -> list[str]:
    return [status.text for status in copter.drain_texts()]


def test_arming_waits_for_the_position(fleet: Fleet) -> None:
    copter = fleet.vehicles[0]
    reply = copter.arm()
    assert reply.outcome is Outcome.FAILED
    assert "Mode change to GUIDED failed: requires position" in texts(copter)
    fleet.step(4.2)
    assert copter.position_known
    assert copter.set_mode(CopterMode.GUIDED).accepted
    assert copter.arm_motors().outcome is Outcome.FAILED
    assert "Arm: Need Position Estimate" in texts(copter)
    fleet.step(2.0)
    assert copter.snapshot.ready_to_arm
    assert copter.arm().accepted


def test_an_armed_copter_on_the_ground_disarms_itself(fleet: Fleet) -> None:
    copter = fleet.vehicles[0]
    fleet.step(6.0)
    copter.arm()
    fleet.step(9.0)
    assert copter.armed
    fleet.step(2.0)
    assert not copter.armed
    assert not copter.has_flown


def test_takeoff_needs_arming_and_an_altitude_above(fleet: Fleet) -> None:
    copter = fleet.vehicles[0]
    fleet.step(6.0)
    assert copter.take_off(10.0).outcome is Outcome.FAILED
    copter.arm()
    assert not copter.take_off(0.0).accepted
    assert not copter.take_off(float("nan")).accepted
    assert copter.take_off(10.0).accepted
    until(fleet, lambda c: c.landed_state is LandedState.IN_AIR)
    fleet.step(5.0)
    assert copter.snapshot.position_enu_m[2] == pytest.approx(GROUND_M + 10.0, abs=0.05)
    assert not copter.take_off(20.0).accepted
    assert copter.disarm().outcome is Outcome.FAILED


def test_a_target_on_the_ground_moves_nothing(fleet: Fleet) -> None:
    copter = fleet.vehicles[0]
    fleet.step(6.0)
    copter.arm()
    assert copter.go_to((500.0, 500.0, 200.0)).accepted
    fleet.step(5.0)
    assert copter.landed
    assert copter.snapshot.position_enu_m == pytest.approx((200.0, 200.0, GROUND_M))


@pytest.mark.parametrize("place", [(float("nan"), 0.0, 0.0), (0.0, float("inf"), 0.0), (0.0, 0.0, 1e30)])
def test_a_target_that_is_no_place_is_denied(fleet: Fleet, place: tuple[float, float, float]) -> None:
    copter = flying(fleet)
    assert copter.go_to(place).outcome is Outcome.DENIED
    assert not copter.set_parameter("WPNAV_SPEED", float("nan")).accepted
    assert copter.set_home(place).outcome is Outcome.DENIED


def test_speed_follows_parameters_and_orders(fleet: Fleet) -> None:
    copter = flying(fleet)
    copter.set_parameter("WPNAV_SPEED", 1200.0)
    copter.go_to((900.0, 200.0, 80.0))
    fleet.step(15.0)
    assert copter.snapshot.velocity_enu_m_s[0] == pytest.approx(12.0, abs=0.1)
    assert copter.set_speed(6.0).accepted
    fleet.step(5.0)
    assert copter.snapshot.velocity_enu_m_s[0] == pytest.approx(6.0, abs=0.1)
    assert copter.set_speed(0.0).outcome is Outcome.DENIED


def test_hold_brakes_and_stays(fleet: Fleet) -> None:
    copter = flying(fleet)
    copter.go_to((800.0, 200.0, 80.0))
    fleet.step(10.0)
    speed = copter.snapshot.velocity_enu_m_s[0]
    assert copter.hold().accepted
    east_at_order = copter.snapshot.position_enu_m[0]
    fleet.step(20.0)
    stopped = copter.snapshot
    assert max(abs(v) for v in stopped.velocity_enu_m_s) < 0.01
    assert 0.0 < stopped.position_enu_m[0] - east_at_order < speed**2 / (2 * 2.0) + 3.0


def test_return_climbs_flies_home_lands_and_disarms(fleet: Fleet) -> None:
    copter = flying(fleet)
    copter.set_parameter("RTL_ALT", 6000.0)
    copter.go_to((700.0, 300.0, 70.0))
    fleet.step(60.0)
    assert copter.return_home().accepted
    highest = 0.0
    while copter.armed:
        fleet.step(0.5)
        highest = max(highest, copter.snapshot.position_enu_m[2])
        assert fleet.time_s < 600.0
    final = copter.snapshot
    assert highest == pytest.approx(GROUND_M + 60.0, abs=0.6)
    assert final.position_enu_m == pytest.approx((200.0, 200.0, GROUND_M), abs=0.1)
    assert final.landed is LandedState.ON_GROUND
    assert not final.crashed


def test_return_does_not_come_down_from_above_its_altitude(fleet: Fleet) -> None:
    copter = flying(fleet)
    copter.go_to((260.0, 200.0, GROUND_M + 90.0))
    fleet.step(60.0)
    copter.return_home()
    fleet.step(8.0)
    assert copter.snapshot.position_enu_m[2] == pytest.approx(GROUND_M + 90.0, abs=0.5)


def test_close_to_home_return_climbs_less(fleet: Fleet) -> None:
    """RTL_CONE_SLOPE 3: ten metres away it climbs to thirty at most."""
    copter = flying(fleet, 10.0)
    copter.set_parameter("RTL_ALT", 10_000.0)
    copter.go_to((210.0, 200.0, GROUND_M + 10.0))
    fleet.step(20.0)
    copter.return_home()
    fleet.step(15.0)
    assert copter.snapshot.position_enu_m[2] == pytest.approx(GROUND_M + 30.0, abs=1.0)


def test_land_touches_down_softly_and_disarms(fleet: Fleet) -> None:
    copter = flying(fleet)
    copter.land()
    until(fleet, lambda c: not c.armed)
    assert copter.landed
    assert not copter.crashed
    assert copter.home_enu_m is not None


def test_a_flight_into_the_ground_is_a_crash(fleet: Fleet) -> None:
    copter = flying(fleet)
    copter.go_to((800.0, 200.0, GROUND_M - 40.0))
    until(fleet, lambda c: c.crashed)
    assert not copter.armed
    assert "Crash: Disarming" in texts(copter)
    assert copter.arm().outcome is Outcome.FAILED
    assert fleet.crashes == 1


def test_motors_off_in_flight_is_a_fall(fleet: Fleet) -> None:
    copter = flying(fleet)
    assert copter.disarm(force=True).accepted
    until(fleet, lambda c: c.crashed)
    assert copter.landed


def watched(fleet: Fleet, timeout_s: float = 5.0) -> Vehicle:
    copter = flying(fleet)
    copter.set_parameter("FS_GCS_ENABLE", 1)
    copter.set_parameter("FS_GCS_TIMEOUT", timeout_s)
    copter.heard_controller(CONTROLLER_ID)
    copter.drain_texts()
    return copter


def test_silence_of_the_controller_returns_the_vehicle(fleet: Fleet) -> None:
    copter = watched(fleet)
    fleet.step(4.9)
    assert copter.mode is CopterMode.GUIDED
    fleet.step(0.2)
    assert copter.mode is CopterMode.RTL
    assert texts(copter) == ["GCS Failsafe"]
    assert "GCS failsafe on" in copter.prearm_problems(CopterMode.GUIDED)
    until(fleet, lambda c: not c.armed)


def test_a_controller_that_comes_back_clears_the_failsafe_but_not_the_mode(fleet: Fleet) -> None:
    copter = watched(fleet)
    fleet.step(5.2)
    copter.drain_texts()
    copter.heard_controller(CONTROLLER_ID)
    fleet.step(0.1)
    assert texts(copter) == ["GCS Failsafe Cleared"]
    assert copter.mode is CopterMode.RTL
    assert copter.go_to((300.0, 300.0, 90.0)).accepted


def test_only_the_watched_controller_counts(fleet: Fleet) -> None:
    copter = watched(fleet)
    for _ in range(30):
        copter.heard_controller(CONTROLLER_ID + 1)
        fleet.step(0.2)
    assert copter.mode is CopterMode.RTL


def test_a_controller_never_heard_is_not_missed(fleet: Fleet) -> None:
    copter = flying(fleet)
    copter.set_parameter("FS_GCS_ENABLE", 1)
    fleet.step(30.0)
    assert copter.mode is CopterMode.GUIDED


def test_disabled_means_disabled(fleet: Fleet) -> None:
    copter = watched(fleet)
    copter.set_parameter("FS_GCS_ENABLE", 0)
    fleet.step(30.0)
    assert copter.mode is CopterMode.GUIDED


@pytest.mark.parametrize(("options", "mode"), [(16, CopterMode.LOITER), (0, CopterMode.RTL)])
def test_a_holding_vehicle_ignores_the_silence_unless_told_otherwise(
    fleet: Fleet, options: int, mode: CopterMode
) -> None:
    copter = watched(fleet)
    copter.set_parameter("FS_OPTIONS", options)
    copter.hold()
    fleet.step(6.0)
    assert copter.mode is mode


def test_silence_on_the_ground_disarms(fleet: Fleet) -> None:
    copter = fleet.vehicles[0]
    copter.set_parameter("SYSID_MYGCS", CONTROLLER_ID)
    copter.set_parameter("FS_GCS_ENABLE", 1)
    fleet.step(6.0)
    copter.heard_controller(CONTROLLER_ID)
    copter.arm()
    fleet.step(5.2)
    assert not copter.armed
    assert "GCS Failsafe - Disarming" in texts(copter)
    assert not copter.arm().accepted


def test_a_low_battery_returns_and_an_empty_one_falls() -> None:
    plan = sim_plan(simulation={"ready_after_s": 5.0, "endurance_s": 200.0})
    fleet = Fleet(plan, World.of(plan))
    copter = flying(fleet)
    until(fleet, lambda c: c.mode is CopterMode.RTL)
    assert 0.05 < copter.battery.remaining <= 0.1
    said = texts(copter)
    assert "Battery Failsafe" in said
    assert any(text.startswith("Battery 1 is low") for text in said)
    copter.set_parameter("BATT_FS_CRT_ACT", 0)
    copter.go_to((200.0, 200.0, 140.0))
    until(fleet, lambda c: c.crashed)
    assert copter.battery.remaining == 0.0


def test_a_velocity_target_runs_out(fleet: Fleet) -> None:
    copter = flying(fleet)
    assert copter.set_velocity((0.0, 4.0, 0.0)).accepted
    fleet.step(2.5)
    assert copter.snapshot.velocity_enu_m_s[1] == pytest.approx(4.0, abs=0.01)
    fleet.step(10.0)
    assert abs(copter.snapshot.velocity_enu_m_s[1]) < 0.01


def test_unknown_and_unflyable_modes_are_refused(fleet: Fleet) -> None:
    copter = flying(fleet)
    copter.drain_texts()
    assert copter.set_mode(99).outcome is Outcome.FAILED
    assert copter.set_mode(CopterMode.AUTO).outcome is Outcome.FAILED
    assert texts(copter) == ["No such mode 99", "Mode change to AUTO failed: init failed"]


@pytest.mark.parametrize("name", ["WPNAV_SPEED", "WPNAV_ACCEL", "WPNAV_SPEED_UP", "LAND_SPEED", "BATT_CAPACITY"])
@pytest.mark.parametrize("value", [-3e38, 0.0, 3e38])
def test_absurd_parameters_make_no_absurd_body(fleet: Fleet, name: str, value: float) -> None:
    copter = flying(fleet)
    copter.set_parameter(name, value)
    copter.go_to((600.0, 400.0, 200.0))
    fleet.step(20.0)
    copter.land()
    fleet.step(5.0)
    assert all(abs(v) <= 150.0 for v in copter.snapshot.velocity_enu_m_s)
