"""Sea floors of 100 m x 100 m: real bathymetry scaled down, with detail that a survey at sea would not show.

`python -m missions.terrain.sea_floor crop SOURCE.npz` cuts the two pieces kept in `sea_floors.npz` out of a bathymetry
grid (`elevation_m` by latitude and longitude, `note`); `python -m missions.terrain.sea_floor harbour` makes the terrain
of the harbour mission.

`sharp` is the head of a submarine canyon in an even shelf off the Strait of Juan de Fuca, `slope` the continental
slope beside it. A floor is drawn from a seed thus: the piece is turned or mirrored in one of eight ways, interpolated
by cubic splines and scaled to `RELIEF_M` of relief below `TOP_M`. Below the shortest wave that the piece can show (two
of its cells) its own roughness goes on: a Gaussian random field whose spectrum falls by the power law that the piece's
second differences follow, at the strength that they have, and from place to place as strong as they are there. Nothing
of the detail is chosen by hand.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
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
COVARIANCE_CELL_M = 0.125
TOP_M, RELIEF_M = -6.0, 14.0
FITTED_LAGS = (1, 2, 3, 4)
"""In cells of the piece: the second differences that the power law is fitted to."""
LOCAL_CELLS = 1.0
"""Standard deviation of the Gaussian over which the piece's roughness counts as that of a place."""
DETAIL_SPAWN_KEY = (3_000,)
HARBOUR_SEED = 11


@dataclass(frozen=True, slots=True)
class Roughness:
    """How rough a surface is: the mean square of its increments over a distance r is `increment_m2` r^(2 `hurst`).

    Attributes
    ----------
    hurst
        Exponent, in (0, 1).
    increment_m2
        Mean square of increments over one metre.
    """

    hurst: float
    increment_m2: float

    def density(self, wave_number: FloatArray) -> FloatArray:
        """Spectral density over angular wave numbers |k| > 0 in 1/m: m^4, of fractional Brownian motion in a plane."""
        h = self.hurst
        scale = 4.0 * math.pi * 2.0 ** (-2.0 * h - 1.0) * math.gamma(1.0 - h) / (h * math.gamma(1.0 + h))
        density: FloatArray = self.increment_m2 / scale * wave_number ** (-2.0 * h - 2.0)
        return density


def roughness_of(piece_m: FloatArray, cell_m: float) -> Roughness:
    """Fit a power law to the mean squares of second differences, which a slope does not touch: (rows, columns) m."""
    lags = np.array(FITTED_LAGS, dtype=np.float64)
    squares = np.array(
        [np.mean(np.concatenate([d.ravel() for d in _second_differences(piece_m, lag)]) ** 2) for lag in FITTED_LAGS]
    )
    slope, level = np.polyfit(np.log(lags * cell_m), np.log(squares), 1)
    hurst = float(np.clip(0.5 * slope, 0.05, 0.95))
    return Roughness(hurst, float(np.exp(level)) / (4.0 - 4.0**hurst))


def sea_floor(name: FloorName, seed: int) -> FloatArray:
    """One floor: (200, 200) float64, columns to the east and rows to the north, ENU z at centres of `CELL_M` cells."""
    rng = _generator(seed)
    piece = _piece(name, rng)
    cells = round(SIDE_M / CELL_M)
    noise = rng.standard_normal((cells, cells))
    detail: FloatArray = np.fft.ifft2(np.fft.fft2(noise) * _amplitude(piece)).real
    floor: FloatArray = floor_without_detail(name, seed) + floor_strength(name, seed) * detail
    return floor


def floor_without_detail(name: FloorName, seed: int) -> FloatArray:
    """What the real data show of a floor: (200, 200) float64, ENU z."""
    piece = _piece(name, _generator(seed))
    surface: FloatArray = map_coordinates(piece, _cells_in(piece), order=3, mode="nearest")
    return surface


