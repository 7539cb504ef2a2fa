"""Mapping missions in lock-step: two underwater vehicles, modems of 200 bytes per ten seconds, a depth map."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import msgspec
import numpy as np
import pytest

from missions.depth_map import FILES
from missions.lockstep import LockstepResult, simulate
from tests.fakes.map_missions import FLOOR_M, map_mission, map_plan
from vehicle_agent.domain.landmark_atlas import LandmarkAtlas
from vehicle_agent.mission.load import plan_mission
from vehicle_agent.mission.model import RadioTable, StopTable
from vehicle_agent.mission.tasks import MapTask
from vehicle_agent.mission.terrain import FlatTerrain

KEY_BYTES = 40
"""A message's key on Zenoh, which an agent's count of bytes holds too."""


@cache
def flown() -> LockstepResult:
    return simulate(map_plan())


def test_both_dive_map_surface_for_fixes_return_and_disarm() -> None:
    result = flown()
    codes = {(vehicle, code) for _, vehicle, code, _ in result.events}
    for name in ("alba", "brisa"):
        assert (name, "dived") in codes
    assert all(result.finished)
    assert not any(result.crashed)
    water_m = result.plan.mission.simulation.water_level_m
    depths = water_m - result.positions_enu_m[:, :, 2]
    for index, vehicle in enumerate(result.plan.mission.vehicles):
        assert vehicle.depth_m is not None
        assert np.median(depths[:, index]) == pytest.approx(vehicle.depth_m, abs=0.3)
        first, last = np.flatnonzero(depths[:, index] > 0.8 * vehicle.depth_m)[[0, -1]]
        assert depths[first:last, index].min() < 0.5, "it came up for a fix between its first dive and its return"


def test_the_map_is_good_and_says_how_good() -> None:
    result = flown()
    drawn = result.depth_map
    assert drawn is not None
    assert drawn.rms_error_m is not None
    relief_m = float(np.ptp(result.true_elevation_m))
    assert drawn.rms_error_m < 0.2 * relief_m
    error = np.abs(drawn.elevation_m - result.true_elevation_m)[result.plan.area_cells]
    assert np.mean(error < 3.0 * drawn.sd_m[result.plan.area_cells] + 0.3) > 0.9


def test_nobody_says_more_than_its_modem_carries() -> None:
    result = flown()
    packets = result.elapsed_s / result.plan.mission.radio.packet_period_s + 1
    for sent in result.bytes_sent:
        assert sent <= packets * (result.plan.mission.radio.packet_bytes + 3 * KEY_BYTES)  # type: ignore[operator]


def test_each_learns_from_the_other_in_spite_of_loss() -> None:
    """Both maps hold soundings of both: what one vehicle knows alone is little more than half."""
    result = flown()
    atlas = result.team_map
    assert isinstance(atlas, LandmarkAtlas)
    shares = [atlas.first_observer_share(index) for index in range(2)]
    assert min(shares) > 0.2 * sum(shares)


def test_the_same_seed_gives_the_same_run() -> None:
    mission = map_mission(stop=msgspec.structs.replace(map_mission().stop, time_limit_s=60.0))
    first, second = (simulate(plan_mission(mission, Path("pond.toml"))) for _ in range(2))
    assert first.events == second.events
    assert np.array_equal(first.positions_enu_m, second.positions_enu_m)


def test_files_left_behind(tmp_path: Path) -> None:
    result = flown()
    result.save(tmp_path)
    for name in FILES:
        assert (tmp_path / name).stat().st_size > 0
    lines = (tmp_path / "depth_map.csv").read_text().splitlines()
    assert lines[0] == "latitude_deg,longitude_deg,elevation_amsl_m,sd_m"
    assert len(lines) == 1 + int(result.plan.area_cells.sum())
    latitude, longitude, elevation_m, sd_m = map(float, lines[1].split(","))
    assert abs(latitude - 41.0) < 0.01
    assert abs(longitude + 8.0) < 0.01
    assert -15.0 < elevation_m < 0.0
    assert sd_m > 0.0
    esri = (tmp_path / "depth_map.asc").read_text().splitlines()
    assert esri[0] == "ncols 16"
    assert len(esri) == 6 + 16


def test_viewpoints_and_a_radio_that_is_no_modem() -> None:
    """The other planner flies too, and without a packet size the radio carries more."""
    mission = map_mission(
        task=MapTask(planner="viewpoints", step_m=20.0, accurate_sd_m=0.3),
        radio=RadioTable(),
        stop=msgspec.structs.replace(map_mission().stop, time_limit_s=90.0),
    )
    result = simulate(plan_mission(mission, Path("pond.toml")))
    assert all(result.finished)
    assert result.observed_fraction > 0.1


def test_a_vehicle_rises_from_ground_that_reaches_into_its_depth() -> None:
    """Flat ground 0.6 m below the depth ordered, nearer than the metre that vehicles keep."""
    mission = map_mission(
        terrain=FlatTerrain(elevation_amsl_m=2.0 * FLOOR_M + 7.9),
        stop=msgspec.structs.replace(map_mission().stop, time_limit_s=60.0),
    )
    result = simulate(plan_mission(mission, Path("pond.toml")))
    assert all(result.finished)
    assert not any(result.crashed)
    above_m = result.positions_enu_m[30:90, 1, 2] - result.true_elevation_m.max()
    assert np.median(above_m) >= 1.0


def test_who_may_not_come_up_is_kept_right_by_ranges_to_a_teammate() -> None:
    """Ten minutes of reckoning take a vehicle tens of metres astray; its teammate comes up for fixes."""
    stop = StopTable(time_limit_s=600.0)
    errors_m = []
    for ranging in (True, False):
        task = MapTask(step_m=20.0, accurate_sd_m=0.2, stays_down=("brisa",), ranging=ranging)
        results = [simulate(map_plan(task=task, stop=stop, seed=seed)) for seed in (1, 3)]
        assert all(all(result.finished) for result in results)
        maps = [result.depth_map for result in results]
        errors_m.append(np.mean([drawn.rms_error_m for drawn in maps if drawn and drawn.rms_error_m is not None]))
    assert errors_m[0] < 0.8 * errors_m[1]
