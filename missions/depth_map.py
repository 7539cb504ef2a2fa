"""The depth map that a mapping mission leaves behind: every cell, measured or not, with its uncertainty."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.landmark_atlas import LandmarkAtlas
from vehicle_agent.domain.relief import Relief
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.mission.tasks import MapTask

MOST_LANDMARKS = 3_000
"""Of more than these every n-th is left out of the drawing: its cost grows with the third power."""
NO_DATA = -99999.0
FILES = ("depth_map.npz", "depth_map.csv", "depth_map.asc")


@dataclass(frozen=True, slots=True)
class DepthMap:
    """A map drawn from landmarks.

    Attributes
    ----------
    elevation_m : (columns, rows) float64, ENU z of every cell of the area; NaN outside.
    sd_m : (columns, rows) float64, its standard deviation; NaN outside.
    rms_error_m
        Root mean square difference to the true surface over the area; None where nobody knows that.
    """

    elevation_m: FloatArray
    sd_m: FloatArray
    rms_error_m: float | None


def maps(plan: MissionPlan) -> bool:
    """Whether the mission's task is to map."""
    return isinstance(plan.mission.task, MapTask)


def draw_depth_map(plan: MissionPlan, atlas: LandmarkAtlas, true_elevation_m: FloatArray | None) -> DepthMap | None:
    """Draw the map from what is known of the landmarks; None when none was measured."""
    landmarks = atlas.landmarks
    known = np.flatnonzero(np.isfinite(landmarks.heights_m))
    if len(known) == 0:
        return None
    known = known[:: -(-len(known) // MOST_LANDMARKS)]
    relief = Relief(landmarks.layout.positions_en_m[known], landmarks.heights_m[known], landmarks.sd_m[known])
    area = np.flatnonzero(plan.area_cells.ravel())
    elevation_m, sd_m = (np.full(plan.grid.cells, np.nan) for _ in range(2))
    elevation_m[area] = relief.heights_at(landmarks.layout.positions_en_m[area])
    sd_m[area] = relief.sds_at(landmarks.layout.positions_en_m[area])
    error_m = None
    if true_elevation_m is not None:
        error_m = float(np.sqrt(np.mean((elevation_m[area] - true_elevation_m.ravel()[area]) ** 2)))
    return DepthMap(elevation_m.reshape(plan.grid.shape), sd_m.reshape(plan.grid.shape), error_m)


def write_depth_map(plan: MissionPlan, depth_map: DepthMap, folder: Path) -> None:
    """Write the map thrice: arrays (.npz), a line per cell with latitude and longitude (.csv), an ESRI grid (.asc).

    Elevations in files are metres above mean sea level; the .asc grid lies in the mission's local metres.
    """
    grid, datum = plan.grid, plan.datum
    amsl_m = depth_map.elevation_m + datum.altitude_amsl_m
    archive, lines, esri = (folder / name for name in FILES)
    with archive.open("wb") as file:
        np.savez_compressed(
            file,
            elevation_amsl_m=amsl_m,
            sd_m=depth_map.sd_m,
            west_m=np.float64(grid.west_m),
            south_m=np.float64(grid.south_m),
            cell_m=np.float64(grid.cell_m),
        )
    with lines.open("w") as out:
        out.write("latitude_deg,longitude_deg,elevation_amsl_m,sd_m\n")
        for column, row in np.argwhere(np.isfinite(amsl_m)).tolist():
            place = datum.to_geodetic((*grid.centre_of(column, row), 0.0))
            out.write(
                f"{place.latitude_deg:.7f},{place.longitude_deg:.7f},{amsl_m[column, row]:.3f},"
                f"{depth_map.sd_m[column, row]:.3f}\n"
            )
    with esri.open("w") as out:
        out.write(
            f"ncols {grid.columns}\nnrows {grid.rows}\nxllcorner {grid.west_m:g}\nyllcorner {grid.south_m:g}\n"
            f"cellsize {grid.cell_m:g}\nNODATA_value {NO_DATA:g}\n"
        )
        for row in np.where(np.isfinite(amsl_m), amsl_m, NO_DATA).T[::-1]:
            out.write(" ".join(f"{height:.3f}" for height in row) + "\n")
