"""A simulated underwater vehicle: dives, keeps its depth, loses its way, surfaces when something is wrong."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sim_bridge.fleet import Fleet
from sim_bridge.modes import Behaviour
from sim_bridge.personalities.ardupilot_sub import SubMode
from sim_bridge.reply import Outcome
from sim_bridge.vehicle import Vehicle
from sim_bridge.world import World
from tests.fakes.sim_missions import sim_plan
from tests.fakes.sim_teams import SEA_FLOOR_M, armed, member, submarine_fleet, texts, until


def error_m(vehicle: Vehicle) -> float:
    believed, true = np.array(vehicle.pilot.position_enu_m), np.array(vehicle.true_position_enu_m)
    return float(np.linalg.norm((believed - true)[:2]))


def test_it_starts_as_a_submarine_does() -> None:
    fleet = submarine_fleet()
    submarine = fleet.vehicles[0]
    assert submarine.mode is SubMode.MANUAL
    assert submarine.set_mode(SubMode.GUIDED).outcome is Outcome.FAILED
    assert "Mode change failed: GUIDED requires position" in texts(submarine)
    assert submarine.start_takeoff(-5.0).outcome is Outcome.UNSUPPORTED
    assert submarine.return_home().outcome is Outcome.UNSUPPORTED
    assert submarine.arm_motors().accepted
    assert submarine.disarm().accepted


def test_it_dives_to_its_target_and_keeps_its_depth_drifting() -> None:
    fleet = submarine_fleet(current_m_s=[0.2, 0.0])
    submarine = armed(fleet)
    assert submarine.home_enu_m is not None
    assert submarine.home_enu_m[2] == 0.0
    assert submarine.go_to((230.0, 210.0, -12.0)).accepted
    fleet.step(80.0)
    assert submarine.pilot.position_enu_m == pytest.approx((230.0, 210.0, -12.0), abs=0.3)
    assert submarine.enter(Behaviour.DEPTH_HOLD).accepted
    east_m = submarine.true_position_enu_m[0]
    fleet.step(60.0)
    assert submarine.true_position_enu_m[2] == pytest.approx(-12.0, abs=0.2)
    assert submarine.true_position_enu_m[0] - east_m == pytest.approx(12.0, abs=1.5)


def sloping_fleet(folder: Path, sensor: dict[str, Any]) -> Fleet:
    """An underwater vehicle over a floor 40 m deep that rises by 0.2 to the east, whither a current of 0.3 m/s sets."""
    east_m = 25.0 + 50.0 * np.arange(20)
    floor_m = np.broadcast_to((-40.0 + 0.2 * (east_m - 200.0))[:, None], (20, 20))
    np.savez(folder / "slope.npz", elevation_amsl_m=floor_m, west_m=0.0, south_m=0.0, cell_m=50.0)
    plan = sim_plan(
        folder / "mission.toml",
        team=[member("seal", type="underwater-vehicle", start_enu_m=[200.0, 200.0], sensor=sensor)],
        datum={"latitude_deg": 41.18, "longitude_deg": -8.7},
        area={"cell_m": 25.0, "rectangle_enu_m": [50.0, 50.0, 350.0, 350.0]},
        terrain={"kind": "grid", "file": "slope.npz"},
        simulation={"ready_after_s": 5.0, "current_m_s": [0.3, 0.0]},
    )
    return Fleet(plan, World.of(plan))


def test_it_follows_the_bottom_that_its_beam_measures(tmp_path: Path) -> None:
    fleet = sloping_fleet(tmp_path, {"kind": "single-beam", "range_m": 35.0})
    submarine = armed(fleet)
    assert submarine.set_mode(SubMode.SURFTRAK).accepted
    fleet.step(1.0)
    assert "waiting for a rangefinder reading" in texts(submarine)
    submarine.go_to((200.0, 200.0, -20.0))
    until(fleet, lambda v: v.true_position_enu_m[2] < -19.9)
    assert submarine.set_mode(SubMode.SURFTRAK).accepted
    fleet.step(2.0)
    (told,) = [text for text in texts(submarine) if text.startswith("rangefinder target is")]
    kept_m = float(told.split()[3])
    before_m = submarine.true_position_enu_m
    fleet.step(80.0)
    after_m = submarine.true_position_enu_m
    assert after_m[0] - before_m[0] == pytest.approx(24.0, abs=2.0)
    assert after_m[2] - before_m[2] == pytest.approx(0.2 * (after_m[0] - before_m[0]), abs=0.3)
    assert submarine.range_down_m() == pytest.approx(kept_m, abs=0.2)


def test_without_a_rangefinder_it_keeps_its_depth_instead(tmp_path: Path) -> None:
    fleet = sloping_fleet(tmp_path, {"kind": "range", "range_m": 200.0})
    submarine = armed(fleet)
    submarine.go_to((200.0, 200.0, -20.0))
    until(fleet, lambda v: v.true_position_enu_m[2] < -19.9)
    assert submarine.set_mode(SubMode.SURFTRAK).accepted
    fleet.step(60.0)
    assert submarine.true_position_enu_m[2] == pytest.approx(-20.0, abs=0.3)
    assert texts(submarine).count("waiting for a rangefinder reading") == 1


def test_it_tracks_no_bottom_near_the_surface(tmp_path: Path) -> None:
    fleet = sloping_fleet(tmp_path, {"kind": "single-beam", "range_m": 60.0})
    submarine = armed(fleet)
    assert submarine.set_mode(SubMode.SURFTRAK).accepted
    fleet.step(20.0)
    assert "descend below 0.5 meters to hold range" in texts(submarine)
    assert submarine.true_position_enu_m[2] == pytest.approx(0.0, abs=0.1)


def test_without_thrust_it_neither_sinks_nor_rises() -> None:
    fleet = submarine_fleet()
    submarine = armed(fleet)
    submarine.go_to((200.0, 200.0, -10.0))
    fleet.step(60.0)
    assert submarine.disarm().accepted
    fleet.step(60.0)
    assert submarine.true_position_enu_m[2] == pytest.approx(-10.0, abs=0.1)
    assert not submarine.crashed


def test_it_stays_in_the_water() -> None:
    fleet = submarine_fleet()
    submarine = armed(fleet)
    submarine.set_velocity((0.0, 0.0, 1.0))
    fleet.step(2.0)
    assert submarine.true_position_enu_m[2] <= 0.0
    submarine.go_to((200.0, 200.0, 30.0))
    fleet.step(10.0)
    assert submarine.true_position_enu_m[2] == pytest.approx(0.0, abs=1e-6)
    submarine.go_to((200.0, 200.0, SEA_FLOOR_M - 10.0))
    fleet.step(140.0)
    assert submarine.true_position_enu_m[2] == pytest.approx(SEA_FLOOR_M, abs=1e-6)
    assert not submarine.crashed


def test_its_position_error_grows_with_the_time_under_water_until_it_surfaces() -> None:
    grown = []
    for seed_like in range(6):
        fleet = submarine_fleet(endurance_s=10_000.0 + seed_like)
        submarine = armed(fleet)
        fleet.navigation._streams[0] = np.random.default_rng(seed_like)  # type: ignore[attr-defined]
        submarine.go_to((200.0, 200.0, -10.0))
        fleet.step(60.0)
        early = error_m(submarine)
        fleet.step(600.0)
        grown.append((early, error_m(submarine)))
        assert not submarine.has_fix
        assert submarine.enter(Behaviour.SURFACE).accepted
        fleet.step(60.0)
        assert submarine.has_fix
        assert error_m(submarine) == 0.0
    early_m, late_m = (math.sqrt(sum(pair[i] ** 2 for pair in grown) / len(grown)) for i in (0, 1))
    assert late_m > 4.0 * early_m > 0.0


def test_the_same_seed_drifts_the_same_way() -> None:
    ends = []
    for _ in range(2):
        fleet = submarine_fleet(gps_noise_m=0.5)
        submarine = armed(fleet)
        submarine.go_to((250.0, 250.0, -10.0))
        fleet.step(120.0)
        ends.append((submarine.true_position_enu_m, submarine.pilot.position_enu_m))
    assert ends[0] == ends[1]


def test_a_leak_brings_it_up() -> None:
    fleet = submarine_fleet(faults=[{"at_s": 60.0, "vehicle": "seal", "fault": "leak"}])
    submarine = armed(fleet)
    submarine.set_parameter("FS_LEAK_ENABLE", 2)
    submarine.go_to((200.0, 200.0, -15.0))
    fleet.step(50.0)
    assert submarine.mode is SubMode.GUIDED
    fleet.step(10.0)
    assert submarine.mode is SubMode.SURFACE
    assert "Leak Detected" in texts(submarine)
    until(fleet, lambda s: s.true_position_enu_m[2] == 0.0, 60.0)
    submarine.disarm()
    assert "Leak detected" in submarine.prearm_problems(SubMode.MANUAL)


def test_below_its_lowest_fence_it_surfaces() -> None:
    fleet = submarine_fleet()
    submarine = armed(fleet)
    for name, value in (("FENCE_TYPE", 8), ("FENCE_ALT_MIN", -10.0), ("FENCE_ENABLE", 1)):
        assert submarine.set_parameter(name, value).accepted
    submarine.go_to((200.0, 200.0, -20.0))
    until(fleet, lambda s: s.mode is SubMode.SURFACE, 60.0)
    assert "Min Alt fence breached" in texts(submarine)
    assert submarine.true_position_enu_m[2] > -10.6
