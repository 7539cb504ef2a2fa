"""Wind, gusts, position noise and faults: seeded, plausible, and met by the failsafes that they call for."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from sim_bridge.control import ControlPort, InjectError, inject
from sim_bridge.faults import FAULTS
from sim_bridge.fence import CircleZone, PolygonZone
from sim_bridge.fleet import Fleet
from sim_bridge.modes import LandedState
from sim_bridge.personalities.ardupilot_copter import CopterMode
from sim_bridge.vehicle import Vehicle
from tests.fakes.sim_teams import SEA_FLOOR_M, armed, member, sea_fleet, texts, until
from vehicle_agent.mission.model import FaultName


def copter_fleet(count: int = 1, **simulation: float | list[float] | list[dict[str, object]]) -> Fleet:
    return sea_fleet(*(member(f"copter-{number}") for number in range(count)), **simulation)


def flying(fleet: Fleet) -> Vehicle:
    copter = armed(fleet)
    assert copter.take_off(20.0).accepted
    until(fleet, lambda c: c.landed_state is LandedState.IN_AIR)
    fleet.step(5.0)
    copter.drain_texts()
    return copter


def test_steady_wind_tilts_a_hovering_copter_and_does_not_move_it() -> None:
    fleet = copter_fleet(wind_m_s=[8.0, 0.0])
    copter = flying(fleet)
    before = np.array(copter.true_position_enu_m)
    fleet.step(20.0)
    np.testing.assert_allclose(copter.true_position_enu_m, before, atol=0.1)
    roll, pitch = copter.attitude_rad
    assert copter.heading_deg == 0.0
    assert roll < -0.05
    assert abs(pitch) < 0.01


def test_gusts_shake_it_a_little_and_each_vehicle_has_its_own() -> None:
    few, many = copter_fleet(1, gust_m_s=3.0), copter_fleet(2, gust_m_s=3.0)
    tracks = []
    for fleet in (few, many):
        copter = flying(fleet)
        positions = []
        for _ in range(200):
            fleet.step(0.2)
            positions.append(copter.true_position_enu_m)
        tracks.append(np.array(positions))
    np.testing.assert_array_equal(tracks[0], tracks[1])
    spread_m = tracks[0].std(axis=0)
    assert 0.02 < spread_m[0] < 2.0


def test_position_noise_has_the_size_that_was_asked_for() -> None:
    fleet = copter_fleet(8, gps_noise_m=2.0)
    errors = []
    for _ in range(60):
        fleet.step(10.0)
        errors.append(fleet.bodies.error_m.copy())
    spread_m = np.array(errors).std(axis=(0, 1))
    np.testing.assert_allclose(spread_m, [2.0, 2.0, 1.0], rtol=0.2)
    assert fleet.vehicles[0].snapshot.position_enu_m != fleet.vehicles[0].true_position_enu_m


def test_a_climb_and_a_fast_leg_cost_more_than_hovering() -> None:
    def used(target: tuple[float, float, float] | None) -> float:
        fleet = copter_fleet(endurance_s=1000.0)
        copter = flying(fleet)
        copter.set_parameter("WPNAV_SPEED", 2000.0)
        copter.set_parameter("WPNAV_SPEED_UP", 500.0)
        if target is not None:
            copter.go_to(target)
            fleet.step(8.0)
        before = copter.battery.remaining
        fleet.step(8.0)
        return before - copter.battery.remaining

    hovering = used(None)
    assert hovering == pytest.approx(8.0 / 1000.0, rel=0.02)
    assert used((200.0, 200.0, 150.0)) > 1.2 * hovering
    assert used((900.0, 200.0, SEA_FLOOR_M + 20.0)) > 1.03 * hovering


def test_loss_of_satellites_lands_a_copter_that_needs_them() -> None:
    fleet = copter_fleet(faults=[{"at_s": 60.0, "vehicle": "copter-0", "fault": "gps-loss", "for_s": 30.0}])
    copter = flying(fleet)
    until(fleet, lambda c: c.mode is CopterMode.LAND, 60.0)
    assert 64.9 < fleet.time_s < 66.0
    assert texts(copter) == ["EKF variance", "EKF Failsafe: changed to LAND Mode"]
    assert not copter.set_mode(CopterMode.GUIDED).accepted
    assert float(np.abs(fleet.bodies.error_m[0, :2]).max()) > 0.0
    until(fleet, lambda c: c.has_fix, 60.0)
    fleet.step(0.5)
    assert copter.set_mode(CopterMode.GUIDED).accepted


def test_a_vehicle_that_stands_still_does_not_lose_its_way_further() -> None:
    fleet = copter_fleet(faults=[{"at_s": 10.0, "vehicle": "copter-0", "fault": "gps-loss"}])
    until(fleet, lambda c: c.fix_lost)
    fleet.step(300.0)
    assert np.abs(fleet.bodies.error_m[0]).max() < 0.5
    flown = copter_fleet(faults=[{"at_s": 60.0, "vehicle": "copter-0", "fault": "gps-loss"}])
    copter = flying(flown)
    until(flown, lambda c: not c.armed)
    flown.step(1.0)
    landed_m = flown.bodies.error_m[0].copy()
    assert np.abs(landed_m).max() > 0.5
    flown.step(300.0)
    np.testing.assert_array_equal(flown.bodies.error_m[0], landed_m)
    assert not copter.has_fix


STRIKES: dict[FaultName, Callable[[Vehicle], bool]] = {
    "gps-loss": lambda v: v.fix_lost,
    "battery": lambda v: v.battery.remaining < 0.1,
    "motor": lambda v: v.pilot.broken,
    "link-loss": lambda v: v.link_lost,
    "leak": lambda v: v.leaking,
}


@pytest.mark.parametrize("fault", FAULTS)
def test_every_fault_strikes_at_its_time_and_ends_at_its_time(fault: FaultName) -> None:
    """Whatever `inject` can do stands in a mission file too."""
    fleet = copter_fleet(2, faults=[{"at_s": 20.0, "vehicle": "copter-1", "fault": fault, "for_s": 15.0}])
    struck, spared = fleet.vehicles[1], fleet.vehicles[0]
    fleet.step(19.9)
    assert not STRIKES[fault](struck)
    fleet.step(0.2)
    assert STRIKES[fault](struck)
    fleet.step(14.0)
    assert STRIKES[fault](struck)
    fleet.step(2.0)
    assert STRIKES[fault](struck) == (fault == "battery")
    assert not STRIKES[fault](spared)


def test_a_failed_motor_brings_it_down() -> None:
    fleet = copter_fleet()
    copter = flying(fleet)
    fleet.faults.set(0, "motor", True)
    copter.go_to((300.0, 300.0, 0.0))
    until(fleet, lambda c: c.crashed, 30.0)
    assert "Potential Thrust Loss (1)" in texts(copter)


def test_a_failed_battery_lands_it() -> None:
    fleet = copter_fleet()
    copter = flying(fleet)
    fleet.faults.set(0, "battery", True)
    fleet.step(0.5)
    assert copter.mode is CopterMode.LAND
    assert any(text.startswith("Battery 1 is critical") for text in texts(copter))


CORNERS = np.array([[150.0, 150.0], [260.0, 150.0], [260.0, 260.0], [150.0, 260.0]])


@pytest.mark.parametrize(
    ("zone", "kinds", "part"),
    [
        (PolygonZone(True, CORNERS), 4, "Polygon"),
        (CircleZone(True, 200.0, 200.0, 60.0), 4, "Polygon"),
        (CircleZone(False, 290.0, 200.0, 30.0), 4, "Polygon"),
        (None, 2, "Circle"),
        (None, 1, "Max Alt"),
    ],
)
def test_leaving_the_fence_returns_it(zone: PolygonZone | CircleZone | None, kinds: int, part: str) -> None:
    fleet = copter_fleet()
    copter = flying(fleet)
    copter.flight_plan.fence_zones = () if zone is None else (zone,)
    for name, value in (("FENCE_TYPE", kinds), ("FENCE_RADIUS", 60), ("FENCE_ALT_MAX", 40), ("FENCE_ENABLE", 1)):
        assert copter.set_parameter(name, value).accepted
    fleet.step(1.0)
    assert copter.mode is CopterMode.GUIDED
    copter.go_to((320.0, 200.0, 30.0))
    until(fleet, lambda c: c.mode is CopterMode.RTL, 60.0)
    assert f"{part} fence breached" in texts(copter)
    until(fleet, lambda c: not c.armed, 200.0)
    assert f"{part} fence cleared" in texts(copter)
    assert not copter.crashed


def test_a_fence_that_only_reports_lets_it_go_on_and_one_that_is_breached_keeps_it_down() -> None:
    fleet = copter_fleet()
    copter = flying(fleet)
    for name, value in (("FENCE_TYPE", 2), ("FENCE_RADIUS", 30), ("FENCE_ACTION", 0), ("FENCE_ENABLE", 1)):
        assert copter.set_parameter(name, value).accepted
    copter.go_to((320.0, 200.0, 30.0))
    fleet.step(30.0)
    assert copter.mode is CopterMode.GUIDED
    assert copter.prearm_problems(CopterMode.GUIDED) == ["Vehicle breaching Fence"]


@pytest.mark.parametrize(
    ("line", "answer"),
    [
        ("copter-0 link-loss on\n", "ok"),
        ("copter-0 link-loss", "say VEHICLE FAULT on"),
        ("nobody leak on", "there is no vehicle 'nobody'"),
        ("copter-0 hail on", "there is no fault 'hail'"),
        ("", "say VEHICLE FAULT on"),
    ],
)
def test_the_control_port_obeys_or_explains(line: str, answer: str) -> None:
    fleet = copter_fleet()
    assert ControlPort(fleet).obey(line).startswith(answer)
    assert fleet.vehicles[0].link_lost is (answer == "ok")


@pytest.mark.parametrize("endpoint", ["nowhere", "127.0.0.1:1", "127.0.0.1:99999999"])
def test_an_order_that_reaches_nobody_says_so(endpoint: str) -> None:
    with pytest.raises(InjectError, match="endpoint"):
        inject(endpoint, "copter-0", "leak", True)
