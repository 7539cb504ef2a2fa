"""The ridge mission's terrain, and the program that resampled it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from missions.terrain.resample import MARGIN_M, Raster, RasterError, main, resample
from vehicle_agent.domain.frames import Datum, Geodetic
from vehicle_agent.domain.grid import Grid
from vehicle_agent.mission.load import load_mission
from vehicle_agent.mission.terrain import GridTerrain

MISSIONS = Path(__file__).parents[2] / "missions"


def height_m(latitude_deg: float, longitude_deg: float) -> float:
    """A surface that bilinear interpolation reproduces exactly."""
    east, north = (longitude_deg - 7.0) * 1e3, (latitude_deg - 45.0) * 1e3
    return 500.0 + 3.0 * east - 2.0 * north + 0.01 * east * north


def survey(path: Path) -> Path:
    """A raster of 60 x 50 cells of 0.001 degrees around 45 N, 7 E, row 0 in the north."""
    rows, columns = 60, 50
    latitudes = 45.03 - (np.arange(rows) + 0.5) * 0.001
    longitudes = 6.975 + (np.arange(columns) + 0.5) * 0.001
    np.savez(
        path,
        elevation_m=np.array([[height_m(latitude, longitude) for longitude in longitudes] for latitude in latitudes]),
        west_deg=6.975,
        east_deg=7.025,
        south_deg=44.97,
        north_deg=45.03,
        note="made up",
    )
    return path


def test_resampling_finds_the_ground_under_each_cell(tmp_path: Path) -> None:
    raster = Raster.read(survey(tmp_path / "survey.npz"))
    datum, grid = Datum(45.001, 7.002), Grid(-500.0, -700.0, 30.0, 40, 45)
    found = resample(raster, datum, grid)
    expected = np.empty(grid.shape)
    for column in range(grid.columns):
        for row in range(grid.rows):
            there: Geodetic = datum.to_geodetic((*grid.centre_of(column, row), 0.0))
            expected[column, row] = height_m(there.latitude_deg, there.longitude_deg)
    assert np.abs(found - expected).max() <= 0.05 + 1e-6
    assert found[-1, 0] > found[0, 0] > found[0, -1]


def test_ground_beyond_the_survey_is_refused(tmp_path: Path) -> None:
    raster = Raster.read(survey(tmp_path / "survey.npz"))
    with pytest.raises(RasterError, match="move the datum"):
        resample(raster, Datum(45.0, 7.0), Grid(0.0, 0.0, 100.0, 30, 5))


def test_the_program_writes_a_terrain_file_the_same_twice(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mission = tmp_path / "m.toml"
    text = (MISSIONS / "ridge.toml").read_text(encoding="utf-8")
    for old, new in (("36.654", "45.0"), ("-84.37", "7.0"), ("4000.0, 4000.0]", "900.0, 900.0]")):
        assert old in text
        text = text.replace(old, new, 1)
    mission.write_text(text, encoding="utf-8")
    source = str(survey(tmp_path / "survey.npz"))
    for name in ("a.npz", "b.npz"):
        assert main([source, str(mission), str(tmp_path / name)]) == 0
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    assert "65 x 65 cells of 20 m" in capsys.readouterr().out


def test_the_program_explains_itself(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ridge = str(MISSIONS / "ridge.toml")
    (tmp_path / "text.npz").write_text("no raster")
    assert main([]) == 2
    assert main([str(tmp_path / "none.npz"), ridge, "out.npz"]) == 2
    assert main([str(tmp_path / "text.npz"), ridge, "out.npz"]) == 2
    assert main([str(survey(tmp_path / "survey.npz")), str(tmp_path / "none.toml"), "out.npz"]) == 2
    assert main([str(tmp_path / "survey.npz"), ridge, "out.npz"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 5
    assert "usage" in lines[0]


def test_ridge_stands_on_real_relief_and_starts_on_gentle_ground() -> None:
    plan = load_mission(MISSIONS / "ridge.toml")
    assert isinstance(plan.mission.terrain, GridTerrain)
    file = MISSIONS / plan.mission.terrain.file
    assert file.stat().st_size < 200_000
    with np.load(file, allow_pickle=False) as content:
        elevation = content["elevation_amsl_m"].astype(np.float64)
        grid = Grid(float(content["west_m"]), float(content["south_m"]), float(content["cell_m"]), *elevation.shape)
        assert "public domain" in str(content["note"])
    assert grid.cell_m == plan.grid.cell_m
    assert (grid.west_m, grid.south_m) == (plan.grid.west_m - MARGIN_M, plan.grid.south_m - MARGIN_M)
    assert (grid.east_m, grid.north_m) == (plan.grid.east_m + MARGIN_M, plan.grid.north_m + MARGIN_M)
    np.testing.assert_array_equal(elevation, np.round(elevation.astype(np.float32), 1).astype(np.float64))
    inside = elevation[10:-10, 10:-10]
    assert 300.0 < inside.max() - inside.min() < 500.0
    slopes_deg = np.degrees(np.arctan(np.hypot(*np.gradient(elevation, grid.cell_m))))
    for vehicle in plan.mission.vehicles:
        column, row = grid.cell_of(*vehicle.start_enu_m[:2])
        assert slopes_deg[column - 1 : column + 2, row - 1 : row + 2].max() < 5.0
