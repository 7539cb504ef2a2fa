"""A map made of Gaussian basis functions, with its uncertainty (Kapoutsis 2015, eq. 1-3).

The surface is a mean plus a Gaussian around every landmark (eq. 3, with a width in metres). The coefficients minimise
the squared misfit to the landmarks' estimates, each weighted by its confidence (eq. 1 at the landmarks), against a
penalty on roughness; that is Gaussian-process regression, which also tells each cell's standard deviation. The area is
worked tile by tile, each with the landmarks around it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.spatial import cKDTree

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray

_NEIGHBOURS = 250
"""Landmarks that a tile heeds: the nearest to its centre; what lies behind them adds next to nothing."""
_WIDTHS_TRIED = (1.0, 1.5, 2.2, 3.3, 5.0, 7.5)
"""Widths that are compared when none is given, in typical distances between landmarks."""
_SAMPLE = 250
"""Landmarks that choose the width."""
_SMALLEST_SHARE = 1e-4
"""Least variance of a landmark, over the surface's own: it keeps the equations solvable."""


@dataclass(frozen=True, slots=True)
class GaussianMap:
    """A surface as estimated from landmarks.

    Attributes
    ----------
    positions_en_m : (N, 2) float64, the landmarks.
    heights_m, sds_m : (N,) float64, their estimates, ENU z, and standard deviations.
    width_m
        Distance at which a basis function has fallen to 1/e.
    mean_m, spread_m
        Mean height of the surface, and its standard deviation before anything is measured.

    >>> places = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])
    >>> surface = fit_gaussian_map(places, np.array([1.0, 2.0, 2.0, 1.0]), np.full(4, 0.01), width_m=1.5)
    >>> heights, sds = surface.at(np.array([[1.5, 0.0], [90.0, 0.0]]))
    >>> bool(heights[0] > 2.0), bool(abs(heights[1] - surface.mean_m) < 1e-6), bool(sds[0] < 0.2 * sds[1])
    (True, True, True)
    """

    positions_en_m: FloatArray
    heights_m: FloatArray
    sds_m: FloatArray
    width_m: float
    mean_m: float
    spread_m: float

    def at(self, points_en_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Heights and their standard deviations at points: (M, 2) float64 -> (M,), (M,), metres."""
        heights, sds = np.full(len(points_en_m), self.mean_m), np.full(len(points_en_m), self.spread_m)
        tree = cKDTree(self.positions_en_m)
        neighbours = min(_NEIGHBOURS, len(self.positions_en_m))
        for rows in _tiles(points_en_m, self._tile_m()):
            centre = 0.5 * (points_en_m[rows].min(axis=0) + points_en_m[rows].max(axis=0))
            _, near = tree.query(centre, neighbours)
            heights[rows], sds[rows] = self._solve(points_en_m[rows], np.atleast_1d(near))
        return heights, sds

    def _tile_m(self) -> float:
        """Edge of tiles so small that the landmarks around one all bear on it."""
        extent = np.ptp(self.positions_en_m, axis=0)
        area = max(float(extent[0] * extent[1]), 1e-12)
        return 0.3 * math.sqrt(_NEIGHBOURS * area / len(self.positions_en_m))

    def _solve(self, points: FloatArray, near: IndexArray) -> tuple[FloatArray, FloatArray]:
        variance = self.spread_m**2
        places = self.positions_en_m[near]
        factor = _factor(places, self.sds_m[near], self.width_m, variance)
        basis = variance * _gaussians(points, places, self.width_m)
        heights: FloatArray = self.mean_m + basis @ cho_solve(factor, self.heights_m[near] - self.mean_m)
        explained = (solve_triangular(factor[0], basis.T, lower=True) ** 2).sum(axis=0)
        return heights, np.sqrt(np.maximum(variance - explained, 0.0))


def fit_gaussian_map(
    positions_en_m: FloatArray, heights_m: FloatArray, sds_m: FloatArray, width_m: float | None = None
) -> GaussianMap:
    """A map from landmarks.

    Parameters
    ----------
    positions_en_m : (N, 2) float64; heights_m, sds_m : (N,) float64. Rows that are not finite are left out.
    width_m
        Width of the basis functions; the most likely one for these landmarks when left out.

    Raises ValueError when nothing is left or the width is not positive.
    """
    good = np.isfinite(heights_m) & np.isfinite(sds_m) & np.isfinite(positions_en_m).all(axis=1)
    places, heights, sds = positions_en_m[good], heights_m[good], sds_m[good]
    if len(places) == 0:
        raise ValueError("a map needs at least one landmark with an estimate")
    if width_m is not None and not (width_m > 0 and math.isfinite(width_m)):
        raise ValueError("width_m must be positive")
    mean = float(np.average(heights, weights=1.0 / np.maximum(sds, 1e-12) ** 2))
    spread = max(float(np.sqrt(np.mean((heights - mean) ** 2))), float(sds.min()), 1e-9)
    width = width_m if width_m is not None else _likeliest_width(places, heights - mean, sds, spread)
    return GaussianMap(places, heights, sds, width, mean, spread)


def _likeliest_width(places: FloatArray, deviations: FloatArray, sds: FloatArray, spread: float) -> float:
    """The width of greatest marginal likelihood among some, judged by landmarks that lie together."""
    extent = np.ptp(places, axis=0)
    spacing = math.sqrt(max(float(extent[0] * extent[1]), float(extent.max()) ** 2 / len(places), 1e-12) / len(places))
    centre = places[len(places) // 2]
    near = np.argsort(((places - centre) ** 2).sum(axis=1), kind="stable")[:_SAMPLE]
    best, chosen = -math.inf, spacing * _WIDTHS_TRIED[1]
    for share in _WIDTHS_TRIED:
        factor = _factor(places[near], sds[near], share * spacing, spread**2)
        misfit = float(deviations[near] @ cho_solve(factor, deviations[near]))
        likelihood = -0.5 * misfit - float(np.log(np.diag(factor[0])).sum())
        if likelihood > best:
            best, chosen = likelihood, share * spacing
    return chosen


def _tiles(points: FloatArray, tile_m: float) -> list[IndexArray]:
    """Rows of points that lie in the same square tile."""
    cells = np.floor((points - points.min(axis=0)) / tile_m).astype(np.int64) if len(points) else np.empty((0, 2))
    _, inverse = np.unique(cells, axis=0, return_inverse=True)
    order = np.argsort(inverse, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(inverse[order])) + 1) if len(points) else []


def _factor(places: FloatArray, sds: FloatArray, width: float, variance: float) -> tuple[FloatArray, bool]:
    """Cholesky factor of the landmarks' covariance, lower."""
    covariance = variance * _gaussians(places, places, width)
    covariance[np.diag_indices_from(covariance)] += np.maximum(sds**2, _SMALLEST_SHARE * variance)
    lower, is_lower = cho_factor(covariance, lower=True)
    return np.tril(lower), bool(is_lower)


def _gaussians(points: FloatArray, places: FloatArray, width: float) -> FloatArray:
    """phi (eq. 3) of every place at every point: (M, 2), (N, 2) -> (M, N)."""
    squared = (points**2).sum(axis=1)[:, None] + (places**2).sum(axis=1)[None, :] - 2.0 * (points @ places.T)
    basis: FloatArray = np.exp(-np.maximum(squared, 0.0) / width**2)
    return basis