def detail_covariance(name: FloorName) -> FloatArray:
    """Covariance of the detail, before its strength, over distances along both axes of 0, `COVARIANCE_CELL_M`, ...

    (800, 800) float64 square metres, seamless at its edges as the detail is; of a floor interpolated between cells.
    """
    with as_file(files("missions.terrain") / "sea_floors.npz") as path, np.load(path, allow_pickle=False) as source:
        piece = _scaled(source[f"{name}_elevation_m"].astype(np.float64))
    amplitude = _amplitude(piece)
    cells, fine = len(amplitude), round(SIDE_M / COVARIANCE_CELL_M)
    left = np.sinc(np.fft.fftfreq(cells)) ** 4  # of a wave's power, by linear interpolation
    power = np.zeros((fine, fine))
    rows = np.round(np.fft.fftfreq(cells) * cells).astype(np.int64) % fine
    power[np.ix_(rows, rows)] = amplitude**2 * left[:, None] * left
    covariance: FloatArray = np.fft.ifft2(power).real * (fine / cells) ** 2
    return covariance


def floor_strength(name: FloorName, seed: int) -> FloatArray:
    """How rough a floor is from place to place, over how rough it is on the whole: (200, 200) float64, no unit."""
    piece = _piece(name, _generator(seed))
    strength: FloatArray = map_coordinates(_local_strength(piece), _cells_in(piece), order=1, mode="nearest")
    return strength


def _generator(seed: int) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=DETAIL_SPAWN_KEY))


def _piece(name: FloorName, rng: np.random.Generator) -> FloatArray:
    """The real data, scaled, turned and mirrored: (12, 12) ENU metres."""
    with as_file(files("missions.terrain") / "sea_floors.npz") as path, np.load(path, allow_pickle=False) as source:
        piece = source[f"{name}_elevation_m"].astype(np.float64)
    way = int(rng.integers(8))
    piece = np.rot90(piece, way % 4)
    piece = piece[:, ::-1] if way >= 4 else piece
    return _scaled(piece)


def _scaled(piece: FloatArray) -> FloatArray:
    scaled: FloatArray = TOP_M + RELIEF_M * (piece - piece.max()) / np.ptp(piece)
    return scaled


def _cells_in(piece_m: FloatArray) -> FloatArray:
    """Centres of a floor's cells in rows and columns of the piece: (2, 200, 200)."""
    cells = round(SIDE_M / CELL_M)
    at = (np.arange(cells) + 0.5) / cells * (len(piece_m) - 1)
    return np.array(np.meshgrid(at, at, indexing="ij"))


def _amplitude(piece_m: FloatArray) -> FloatArray:
    """What every wave of white noise on a floor's cells is multiplied by to make the detail of a piece: (200, 200)."""
    piece_cell_m = SIDE_M / (len(piece_m) - 1)
    axis = 2.0 * math.pi * np.fft.fftfreq(round(SIDE_M / CELL_M), CELL_M)
    wave_number = np.hypot(axis[:, None], axis)
    short = wave_number > 2.0 * math.pi / (2.0 * piece_cell_m)
    amplitude: FloatArray = np.zeros_like(wave_number)
    density = roughness_of(piece_m, piece_cell_m).density(wave_number[short])
    amplitude[short] = np.sqrt(density) * 2.0 * math.pi / CELL_M
    return amplitude


def _local_strength(piece_m: FloatArray) -> FloatArray:
    """How rough the piece is around each of its cells, over how rough it is on the whole: same shape, no unit."""
    padded = np.pad(piece_m, 1, mode="reflect", reflect_type="odd")
    along, across = _second_differences(padded, 1)
    squares = along[:, 1:-1] ** 2 + across[1:-1] ** 2
    local = gaussian_filter(squares, LOCAL_CELLS, mode="nearest")
    strength: FloatArray = np.sqrt(local / local.mean())
    return strength


def _second_differences(piece_m: FloatArray, lag: int) -> tuple[FloatArray, FloatArray]:
    """Along rows' numbers and along columns', over `lag` cells to both sides."""
    along = piece_m[2 * lag :] - 2.0 * piece_m[lag:-lag] + piece_m[: -2 * lag]
    across = piece_m[:, 2 * lag :] - 2.0 * piece_m[:, lag:-lag] + piece_m[:, : -2 * lag]
    return along, across


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
