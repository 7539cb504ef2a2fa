"""The constrained centroidal Voronoi start."""

from __future__ import annotations

import numpy as np
import pytest

from vehicle_agent.planning.cvt import ApproximateSurface, TessellationParams, tessellate

AREA = (0.0, -50.0, 100.0, 50.0)
KNOWN = np.array([(50.0, 0.0, 30.0), (20.0, -20.0, 5.0), (80.0, 30.0, 12.0), (10.0, 40.0, 0.0)])


def test_known_points_lie_on_the_surface_and_corners_take_the_nearest_height() -> None:
    surface = ApproximateSurface(KNOWN, AREA)
    np.testing.assert_allclose(surface.project(KNOWN), KNOWN, atol=1e-9)
    corner = surface.project(np.array([(0.0, 50.0, 0.0)]))
    np.testing.assert_allclose(corner, [(0.0, 50.0, 0.0)], atol=1e-9)
    assert len(surface.points_enu_m) == len(KNOWN) + 4


def test_a_known_corner_is_believed() -> None:
    surface = ApproximateSurface(np.vstack((KNOWN, (0.0, -50.0, 77.0))), AREA)
    assert len(surface.points_enu_m) == len(KNOWN) + 4
    assert 77.0 in surface.points_enu_m[:, 2]


def test_projection_finds_the_nearest_point() -> None:
    surface, rng = ApproximateSurface(KNOWN, AREA), np.random.default_rng(1)
    dense = surface.sample(60_000, rng)
    for point in rng.uniform((-20.0, -70.0, -30.0), (120.0, 70.0, 80.0), (20, 3)):
        nearest = surface.project(point[None, :])[0]
        assert np.linalg.norm(point - nearest) <= np.linalg.norm(dense - point, axis=1).min() + 1e-9


def test_samples_are_uniform_over_the_area_of_the_surface() -> None:
    """One half is level, the other as steep as one to one: it has the square root of two as much surface."""
    known = np.array([(0.0, -50.0, 0.0), (0.0, 50.0, 0.0), (50.0, -50.0, 0.0), (50.0, 50.0, 0.0)])
    surface = ApproximateSurface(np.vstack((known, (100.0, -50.0, 50.0), (100.0, 50.0, 50.0))), AREA)
    samples = surface.sample(20_000, np.random.default_rng(2))
    share = float((samples[:, 0] > 50.0).mean())
    assert share == pytest.approx(np.sqrt(2.0) / (1.0 + np.sqrt(2.0)), abs=0.02)


def test_generators_are_the_centroids_of_their_cells() -> None:
    surface = ApproximateSurface(KNOWN, AREA)
    params = TessellationParams(samples_per_iteration=4_000, iterations=200, still_m=0.0)
    generators = tessellate(surface, 6, params, np.random.default_rng(3))
    samples = surface.sample(60_000, np.random.default_rng(4))
    nearest = np.linalg.norm(samples[:, None] - generators[None], axis=2).argmin(axis=1)
    for index, generator in enumerate(generators):
        centroid = surface.project(samples[nearest == index].mean(axis=0)[None, :])[0]
        assert np.linalg.norm(centroid - generator) < 2.5
    np.testing.assert_allclose(surface.project(generators), generators, atol=1e-6)


def test_a_tessellation_spreads_a_team_better_than_chance() -> None:
    surface = ApproximateSurface(KNOWN, AREA)
    samples = surface.sample(5_000, np.random.default_rng(5))

    def energy(places: np.ndarray) -> float:
        return float((np.linalg.norm(samples[:, None] - places[None], axis=2).min(axis=1) ** 2).mean())

    for seed in range(5):
        rng = np.random.default_rng(seed)
        by_chance = energy(surface.sample(8, rng))
        assert energy(tessellate(surface, 8, TessellationParams(), rng)) < 0.7 * by_chance


@pytest.mark.parametrize("outside", [(-1.0, 0.0, 0.0), (50.0, 51.0, 0.0), (50.0, 0.0, np.nan)])
def test_points_outside_the_area_are_refused(outside: tuple[float, float, float]) -> None:
    with pytest.raises(ValueError, match="outside the area"):
        ApproximateSurface(np.vstack((KNOWN, outside)), AREA)


def test_something_has_to_be_known() -> None:
    with pytest.raises(ValueError, match="at least one known point"):
        ApproximateSurface(np.empty((0, 3)), AREA)


def test_points_on_one_line_and_twice_the_same_do_no_harm() -> None:
    line = np.column_stack((np.linspace(0.0, 100.0, 9), np.full(9, -50.0), np.arange(9.0)))
    surface = ApproximateSurface(np.vstack((line, line)), AREA)
    generators = tessellate(surface, 4, TessellationParams(), np.random.default_rng(1))
    assert np.isfinite(generators).all()
