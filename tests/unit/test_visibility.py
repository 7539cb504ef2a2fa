"""Views over a surface: the quick kernels see what the sensor model sees."""

from __future__ import annotations

import numpy as np
import pytest

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.sensing import visible_surface
from vehicle_agent.domain.visibility import eyes_in_cells, highest, view, weigh_views

GRID = Grid(-20.0, 10.0, 2.0, 40, 30)


def rough(seed: int, unknown: float = 0.0) -> FloatArray:
    rng = np.random.default_rng(seed)
    east, north = np.meshgrid(np.arange(40.0), np.arange(30.0), indexing="ij")
    surface = 8.0 * np.sin(east / 5.0) * np.cos(north / 4.0) + rng.normal(0.0, 1.0, (40, 30))
    surface[rng.random((40, 30)) < unknown] = np.nan
    return surface


def places(seed: int, count: int, surface: FloatArray) -> FloatArray:
    rng = np.random.default_rng(seed)
    points = rng.uniform((-20.0, 10.0, 0.0), (60.0, 70.0, 0.0), (count, 3))
    points[:, 2] = np.nanmax(surface) * rng.uniform(-0.2, 1.5, count)
    return points


@pytest.mark.parametrize("unknown", [0.0, 0.3])
@pytest.mark.parametrize("seed", range(5))
def test_a_view_is_what_the_sensor_sees(seed: int, unknown: float) -> None:
    surface = rough(seed, unknown)
    for east, north, up in places(seed, 40, surface):
        place = (float(east), float(north), float(up))
        seen = np.flatnonzero(view(GRID, surface, place, 22.0))
        np.testing.assert_array_equal(seen, visible_surface(GRID, surface, place, 22.0))


def test_places_on_cell_centres_and_on_the_border_see_what_the_sensor_sees() -> None:
    surface = rough(9)
    for place in [(-20.0, 10.0, 12.0), (60.0, 70.0, 9.0), (-19.0, 11.0, 5.0), (1.0, 31.0, 20.0), (0.0, 30.0, 20.0)]:
        seen = np.flatnonzero(view(GRID, surface, place, 30.0))
        np.testing.assert_array_equal(seen, visible_surface(GRID, surface, place, 30.0))


def test_weights_are_summed_over_what_each_place_sees() -> None:
    surface, rng = rough(3), np.random.default_rng(4)
    weights = np.where(rng.random(GRID.shape) < 0.5, rng.random(GRID.shape), 0.0)
    eyes = places(5, 20, surface)
    sums = weigh_views(surface, eyes_in_cells(GRID, eyes), GRID.cell_m, 22.0, highest(surface), weights)
    expected = [weights[view(GRID, surface, (float(e), float(n), float(u)), 22.0)].sum() for e, n, u in eyes]
    np.testing.assert_allclose(sums, expected)


def test_nothing_is_seen_from_nowhere_and_of_nothing_known() -> None:
    assert not view(GRID, rough(1), (np.nan, 0.0, 0.0), 50.0).any()
    assert not view(GRID, np.full(GRID.shape, np.nan), (0.0, 30.0, 20.0), 50.0).any()
