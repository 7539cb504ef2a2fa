"""Legs over a known surface, shortest ways and the surface assumed where none is known."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.ndimage import map_coordinates
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from vehicle_agent.domain.clearance import leg_clearances
from vehicle_agent.domain.paths import assumed_surface, trace_way, travel_distances

CELL_M = 20.0


def clearance(elevation: np.ndarray, start: tuple[float, ...], end: tuple[float, ...]) -> float:
    """Of one leg in metres; the grid's corner is at the origin."""
    return float(leg_clearances(elevation, 0.0, 0.0, CELL_M, np.array(start), np.array([end]))[0])


def densely(elevation: np.ndarray, start: np.ndarray, ends: np.ndarray, samples: int = 2_000) -> np.ndarray:
    parts = np.linspace(0.0, 1.0, samples)[None, :, None]
    points = start + parts * (ends[:, None, :] - start)
    ground = map_coordinates(elevation, np.moveaxis(points[..., :2], -1, 0) / CELL_M - 0.5, order=1, mode="nearest")
    return (points[..., 2] - ground).min(axis=1)


@pytest.mark.parametrize("seed", range(6))
def test_clearance_is_that_of_the_bilinear_surface(seed: int) -> None:
    rng = np.random.default_rng(seed)
    elevation = rng.uniform(0.0, 100.0, (12, 9))
    low, high = np.array([0.5 * CELL_M] * 2), np.array([11.5 * CELL_M, 8.5 * CELL_M])
    start = np.array([*rng.uniform(low, high), 80.0])
    ends = np.column_stack((rng.uniform(low, high, (200, 2)), rng.uniform(0.0, 200.0, 200)))
    exact = leg_clearances(elevation, 0.0, 0.0, CELL_M, start, ends)
    sampled = densely(elevation, start, ends)
    assert np.all(exact <= sampled + 1e-9)
    assert np.all(exact >= sampled - 0.5)  # what 2000 samples miss at most on 220 m of such ground


def test_a_peak_that_is_only_clipped_counts() -> None:
    elevation = np.zeros((6, 6))
    elevation[3, 3] = 100.0
    # The leg crosses the corner of the square that has the peak on its far side.
    start, end = (2.3 * CELL_M + 10.0, 1.8 * CELL_M + 10.0, 50.0), (1.8 * CELL_M + 10.0, 2.3 * CELL_M + 10.0, 50.0)
    assert clearance(elevation, start, end) < 49.8
    assert clearance(elevation, start, end) == pytest.approx(
        densely(elevation, np.array(start), np.array([end]))[0], abs=1e-4
    )


def test_the_parabola_between_two_diagonal_hills_is_found() -> None:
    saddle = np.array([[0.0, 40.0], [40.0, 0.0]])
    # Along this diagonal both ends are at height 0 and the middle is at 20 m.
    assert clearance(saddle, (10.0, 10.0, 30.0), (30.0, 30.0, 30.0)) == pytest.approx(10.0)


def test_unknown_ground_is_not_crossed_but_may_be_left() -> None:
    elevation = np.zeros((10, 4))
    elevation[4:6, :] = math.nan
    west, middle, east = (30.0, 40.0, 50.0), (100.0, 40.0, 50.0), (170.0, 40.0, 50.0)
    assert math.isnan(clearance(elevation, west, east))
    assert math.isnan(clearance(elevation, west, middle))
    assert math.isnan(clearance(elevation, middle, middle))
    assert clearance(elevation, middle, east) == 50.0
    assert clearance(elevation, west, (70.0, 40.0, 20.0)) == 20.0


def test_from_deep_in_the_unknown_a_leg_leads_to_its_rim_only() -> None:
    elevation = np.zeros((20, 4))
    elevation[4:12, :] = math.nan
    deep, rim, beyond = (190.0, 40.0, 50.0), (250.0, 40.0, 50.0), (370.0, 40.0, 50.0)
    assert clearance(elevation, deep, rim) == 50.0
    assert math.isnan(clearance(elevation, deep, beyond))
    assert clearance(elevation, (245.0, 40.0, 50.0), beyond) == 50.0


