"""The simulated PX4: packed modes, take-off by parameter, offboard flight that needs a stream of targets."""

from __future__ import annotations

import math

import pytest

from sim_bridge.fleet import Fleet
from sim_bridge.modes import Behaviour, LandedState
from sim_bridge.personalities.px4 import Px4Mode
from sim_bridge.reply import Outcome
from sim_bridge.vehicle import Vehicle
from tests.fakes.sim_teams import SEA_FLOOR_M, px4_fleet, texts, until


def flying(fleet: Fleet, height_m: float = 20.0) -> Vehicle:
    vehicle = fleet.vehicles[0]
    until(fleet, lambda v: v.ready_to_arm)
    assert vehicle.set_parameter("MIS_TAKEOFF_ALT", height_m).accepted
    assert vehicle.arm_motors().accepted
    assert vehicle.start_takeoff(math.nan).accepted
    assert vehicle.mode is Px4Mode.AUTO_TAKEOFF
    until(fleet, lambda v: v.landed_state is LandedState.IN_AIR)
    return vehicle


def test_modes_are_packed_as_in_px4() -> None:
    assert [int(Px4Mode.AUTO_LOITER), int(Px4Mode.AUTO_RTL), int(Px4Mode.OFFBOARD)] == [0x03040000, 0x05040000, 0x60000]


def test_it_takes_off_to_the_height_of_its_parameter_and_holds() -> None:
    fleet = px4_fleet()
    vehicle = flying(fleet)
    assert vehicle.mode is Px4Mode.AUTO_LOITER
    assert vehicle.pilot.position_enu_m[2] == pytest.approx(SEA_FLOOR_M + 20.0, abs=1.0)


def test_it_disarms_some_time_after_landing() -> None:
    fleet = px4_fleet()
    vehicle = flying(fleet)
    vehicle.set_parameter("COM_DISARM_LAND", 3.0)
    assert vehicle.land().accepted
    until(fleet, lambda v: v.landed)
    assert vehicle.armed
    fleet.step(2.5)
    assert vehicle.armed
    fleet.step(1.0)
    assert not vehicle.armed


def test_offboard_needs_targets_before_and_all_the_time() -> None:
    fleet = px4_fleet()
    vehicle = flying(fleet)
    assert vehicle.enter(Behaviour.GUIDED).outcome is Outcome.FAILED
    assert "Switching to mode 'Offboard' is currently not possible" in texts(vehicle)
    vehicle.note_target()
    assert vehicle.enter(Behaviour.GUIDED).accepted
    vehicle.set_parameter("COM_OBL_RC_ACT", 3)
    for _ in range(20):
        assert vehicle.set_velocity((2.0, 0.0, 0.0)).accepted
        fleet.step(0.25)
    assert vehicle.mode is Px4Mode.OFFBOARD
    assert vehicle.pilot.velocity_enu_m_s[0] == pytest.approx(2.0, abs=0.05)
    fleet.step(1.2)
    assert vehicle.mode is Px4Mode.AUTO_RTL


def test_a_reposition_is_flown_in_hold() -> None:
    fleet = px4_fleet()
    vehicle = flying(fleet)
    assert vehicle.go_to((260.0, 230.0, SEA_FLOOR_M + 30.0)).accepted
    assert vehicle.mode is Px4Mode.AUTO_LOITER
    fleet.step(30.0)
    assert vehicle.pilot.position_enu_m == pytest.approx((260.0, 230.0, SEA_FLOOR_M + 30.0), abs=0.2)


def test_loss_of_the_ground_station_returns_it_when_set() -> None:
    fleet = px4_fleet()
    vehicle = flying(fleet)
    vehicle.set_parameter("NAV_DLL_ACT", 2)
    vehicle.heard_controller(42)
    fleet.step(9.0)
    assert vehicle.mode is Px4Mode.AUTO_LOITER
    fleet.step(2.0)
    assert vehicle.mode is Px4Mode.AUTO_RTL
