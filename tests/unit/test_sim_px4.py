"""The simulated PX4: packed modes, take-off by parameter, offboard flight that needs a stream of targets."""

from __future__ import annotations

import math

import pytest

from sim_bridge.fleet import Fleet
from sim_bridge.flight_plan import PlanItem
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


def test_it_speaks_in_its_own_words() -> None:
    fleet = px4_fleet()
    vehicle = fleet.vehicles[0]
    fleet.step(1.0)
    assert not vehicle.arm_motors().accepted
    assert all(text.startswith("Arming denied: ") for text in texts(vehicle))
    vehicle = flying(fleet)
    vehicle.set_parameter("NAV_DLL_ACT", 2)
    vehicle.heard_controller(42)
    until(fleet, lambda v: v.mode is Px4Mode.AUTO_RTL)
    vehicle.heard_controller(42)
    until(fleet, lambda v: not v.failsafe_active)
    fleet.faults.set(0, "battery", True)
    until(fleet, lambda v: not v.armed)
    said = texts(vehicle)
    assert {"Armed by external command", "Failsafe activated", "GCS connection regained"} <= set(said)
    assert "Critical battery level, land now" in said
    assert not [text for text in said if "EKF" in text or "Failsafe -" in text or text.endswith(" Failsafe")]


def test_it_flies_a_mission_to_its_end() -> None:
    fleet = px4_fleet()
    vehicle = fleet.vehicles[0]
    until(fleet, lambda v: v.ready_to_arm)

    def item(command: int, north_m: float = 0.0, up_m: float = 0.0) -> PlanItem:
        place = fleet.plan.datum.to_geodetic((200.0, 200.0 + north_m, 0.0))
        x, y = round(place.latitude_deg * 1e7), round(place.longitude_deg * 1e7)
        return PlanItem(command, 3, (0.0, 0.0, 0.0, 0.0), x, y, up_m)

    vehicle.flight_plan.mission = (item(16), item(22, 0.0, 15.0), item(16, 60.0, 25.0), item(21, 60.0))
    vehicle.auto_flight.mission_replaced()
    assert vehicle.arm_motors().accepted
    assert vehicle.start_mission().accepted
    assert vehicle.mode is Px4Mode.AUTO_MISSION
    until(fleet, lambda v: v.pilot.position_enu_m[2] > SEA_FLOOR_M + 24.0)
    until(fleet, lambda v: not v.armed)
    assert vehicle.pilot.position_enu_m == pytest.approx((200.0, 260.0, SEA_FLOOR_M), abs=1.0)
    assert not vehicle.crashed
