"""Constrained centroidal Voronoi tessellation of an approximate surface (Renzaglia 2020, section 5.1).

A few known points make a piecewise-linear surface; the team's generators are spread over it so that each is the
centroid of its cell, and lifted to an admissible height they are where the team starts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import Delaunay

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray

Rectangle = tuple[float, float, float, float]
"""West, south, east, north, ENU metres."""
_LEAST_AREA_M2 = 1e-6
"""Points on one line make triangles that are none."""


@dataclass(frozen=True, slots=True)
class TessellationParams:
    """How the probabilistic Lloyd iteration runs.

    Attributes
    ----------
    samples_per_iteration
        Surface points drawn per iteration (q in the paper). At least 1.
    running_weight, first_weight
        Pull of an iteration's samples against the generator, in (0, 1]: in the long run (beta_2) and what the first
        iterations have on top (gamma_2).
    iterations
        At most so many.
    still_m
        Converged when no generator moves further than this in an iteration.
    """

    samples_per_iteration: int = 2_000
    running_weight: float = 0.3
    first_weight: float = 0.7
    iterations: int = 60
    still_m: float = 0.25

    def __post_init__(self) -> None:
        if self.samples_per_iteration < 1 or self.iterations < 1:
            raise ValueError("samples_per_iteration and iterations must be at least 1")
        if not (0.0 < self.running_weight <= 1.0 and 0.0 < self.first_weight <= 1.0):
            raise ValueError("running_weight and first_weight must lie in (0, 1]")


class ApproximateSurface:
    """Piecewise-linear surface through a few known points of a rectangular area (S' in the paper).

    Corners of the area that are not known take the height of the nearest known point, so that the surface reaches
    over the whole area.

    Parameters
    ----------
    known_enu_m : (n, 3) float64, ENU metres, inside the area; at least one.
    area
        West, south, east, north.

    Raises
    ------
    ValueError
        When no point is known, or one lies outside the area or is not finite.
    """

    def __init__(self, known_enu_m: FloatArray, area: Rectangle) -> None:
        west, south, east, north = area
        known = np.array(known_enu_m, dtype=np.float64).reshape(-1, 3)
        if len(known) == 0:
            raise ValueError("an approximate surface needs at least one known point")
        inside = (known[:, 0] >= west) & (known[:, 0] <= east) & (known[:, 1] >= south) & (known[:, 1] <= north)
        if not (inside & np.isfinite(known).all(axis=1)).all():
            first = known[int(np.argmin(inside & np.isfinite(known).all(axis=1)))]
            raise ValueError(
                f"the known point ({first[0]:g}, {first[1]:g}) lies outside the area; remove it or widen the area"
            )
        corners = np.array([(west, south), (east, south), (east, north), (west, north)])
        away = np.linalg.norm(corners[:, None, :] - known[None, :, :2], axis=2)
        points = np.vstack((np.column_stack((corners, known[away.argmin(axis=1), 2])), known))
        _, first_of = np.unique(points[::-1, :2], axis=0, return_index=True)  # a known corner before a supposed one
        self.points_enu_m: FloatArray = points[::-1][np.sort(first_of)]
        triangles: IndexArray = Delaunay(self.points_enu_m[:, :2]).simplices.astype(np.int64)
        sides = np.diff(self.points_enu_m[triangles], axis=1)
        areas = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
        self.triangles: IndexArray = triangles[areas > _LEAST_AREA_M2]
        self._corners = self.points_enu_m[self.triangles]  # (T, 3, 3)
        self._shares = areas[areas > _LEAST_AREA_M2] / areas[areas > _LEAST_AREA_M2].sum()

    def sample(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Points drawn uniformly from the surface: (count, 3) float64."""
        chosen = self._corners[rng.choice(len(self.triangles), count, p=self._shares)]
        a, b = rng.random((2, count))
        beyond = a + b > 1.0
        a[beyond], b[beyond] = 1.0 - a[beyond], 1.0 - b[beyond]
        first = chosen[:, 0]
        points: FloatArray = first + a[:, None] * (chosen[:, 1] - first) + b[:, None] * (chosen[:, 2] - first)
        return points

    def project(self, points_enu_m: FloatArray) -> FloatArray:
        """Nearest points of the surface: (N, 3) -> (N, 3) float64 (proj in the paper)."""
        points = points_enu_m[:, None, :]
        a, b, c = self._corners[:, 0], self._corners[:, 1], self._corners[:, 2]
        choices = np.stack(
            [
                _nearest_on_plane(points, a, b, c),
                _nearest_on_edge(points, a, b),
                _nearest_on_edge(points, b, c),
                _nearest_on_edge(points, c, a),
            ],
            axis=2,
        ).reshape(len(points_enu_m), -1, 3)
        away = np.linalg.norm(choices - points, axis=2)
        nearest: FloatArray = choices[np.arange(len(points_enu_m)), away.argmin(axis=1)]
        return nearest


def tessellate(
    surface: ApproximateSurface, vehicles: int, params: TessellationParams, rng: np.random.Generator
) -> FloatArray:
    """Spread `vehicles` generators over the surface so that each is the centroid of its cell.

    The probabilistic Lloyd iteration of MacQueen's kind: no Voronoi cell is ever built.

    Returns
    -------
    (vehicles, 3) float64, ENU metres, on the surface.
    """
    beta_2, gamma_2 = params.running_weight, params.first_weight
    beta_1, gamma_1 = 1.0 - beta_2, 1.0 - gamma_2
    generators = surface.sample(vehicles, rng)
    updates = np.ones(vehicles)  # j_i
    for _ in range(params.iterations):
        samples = surface.sample(params.samples_per_iteration, rng)
        nearest = np.linalg.norm(samples[:, None, :] - generators[None, :, :], axis=2).argmin(axis=1)  # eq. 13
        before = generators.copy()
        for index in range(vehicles):
            mine = samples[nearest == index]  # W_i
            if len(mine) == 0:
                continue
            j = updates[index]
            pull = (beta_1 * j + gamma_1) * generators[index] + (beta_2 * j + gamma_2) * mine.mean(axis=0)
            generators[index] = pull / (j + 1.0)  # eq. 15
            updates[index] += 1.0
        generators = surface.project(generators)
        if np.linalg.norm(generators - before, axis=1).max() <= params.still_m:
            break
    return generators


def _nearest_on_plane(points: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Feet on each triangle's plane where they lie in the triangle, infinitely far elsewhere: (N, T, 3)."""
    ab, ac, ap = b - a, c - a, points - a
    d00, d01, d11 = (ab * ab).sum(-1), (ab * ac).sum(-1), (ac * ac).sum(-1)
    d20, d21 = (ap * ab).sum(-1), (ap * ac).sum(-1)
    determinant = d00 * d11 - d01 * d01
    v = (d11 * d20 - d01 * d21) / determinant
    w = (d00 * d21 - d01 * d20) / determinant
    feet: FloatArray = a + v[..., None] * ab + w[..., None] * ac
    inside = (v >= 0.0) & (w >= 0.0) & (v + w <= 1.0)
    feet[~inside] = np.inf
    return feet


def _nearest_on_edge(points: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Nearest points of each edge: (N, T, 3)."""
    along = end - start
    part = np.clip(((points - start) * along).sum(-1) / (along * along).sum(-1), 0.0, 1.0)
    nearest: FloatArray = start + part[..., None] * along
    return nearest
