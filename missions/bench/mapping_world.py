"""Surfaces and settings of the mapping bench: both maps fill the cube [-1, 1]^3 of Kapoutsis 2015, section 6."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import RectBivariateSpline

from missions.bench.mapping_kernels import look, surface_heights
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.landmark_layout import LandmarkLayout, LandmarkParams
from vehicle_agent.domain.range_sensing import RangeSensor

TERRAIN = Path(__file__).parent.parent / "terrain" / "jacksboro.npz"
MAPS = ("ridge", "rugged")
PIXELS = {"ridge": (87, 87), "rugged": (105, 100)}
"""Points of each map, all of them landmarks in the finer of both cases; the paper has 7542 and 10500."""
FEW = (44, 25)
"""The lattice of 1100 landmarks."""
RUGGED_KNOTS = 9
RUGGED_SEED = 2015
LOWEST, HIGHEST = -1.0, -0.2
"""Heights that each surface spans: above it the cube holds the air to fly in; slopes are 50 degrees in the middle."""


@dataclass(frozen=True, slots=True)
class Setup:
    """What every method has to live with.

    Attributes
    ----------
    range_m, noise_share
        The sensor (eq. 24): visibility threshold, and noise over range.
    accurate_sd_m
        Standard deviation of an accurately estimated landmark.
    clearance_m, ceiling_m
        d and z_max of section 6.
    radio_range_m
        com_R: everybody has somebody within it, always.
    reach_m
        Longest way of one step.
    steps
        Length of a run.
    capacity
        Landmarks in a packet.
    attempts_limit
        Footnote 3.
    """

    range_m: float = 0.3
    noise_share: float = 0.05
    accurate_sd_m: float = 0.01
    clearance_m: float = 0.05
    ceiling_m: float = 1.0
    radio_range_m: float = 0.3
    reach_m: float = 0.05
    steps: int = 500
    capacity: int = 10
    attempts_limit: int = 200

    @property
    def sensor(self) -> RangeSensor:
        return RangeSensor(self.range_m, self.noise_share)

    @property
    def landmark_params(self) -> LandmarkParams:
        best = self.sensor.best_sd_m(self.clearance_m)
        return LandmarkParams(self.accurate_sd_m, best, -1.0, 1.0, self.attempts_limit)


@dataclass(frozen=True, slots=True)
class World:
    """One surface with its landmarks.

    Attributes
    ----------
    elevation
        (columns, rows) float64, heights at the centres of equal cells over [-1, 1] x [-1, 1].
    shape
        (2,) int64, landmarks along x and y.
    layout
        Their places.
    heights
        (N,) float64, their true heights.
    """

    elevation: FloatArray
    shape: IndexArray
    layout: LandmarkLayout
    heights: FloatArray

    def visible(self, eye: FloatArray, range_m: float) -> tuple[IndexArray, FloatArray]:
        """Ids and true ranges of the landmarks that a sensor at a place sees."""
        ids, ranges = np.empty(len(self.heights), np.int64), np.empty(len(self.heights))
        nothing = np.zeros(len(self.heights), dtype=np.bool_)
        count = look(self.elevation, self.shape, self.heights, eye, range_m, nothing, ids, ranges)
        return ids[:count].copy(), ranges[:count].copy()

    def heights_at(self, places: FloatArray) -> FloatArray:
        """Surface heights under places, (N, 2) -> (N,)."""
        return surface_heights(self.elevation, np.ascontiguousarray(places))


def make_world(name: str, few: bool) -> World:
    """One of `MAPS`, with 1100 landmarks or with one at every point."""
    elevation = _ridge() if name == "ridge" else _rugged()
    low, high = elevation.min(), elevation.max()
    elevation = np.ascontiguousarray(LOWEST + (HIGHEST - LOWEST) * (elevation - low) / (high - low))
    wide, long = FEW if few else elevation.shape
    x, y = -1.0 + (np.arange(wide) + 0.5) * 2.0 / wide, -1.0 + (np.arange(long) + 0.5) * 2.0 / long
    places = np.column_stack([axis.ravel() for axis in np.meshgrid(x, y, indexing="ij")])
    layout = LandmarkLayout(places, float(np.sqrt(4.0 / (wide * long))))
    return World(elevation, np.array([wide, long]), layout, surface_heights(elevation, places))


def _ridge() -> FloatArray:
    """A crop of the Jacksboro fault, 4.4 km wide, resampled bilinearly to the map's points."""
    with np.load(TERRAIN, allow_pickle=False) as source:
        heights = source["elevation_amsl_m"].astype(np.float64)
    return _resampled(heights, PIXELS["ridge"], 1)


def _rugged() -> FloatArray:
    """A bicubic spline through knots of uniformly random height: sharp variation everywhere, the same at every call."""
    knots = np.random.default_rng(RUGGED_SEED).uniform(0.0, 1.0, (RUGGED_KNOTS, RUGGED_KNOTS))
    return _resampled(knots, PIXELS["rugged"], 3)


def _resampled(heights: FloatArray, shape: tuple[int, int], degree: int) -> FloatArray:
    along, across = (np.linspace(0.0, 1.0, size) for size in heights.shape)
    spline = RectBivariateSpline(along, across, heights, kx=degree, ky=degree)
    x, y = ((np.arange(size) + 0.5) / size for size in shape)
    surface: FloatArray = spline(x, y)
    return surface
