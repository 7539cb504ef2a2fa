"""The simulator's ground truth: terrain files and their errors, heights, scans and what can be seen at all."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sim_bridge.reach import reachable_cells
from sim_bridge.world import World
from tests.fakes.sim_missions import GROUND_M, sim_plan
from vehicle_agent.domain.grid import Grid
from vehicle_agent.mission.load import MissionError

GRID_TERRAIN = {"kind": "grid", "file": "terrain.npz"}
HILLS = {"kind": "gaussians", "peaks": 5, "height_m": [20.0, 80.0], "sigma_m": 150.0}


def save_terrain(folder: Path, **changes: Any) -> Path:
    """A plane that rises 1 m per 10 m east and 1 m per 20 m north, amsl, on cells of 50 m around the area."""
    east = -100.0 + 50.0 * (np.arange(24) + 0.5)
    content = {
        "elevation_amsl_m": 300.0 + east[:, None] / 10.0 + east[None, :] / 20.0,
        "west_m": -100.0,
        "south_m": -100.0,
        "cell_m": 50.0,
    } | changes
    path = folder / "terrain.npz"
    np.savez(path, **{name: value for name, value in content.items() if value is not None})
    return path


def test_measured_terrain_is_resampled_to_enu(tmp_path: Path) -> None:
    save_terrain(tmp_path)
    world = World.of(sim_plan(tmp_path / "mission.toml", terrain=GRID_TERRAIN))
    east, north = np.meshgrid(world.grid.centres_east_m(), world.grid.centres_north_m(), indexing="ij")
    np.testing.assert_allclose(world.elevation_m, east / 10.0 + north / 20.0, atol=1e-9)
    assert world.ground_m(333.0, 71.0) == pytest.approx(33.3 + 3.55)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"cell_m": None}, "has no cell_m"),
        ({"elevation_amsl_m": np.full((24, 24), np.nan)}, "no finite value"),
        ({"elevation_amsl_m": np.zeros((5, 5))}, "larger terrain"),
        ({"elevation_amsl_m": np.zeros(7)}, "two dimensions"),
        ({"elevation_amsl_m": np.array([["x"]])}, "no terrain"),
        ({"cell_m": -1.0}, "cell_m"),
        ({"west_m": np.nan}, "finite"),
        ({"west_m": np.zeros(3)}, "no terrain"),
    ],
)
def test_unusable_terrain_is_one_sentence_with_the_file(tmp_path: Path, changes: dict[str, Any], words: str) -> None:
    path = save_terrain(tmp_path, **changes)
    with pytest.raises(MissionError, match=words) as caught:
        World.of(sim_plan(tmp_path / "mission.toml", terrain=GRID_TERRAIN))
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"not an archive", b"PK\x03\x04 torn"])
def test_a_file_that_is_no_archive_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "terrain.npz").write_bytes(content)
    with pytest.raises(MissionError, match=r"terrain\.npz"):
        World.of(sim_plan(tmp_path / "mission.toml", terrain=GRID_TERRAIN))


def test_pickled_terrain_is_refused(tmp_path: Path) -> None:
    save_terrain(tmp_path, elevation_amsl_m=np.array([[{"a": 1}]], dtype=object))
    with pytest.raises(MissionError, match="cannot be read"):
        World.of(sim_plan(tmp_path / "mission.toml", terrain=GRID_TERRAIN))


def test_a_missing_terrain_names_the_key(tmp_path: Path) -> None:
    with pytest.raises(MissionError, match=r"terrain\.file"):
        World.of(sim_plan(tmp_path / "mission.toml", terrain=GRID_TERRAIN))


def test_a_start_below_ground_names_vehicle_and_ground() -> None:
    vehicle = {
        "name": "mole",
        "start_enu_m": [200.0, 200.0, GROUND_M - 1.0],
        "speed_m_s": 5.0,
        "sensor": {"kind": "range", "range_m": 100.0},
        "min_above_terrain_m": 10.0,
        "max_above_terrain_m": 50.0,
    }
    with pytest.raises(MissionError, match=r"vehicles\[0\]\.start_enu_m.*50\.0 m"):
        World.of(sim_plan(team=[vehicle]))


def test_hills_follow_the_seed() -> None:
    worlds = [World.of(sim_plan(terrain=HILLS, seed=seed)).elevation_m for seed in (3, 3, 4)]
    np.testing.assert_array_equal(worlds[0], worlds[1])
    assert not np.array_equal(worlds[0], worlds[2])
    assert worlds[0].min() >= 0.0
    assert worlds[0].max() > 20.0


def test_heights_between_centres_are_bilinear_and_level_beyond_the_border() -> None:
    world = World(Grid(0.0, 0.0, 10.0, 2, 2), np.array([[0.0, 10.0], [20.0, 30.0]]))
    assert world.ground_m(10.0, 10.0) == pytest.approx(15.0)
    assert world.ground_m(5.0, 12.5) == pytest.approx(7.5)
    assert world.ground_m(-100.0, -100.0) == pytest.approx(0.0)
    assert world.ground_m(1e6, 1e6) == pytest.approx(30.0)


def test_a_grid_of_one_cell_has_ground() -> None:
    assert World(Grid(0.0, 0.0, 10.0, 1, 1), np.array([[4.0]])).ground_m(3.0, 99.0) == 4.0


def test_a_scan_sees_what_is_in_range_and_not_behind_a_wall() -> None:
    elevation = np.zeros((21, 1))
    elevation[12] = 100.0
    world = World(Grid(0.0, 0.0, 10.0, 21, 1), elevation)
    scan = world.scan((105.0, 5.0, 20.0), 80.0, stamp_ms=77)
    np.testing.assert_array_equal(scan.cell_indices, np.arange(3, 12 + 0))
    assert set(scan.stamps_ms.tolist()) == {77}
    assert world.scan((105.0, 5.0, 20.0), 1.0, 77).cell_indices.size == 0


def test_cells_along_the_fence_are_reachable_only_when_seen_from_inside() -> None:
    """A wide fence margin: the outer cells cannot be overflown, and a deep pit there stays out of sight."""
    plan = sim_plan(area={"cell_m": 20.0, "rectangle_enu_m": [0.0, 0.0, 1000.0, 1000.0], "fence_margin_m": 60.0})
    elevation = np.full(plan.grid.shape, GROUND_M)
    elevation[0, 25] = GROUND_M - 500.0
    reachable = reachable_cells(plan, World(plan.grid, elevation))
    assert not reachable[0, 25]
    assert np.count_nonzero(~reachable) == 1
