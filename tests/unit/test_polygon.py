"""Polygons: inside, distance to the border, and which of them are simple."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.polygon import cells_inside, distance_to_border_m, first_crossing, points_inside

SQUARE = np.array([(0, 0), (10, 0), (10, 10), (0, 10)], dtype=np.float64)
BAY = np.array([(0, 0), (10, 0), (10, 10), (5, 2), (0, 10)], dtype=np.float64)


def test_a_bay_is_outside() -> None:
    points = np.array([(5.0, 1.0), (5.0, 3.0), (1.0, 5.0), (9.0, 5.0), (-1.0, 5.0), (5.0, 11.0)])
    assert points_inside(points, BAY).tolist() == [True, False, True, True, False, False]


def test_direction_of_the_corners_does_not_matter() -> None:
    points = np.random.default_rng(1).uniform(-2, 12, (500, 2))
    np.testing.assert_array_equal(points_inside(points, BAY), points_inside(points, BAY[::-1]))


def test_a_ray_through_a_corner_counts_it_once() -> None:
    diamond = np.array([(0, -5), (5, 0), (0, 5), (-5, 0)], dtype=np.float64)
    assert points_inside(np.array([(-1.0, 0.0), (-6.0, 0.0), (6.0, 0.0)]), diamond).tolist() == [True, False, False]


def test_two_neighbouring_areas_share_no_cell_and_lose_none() -> None:
    grid = Grid(0.0, 0.0, 1.0, 10, 10)
    cut = [(0.5, 0.5), (9.5, 9.5)]
    lower = cells_inside(grid, np.array([(0, 0), (10, 0), (10, 10), *cut[::-1]], dtype=np.float64))
    upper = cells_inside(grid, np.array([(0, 0), *cut, (10, 10), (0, 10)], dtype=np.float64))
    assert not (lower & upper).any()
    assert (lower | upper).all()


def test_cells_are_told_by_column_then_row() -> None:
    grid = Grid(0.0, 0.0, 1.0, 4, 2)
    east_half = np.array([(2, 0), (4, 0), (4, 2), (2, 2)], dtype=np.float64)
    assert cells_inside(grid, east_half).tolist() == [[False] * 2, [False] * 2, [True] * 2, [True] * 2]


def test_distance_to_the_border() -> None:
    points = np.array([(5.0, 5.0), (5.0, 1.0), (13.0, 14.0), (10.0, 3.0)])
    np.testing.assert_allclose(distance_to_border_m(points, SQUARE), [5.0, 1.0, 5.0, 0.0])


@pytest.mark.parametrize(
    ("corners", "crossing"),
    [
        ([(0, 0), (10, 10), (10, 0), (0, 10)], (0, 2)),
        ([(0, 0), (10, 0), (10, 10), (5, 0), (0, 10)], (0, 2)),
        ([(0, 0), (10, 0), (10, 10), (10, 5), (0, 5)], (1, 2)),
        ([(0, 0), (10, 0), (5, 0)], (0, 1)),
        ([(0, 0), (4, 0), (4, 4), (2, 4), (2, 0), (3, 0), (3, -4), (0, -4)], (0, 3)),
        ([(0, 0), (10, 0), (10, 10), (0, 10), (0, 0)], None),
    ],
)
def test_polygons_that_are_not_simple(corners: list[tuple[int, int]], crossing: tuple[int, int] | None) -> None:
    if crossing is None:
        corners = corners[:-1]
    assert first_crossing(np.array(corners, dtype=np.float64)) == crossing


@given(
    st.lists(st.floats(0.0, 6.28), min_size=3, max_size=12, unique_by=lambda angle: round(angle, 3)), st.floats(1, 1e5)
)
def test_star_shaped_polygons_are_simple(angles: list[float], radius_m: float) -> None:
    ordered = np.sort(np.array(angles))
    radii = radius_m * (1.0 + np.arange(len(ordered)) % 2)
    if np.diff(ordered, append=ordered[0] + 2 * np.pi).max() >= 3.1:
        return
    corners = np.column_stack((radii * np.cos(ordered), radii * np.sin(ordered)))
    assert first_crossing(corners) is None
    assert points_inside(np.zeros((1, 2)), corners).all()
