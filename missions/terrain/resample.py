"""Makes a mission's terrain file from a survey raster.

`python -m missions.terrain.resample SOURCE.npz MISSION.toml OUT.npz`, where the source holds `elevation_m`
(rows, columns) in metres above mean sea level with row 0 in the north, `west_deg`, `east_deg`, `south_deg`, `north_deg`
(outer edges of the raster, WGS 84 or NAD 83) and `note`. Elevations at the centres of the mission's cells, and of those
up to 200 m around its area, are interpolated bilinearly between the source's cell centres and rounded to decimetres.
"""

from __future__ import annotations

import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vehicle_agent.domain.frames import Datum, FloatArray, Geodetic
from vehicle_agent.domain.grid import Grid
from vehicle_agent.mission.load import MissionError, load_mission

MARGIN_M = 200.0
"""Ground known beyond the area on every side, so that what stands at the border is not a cliff."""


class RasterError(Exception):
    """A source that cannot be used; its text is one sentence."""


@dataclass(frozen=True, slots=True)
class Raster:
    """Elevation on a geographic grid.

    Attributes
    ----------
    elevation_amsl_m
        (rows, columns) float64, row 0 in the south.
    west_deg, south_deg
        Outer edge of the raster.
    column_deg, row_deg
        Extent of one cell.
    note
        Origin and licence.
    """

    elevation_amsl_m: FloatArray
    west_deg: float
    south_deg: float
    column_deg: float
    row_deg: float
    note: str

    @classmethod
    def read(cls, path: Path) -> Raster:
        """Read a source file; raises RasterError."""
        try:
            with np.load(path, allow_pickle=False) as source:
                elevation_m = source["elevation_m"].astype(np.float64)[::-1]
                west, east, south, north = (
                    float(source[key]) for key in ("west_deg", "east_deg", "south_deg", "north_deg")
                )
                note = str(source["note"])
        except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
            raise RasterError(
                f"{path}: is not a raster as `missions.terrain.resample` describes it ({error})"
            ) from None
        rows, columns = elevation_m.shape
        return cls(elevation_m, west, south, (east - west) / columns, (north - south) / rows, note)

    def at(self, latitudes_deg: FloatArray, longitudes_deg: FloatArray) -> FloatArray:
        """Elevation at points between the outermost cell centres: (...), (...) -> (...) metres; else RasterError."""
        row = (latitudes_deg - self.south_deg) / self.row_deg - 0.5
        column = (longitudes_deg - self.west_deg) / self.column_deg - 0.5
        rows, columns = self.elevation_amsl_m.shape
        if row.min() < 0 or column.min() < 0 or row.max() > rows - 1 or column.max() > columns - 1:
            raise RasterError("the mission's area and its margin reach beyond the source; move the datum")
        south = np.minimum(row.astype(np.int64), rows - 2)
        west = np.minimum(column.astype(np.int64), columns - 2)
        north_weight, east_weight = row - south, column - west
        z = self.elevation_amsl_m
        southern = z[south, west] * (1 - east_weight) + z[south, west + 1] * east_weight
        northern = z[south + 1, west] * (1 - east_weight) + z[south + 1, west + 1] * east_weight
        elevation: FloatArray = southern * (1 - north_weight) + northern * north_weight
        return elevation


def resample(raster: Raster, datum: Datum, grid: Grid) -> FloatArray:
    """Elevation above mean sea level at a local grid's cell centres: (columns, rows) float64, rounded to 0.1 m."""
    longitudes_deg = [datum.to_geodetic((east, 0.0, 0.0)).longitude_deg for east in grid.centres_east_m()]
    latitudes_deg = [datum.to_geodetic((0.0, north, 0.0)).latitude_deg for north in grid.centres_north_m()]
    longitude, latitude = np.meshgrid(np.array(longitudes_deg), np.array(latitudes_deg), indexing="ij")
    return np.round(raster.at(latitude, longitude), 1)


def main(arguments: list[str]) -> int:
    if len(arguments) != 3:
        print("usage: python -m missions.terrain.resample SOURCE.npz MISSION.toml OUT.npz", file=sys.stderr)
        return 2
    source, mission_file, target = map(Path, arguments)
    try:
        raster = Raster.read(source)
        plan = load_mission(mission_file)
        area = plan.grid
        grid = Grid.over(
            area.west_m - MARGIN_M,
            area.south_m - MARGIN_M,
            area.east_m + MARGIN_M,
            area.north_m + MARGIN_M,
            area.cell_m,
        )
        elevation_amsl_m = resample(raster, plan.datum, grid)
    except (RasterError, MissionError) as error:
        print(error, file=sys.stderr)
        return 2
    origin = plan.datum.to_geodetic((0.0, 0.0, 0.0))
    np.savez_compressed(
        target,
        elevation_amsl_m=elevation_amsl_m.astype(np.float32),
        west_m=np.float64(grid.west_m),
        south_m=np.float64(grid.south_m),
        cell_m=np.float64(grid.cell_m),
        note=np.str_(_note(raster, origin)),
    )
    relief_m = float(elevation_amsl_m.max() - elevation_amsl_m.min())
    print(f"{target}: {grid.columns} x {grid.rows} cells of {grid.cell_m:g} m, relief {relief_m:.0f} m")
    return 0


def _note(raster: Raster, origin: Geodetic) -> str:
    return (
        f"Source raster: {raster.note}. Resampled bilinearly by missions/terrain/resample.py to cell centres of the "
        f"local east-north frame at latitude {origin.latitude_deg:g}, longitude {origin.longitude_deg:g}; "
        "metres above mean sea level, axes (columns to the east, rows to the north)."
    )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
