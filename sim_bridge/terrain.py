"""The true surface of a mission, from measured elevations, drawn hills or level ground, on the mission's grid."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid, IndexArray
from vehicle_agent.mission.load import MissionError, MissionPlan
from vehicle_agent.mission.terrain import FlatTerrain, GaussianTerrain, GridTerrain, TownTerrain

HILLS_SPAWN_KEY = (1000,)
"""Key of the hills' random stream: apart from those of the vehicles, which are keyed by their index."""


def true_surface(plan: MissionPlan) -> FloatArray:
    """Elevation of every cell's centre: (columns, rows) float64, ENU z in metres; MissionError when there is none."""
    terrain = plan.mission.terrain
    if isinstance(terrain, GridTerrain):
        return _measured(plan, terrain) - plan.datum.altitude_amsl_m
    if isinstance(terrain, GaussianTerrain):
        return _hills(plan, terrain)
    if isinstance(terrain, TownTerrain):
        return np.zeros(plan.grid.shape)
    assert isinstance(terrain, FlatTerrain)
    return np.full(plan.grid.shape, terrain.elevation_amsl_m - plan.datum.altitude_amsl_m)


def _hills(plan: MissionPlan, terrain: GaussianTerrain) -> FloatArray:
    """Gaussians on level ground at the datum's altitude; the same seed gives the same hills."""
    low_m, high_m = terrain.height_m
    if low_m > high_m:
        raise MissionError(f"{plan.source}: terrain.height_m: give the lowest peak first, then the highest")
    rng = np.random.default_rng(np.random.SeedSequence(plan.mission.seed, spawn_key=HILLS_SPAWN_KEY))
    grid = plan.grid
    east_m = rng.uniform(grid.west_m, grid.east_m, terrain.peaks)
    north_m = rng.uniform(grid.south_m, grid.north_m, terrain.peaks)
    heights_m = rng.uniform(low_m, high_m, terrain.peaks)
    across = np.exp(-0.5 * ((grid.centres_east_m()[:, None] - east_m) / terrain.sigma_m) ** 2)
    along = np.exp(-0.5 * ((grid.centres_north_m()[:, None] - north_m) / terrain.sigma_m) ** 2)
    surface: FloatArray = np.einsum("cp,rp,p->cr", across, along, heights_m)
    return surface


def _measured(plan: MissionPlan, terrain: GridTerrain) -> FloatArray:
    """Elevations above mean sea level from the terrain file, interpolated bilinearly between its cell centres."""
    path = plan.source.parent / terrain.file
    elevation_amsl_m, measured = _read(plan.source, path)
    grid = plan.grid
    slack = 1e-6 * measured.cell_m
    if (
        grid.centre_of(0, 0)[0] < measured.west_m - slack
        or grid.centre_of(0, 0)[1] < measured.south_m - slack
        or grid.centre_of(grid.columns - 1, 0)[0] > measured.east_m + slack
        or grid.centre_of(0, grid.rows - 1)[1] > measured.north_m + slack
    ):
        raise MissionError(
            f"{path}: covers east {measured.west_m:g} to {measured.east_m:g} m and north {measured.south_m:g} to "
            f"{measured.north_m:g} m, but the area needs {grid.west_m:g} to {grid.east_m:g} m and {grid.south_m:g} "
            f"to {grid.north_m:g} m; make the area smaller or give a larger terrain"
        )
    columns = (grid.centres_east_m() - measured.west_m) / measured.cell_m - 0.5
    rows = (grid.centres_north_m() - measured.south_m) / measured.cell_m - 0.5
    surface = _bilinear(elevation_amsl_m, columns, rows)
    if not np.isfinite(surface).all():
        column, row = (int(first) for first in np.argwhere(~np.isfinite(surface))[0])
        east_m, north_m = grid.centre_of(column, row)
        raise MissionError(
            f"{path}: elevation_amsl_m has no finite value near east {east_m:g} m, north {north_m:g} m; "
            "fill its gaps or move the area"
        )
    return surface


def _bilinear(values: FloatArray, columns: FloatArray, rows: FloatArray) -> FloatArray:
    """Values at fractional places, (C,) and (R,) -> (C, R); beyond the border the border's values."""
    west, east, eastward = _neighbours(columns, values.shape[0])
    south, north, northward = _neighbours(rows, values.shape[1])
    along_west = values[np.ix_(west, south)] * (1.0 - northward) + values[np.ix_(west, north)] * northward
    along_east = values[np.ix_(east, south)] * (1.0 - northward) + values[np.ix_(east, north)] * northward
    surface: FloatArray = along_west * (1.0 - eastward[:, None]) + along_east * eastward[:, None]
    return surface


def _neighbours(places: FloatArray, size: int) -> tuple[IndexArray, IndexArray, FloatArray]:
    inside = np.clip(places, 0.0, size - 1.0)
    low = np.floor(inside).astype(np.int64)
    return low, np.minimum(low + 1, size - 1), inside - low


def _read(source: Path, path: Path) -> tuple[FloatArray, Grid]:
    try:
        with np.load(path, allow_pickle=False) as content:
            if not isinstance(content, np.lib.npyio.NpzFile):
                raise MissionError(f"{path}: is not an .npz archive; save the terrain with numpy.savez")
            values: dict[str, Any] = {name: content[name] for name in content.files}
    except FileNotFoundError:
        raise MissionError(
            f"{source}: terrain.file: {path} does not exist; correct the path, which counts from the mission file"
        ) from None
    except (OSError, ValueError, EOFError, zipfile.BadZipFile, zlib.error, AttributeError) as error:
        raise MissionError(f"{path}: cannot be read as terrain ({error}); save it anew with numpy.savez") from None
    missing = [name for name in ("elevation_amsl_m", "west_m", "south_m", "cell_m") if name not in values]
    if missing:
        raise MissionError(f"{path}: has no {', '.join(missing)}; add what is missing")
    try:
        elevation_amsl_m = np.asarray(values["elevation_amsl_m"]).astype(np.float64)
        west_m, south_m, cell_m = (float(values[name]) for name in ("west_m", "south_m", "cell_m"))
        if elevation_amsl_m.ndim != 2:
            raise ValueError("elevation_amsl_m must have two dimensions, columns and rows")
        if not np.isfinite([west_m, south_m]).all():
            raise ValueError("west_m and south_m must be finite")
        grid = Grid(west_m, south_m, cell_m, *elevation_amsl_m.shape)
    except (TypeError, ValueError) as error:
        raise MissionError(f"{path}: is no terrain ({error}); correct it") from None
    return elevation_amsl_m, grid
