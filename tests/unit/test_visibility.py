"""Views over a surface: the quick kernels see what a plain walk along every ray sees."""

from __future__ import annotations

import numpy as np
import pytest

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.sensing import view, visible_surface
from vehicle_agent.domain.visibility import best_view, eyes_in_cells, mark_seen

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


def seen_plainly(surface: FloatArray, place: tuple[float, float, float], range_m: float) -> list[int]:
    """Flat indices of the known cells in range whose ray is above the surface on every grid line that it crosses."""
    (eye,) = eyes_in_cells(GRID, np.array(place))
    seen = []
    for flat in range(GRID.cells):
        column, row = divmod(flat, GRID.rows)
        target = np.array((column, row, surface[column, row]))
        away = (target - eye) * (GRID.cell_m, GRID.cell_m, 1.0)
        if np.linalg.norm(away) <= range_m and ray_is_clear(surface, eye, target):
            seen.append(flat)
    return seen


def ray_is_clear(surface: FloatArray, eye: FloatArray, target: FloatArray) -> bool:
    along = 0 if abs(target[0] - eye[0]) >= abs(target[1] - eye[1]) else 1
    low, high = sorted((eye[along], target[along]))
    for line in range(max(0, int(np.floor(low)) + 1), min(surface.shape[along], int(np.ceil(high)))):
        part = (line - eye[along]) / (target[along] - eye[along])
        if not 1e-9 < part < 1.0 - 1e-9:
            continue
        across, height = (
            eye[1 - along] + part * (target[1 - along] - eye[1 - along]),
            eye[2] + part * (target[2] - eye[2]),
        )
        profile = np.take(surface, line, axis=along)
        cells = np.arange(len(profile))
        near = cells[np.abs(cells - across) < 1e-9]
        ground = profile[near[0]] if len(near) else np.interp(across, cells, profile)
        if ground > height + 1e-9:
            return False
    return True


@pytest.mark.parametrize("unknown", [0.0, 0.3])
@pytest.mark.parametrize("seed", range(5))
def test_a_view_is_what_the_sensor_sees(seed: int, unknown: float) -> None:
    surface = rough(seed, unknown)
    for east, north, up in places(seed, 40, surface):
        place = (float(east), float(north), float(up))
        np.testing.assert_array_equal(visible_surface(GRID, surface, place, 22.0), seen_plainly(surface, place, 22.0))


def test_places_on_cell_centres_and_on_the_border_see_what_the_sensor_sees() -> None:
    surface = rough(9)
    for place in [(-20.0, 10.0, 12.0), (60.0, 70.0, 9.0), (-19.0, 11.0, 5.0), (1.0, 31.0, 20.0), (0.0, 30.0, 20.0)]:
        np.testing.assert_array_equal(visible_surface(GRID, surface, place, 30.0), seen_plainly(surface, place, 30.0))


@pytest.mark.parametrize("seed", range(4))
def test_the_place_whose_view_weighs_most_is_chosen(seed: int) -> None:
    surface, rng = rough(3), np.random.default_rng(seed)
    weights = np.where(rng.random(GRID.shape) < 0.5, rng.integers(1, 9, GRID.shape), 0).astype(np.float64)
    eyes, bonuses = places(5 + seed, 20, surface), rng.normal(0.0, 20.0, 20)
    chosen, weight, first = best_view(surface, eyes_in_cells(GRID, eyes), GRID.cell_m, 22.0, weights, bonuses)
    sums = [weights[view(GRID, surface, (float(e), float(n), float(u)), 22.0)].sum() for e, n, u in eyes]
    assert (chosen, weight, first) == (int(np.argmax(sums + bonuses)), sums[chosen], sums[0])


def test_the_first_of_equal_places_is_chosen() -> None:
    eyes = np.repeat(places(5, 1, rough(3)), 3, axis=0)
    ones = np.ones(GRID.shape)
    assert best_view(rough(3), eyes_in_cells(GRID, eyes), GRID.cell_m, 22.0, ones, np.zeros(3))[0] == 0


def test_what_several_places_see_is_what_each_sees() -> None:
    surface, eyes = rough(3), places(6, 5, rough(3))
    seen = mark_seen(surface, eyes_in_cells(GRID, eyes), GRID.cell_m, 22.0)
    expected = [view(GRID, surface, (float(e), float(n), float(u)), 22.0) for e, n, u in eyes]
    np.testing.assert_array_equal(seen, np.any(expected, axis=0))
    assert not mark_seen(surface, np.empty((0, 3)), GRID.cell_m, 22.0).any()


def test_nothing_is_seen_from_nowhere_and_of_nothing_known() -> None:
    assert not view(GRID, rough(1), (np.nan, 0.0, 0.0), 50.0).any()
    assert not view(GRID, np.full(GRID.shape, np.nan), (0.0, 30.0, 20.0), 50.0).any()
