"""Sea floors of 100 m x 100 m: real bathymetry scaled down, with detail that a survey at sea would not show.

`python -m missions.terrain.sea_floor crop SOURCE.npz` cuts the two pieces kept in `sea_floors.npz` out of a bathymetry
grid (`elevation_m` by latitude and longitude, `note`); `python -m missions.terrain.sea_floor harbour` makes the terrain
of the harbour mission.

`sharp` is the head of a submarine canyon in an even shelf off the Strait of Juan de Fuca, `slope` the continental
slope beside it. A floor is drawn from a seed thus: the piece is turned or mirrored in one of eight ways, interpolated
by cubic splines, scaled to `RELIEF_M` of relief below `TOP_M`, and smoothed. Then comes detail: where the floor is
steeper than `SEDIMENT_DEG`, rock crops out, up to `ROCK_M` where it is steeper than `ROCK_DEG`; flatter ground is
sediment with `RIPPLE_M`. Both are Gaussian random fields of two correlation lengths (`DETAIL`).
"""

from __future__ import annotations

import sys
from importlib.resources import as_file, files
from pathlib import Path
from typing import Literal

import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates

from vehicle_agent.domain.frames import FloatArray

FloorName = Literal["sharp", "slope"]
CROPS: dict[FloorName, tuple[slice, slice]] = {
    "sharp": (slice(12, 24), slice(0, 12)),
    "slope": (slice(0, 12), slice(0, 12)),
}
"""Rows and columns of the source."""
SIDE_M = 100.0
CELL_M = 0.5
TOP_M, RELIEF_M = -6.0, 14.0
SMOOTHED_M = 3.0
SEDIMENT_DEG, ROCK_DEG = 10.0, 18.0
RIPPLE_M, ROCK_M = 0.02, 0.8
DETAIL = ((5.0, 0.8), (2.5, 0.4))
"""Correlation length in metres and share of each field of detail."""
DETAIL_SPAWN_KEY = (3_000,)
HARBOUR_SEED = 11


def sea_floor(name: FloorName, seed: int) -> FloatArray:
    """One floor: (200, 200) float64, columns to the east and rows to the north, ENU z at centres of `CELL_M` cells."""
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=DETAIL_SPAWN_KEY))
    with as_file(files("missions.terrain") / "sea_floors.npz") as path, np.load(path, allow_pickle=False) as source:
        piece = source[f"{name}_elevation_m"].astype(np.float64)
    way = int(rng.integers(8))
    piece = np.rot90(piece, way % 4)
    piece = piece[:, ::-1] if way >= 4 else piece
    cells = round(SIDE_M / CELL_M)
    at = (np.arange(cells) + 0.5) / cells * (len(piece) - 1)
    floor = map_coordinates(piece, np.array(np.meshgrid(at, at, indexing="ij")), order=3, mode="nearest")
    floor = TOP_M + RELIEF_M * (floor - floor.max()) / np.ptp(floor)
    floor = gaussian_filter(floor, SMOOTHED_M / CELL_M, mode="nearest")
    steepness_deg = np.degrees(np.arctan(np.hypot(*np.gradient(floor, CELL_M))))
    rocky = np.clip((steepness_deg - SEDIMENT_DEG) / (ROCK_DEG - SEDIMENT_DEG), 0.0, 1.0)
    rocky = rocky**2 * (3.0 - 2.0 * rocky)
    detail = np.zeros_like(floor)
    for length_m, share in DETAIL:
        # Smoothed by a Gaussian, white noise is correlated over that times the square root of two.
        field = gaussian_filter(rng.standard_normal(floor.shape), length_m / CELL_M / np.sqrt(2.0), mode="wrap")
        detail += share * field / field.std()
    surface: FloatArray = floor + (RIPPLE_M + ROCK_M * rocky) * detail
    return surface


def crop(source: Path, target: Path) -> None:
    """Cut the pieces out of a bathymetry grid."""
    with np.load(source, allow_pickle=False) as grid:
        elevation_m, note = grid["elevation_m"], str(grid["note"])
        south, west = float(grid["latitude_deg"][0]), float(grid["longitude_deg"][0])
    pieces = {f"{name}_elevation_m": elevation_m[rows, columns].T for name, (rows, columns) in CROPS.items()}
    np.savez_compressed(
        target,
        **pieces,
        note=np.str_(
            f"Source: {note}. Pieces of 12 x 12 cells counted from latitude {south:.3f}, longitude {west:.3f}; axes "
            "(columns to the east, rows to the north), metres above mean sea level"
        ),
    )


def write_harbour(target: Path) -> None:
    """Make the harbour mission's terrain: a `sharp` floor at centres of cells of 1 m."""
    floor = sea_floor("sharp", HARBOUR_SEED)
    cells = round(SIDE_M)
    np.savez_compressed(
        target,
        elevation_amsl_m=floor.reshape(cells, 2, cells, 2).mean(axis=(1, 3)).round(2).astype(np.float32),
        west_m=np.float64(0.0),
        south_m=np.float64(0.0),
        cell_m=np.float64(1.0),
        note=np.str_(
            f"Sea floor 'sharp' of seed {HARBOUR_SEED} as missions/terrain/sea_floor.py draws it: bathymetry of the "
            "Salish Sea scaled down, with seeded detail. No place on Earth looks like this."
        ),
    )


def main(arguments: list[str]) -> int:
    here = Path(__file__).parent
    match arguments:
        case ["crop", source]:
            crop(Path(source), here / "sea_floors.npz")
        case ["harbour"]:
            write_harbour(here / "harbour.npz")
        case _:
            print("usage: python -m missions.terrain.sea_floor crop SOURCE.npz | harbour", file=sys.stderr)
            return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