def test_the_rims_own_centre_is_known_ground() -> None:
    elevation = np.zeros((20, 4))
    elevation[4:12, :] = math.nan
    assert math.isnan(clearance(elevation, (70.0, 30.0, 50.0), (250.0, 30.0, 50.0)))
    assert clearance(elevation, (180.0, 35.0, 50.0), (250.0, 30.0, 50.0)) == 50.0


def test_beyond_the_outermost_centres_there_is_no_way_but_back() -> None:
    elevation = np.zeros((5, 5))
    inside = (50.0, 50.0, 30.0)
    for outside in ((50.0, 95.0, 30.0), (5.0, 50.0, 30.0), (500.0, 50.0, 30.0), (50.0, -300.0, 30.0)):
        assert math.isnan(clearance(elevation, inside, outside))
        nearest = (min(max(outside[0], 10.0), 90.0), min(max(outside[1], 10.0), 90.0), 30.0)
        assert clearance(elevation, outside, nearest) == 30.0
    for border in ((10.0, 50.0, 30.0), (90.0, 90.0, 30.0), (50.0, 10.0, 30.0)):
        assert clearance(elevation, inside, border) == 30.0


def test_a_point_on_a_cells_centre_needs_no_neighbours() -> None:
    elevation = np.full((3, 3), math.nan)
    elevation[1, 1] = 7.0
    assert clearance(elevation, (30.0, 30.0, 10.0), (30.0, 30.0, 25.0)) == pytest.approx(3.0)


@pytest.mark.parametrize("bad", [math.nan, math.inf, 1e30])
def test_a_leg_to_nowhere_has_no_clearance(bad: float) -> None:
    elevation = np.zeros((5, 5))
    for axis in range(2 if bad == 1e30 else 3):
        end = [50.0, 50.0, 30.0]
        end[axis] = bad
        assert math.isnan(clearance(elevation, (50.0, 50.0, 30.0), tuple(end)))
        assert math.isnan(clearance(elevation, tuple(end), (50.0, 50.0, 30.0)))


@pytest.mark.parametrize("seed", range(4))
def test_shortest_ways_are_those_of_scipy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    passable = rng.random((13, 17)) < 0.7
    passable[2, 3] = True
    distances, parents = travel_distances(passable, 2, 3, -1, -1)
    rows = passable.shape[1]
    links = [
        (c * rows + r, (c + dc) * rows + r + dr, math.hypot(dc, dr))
        for c, r in np.argwhere(passable)
        for dc in (-1, 0, 1)
        for dr in (-1, 0, 1)
        if (dc or dr)
        and 0 <= c + dc < passable.shape[0]
        and 0 <= r + dr < rows
        and passable[c + dc, r + dr]
        and passable[c + dc, r]
        and passable[c, r + dr]
    ]
    starts, ends, weights = zip(*links, strict=True)
    graph = coo_matrix((weights, (starts, ends)), shape=(passable.size, passable.size))
    expected = dijkstra(graph, indices=2 * rows + 3).reshape(passable.shape)
    assert np.allclose(distances, expected)
    for column, row in np.argwhere(np.isfinite(distances)):
        way = trace_way(parents, int(column), int(row))
        assert way[0] == (2, 3)
        assert way[-1] == (column, row)
        assert sum(math.dist(a, b) for a, b in itertools.pairwise(way)) == pytest.approx(distances[column, row])
        assert all(passable[cell] for cell in way)


def test_unknown_ground_beside_known_is_assumed_to_rise_steeply() -> None:
    elevation = np.full((7, 7), math.nan)
    elevation[0, :] = 10.0
    elevation[0, 6] = 50.0
    surface = assumed_surface(elevation, np.ones((7, 7), dtype=bool), CELL_M, 2, 1.5)
    assert surface[0, 0] == 10.0
    assert surface[1, 0] == 40.0
    assert surface[2, 0] == 70.0
    assert np.all(np.isnan(surface[3:, :]))
    assert surface[1, 5] == 80.0  # from the highest neighbour
    assert np.isnan(elevation[1, 0])


def test_the_assumed_surface_ends_at_the_fence() -> None:
    allowed = np.ones((4, 4), dtype=bool)
    allowed[3, :] = False
    surface = assumed_surface(np.zeros((4, 4)), allowed, CELL_M, 2, 1.5)
    assert np.all(np.isnan(surface[3, :]))
    assert np.all(surface[:3, :] == 0.0)
