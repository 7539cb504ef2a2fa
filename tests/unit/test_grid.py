"""The grid: cells, centres and flat indices agree with each other."""

from __future__ import annotations

import numpy as np
import pytest

from vehicle_agent.domain.grid import Grid

GRID = Grid(west_m=-100.0, south_m=50.0, cell_m=10.0, columns=7, rows=4)


def test_flat_index_runs_along_north_first() -> None:
    flat = np.arange(GRID.cells).reshape(GRID.shape)
    column, row = 3, 2
    assert flat[column, row] == column * GRID.rows + row
    assert GRID.centres_of(flat[column, row][None])[0].tolist() == list(GRID.centre_of(column, row))


def test_every_centre_lies_in_its_own_cell() -> None:
    centres = GRID.centres_of(np.arange(GRID.cells))
    cells = [GRID.cell_of(east, north) for east, north in centres]
    assert cells == [(column, row) for column in range(GRID.columns) for row in range(GRID.rows)]


def test_axes_are_the_centres_coordinates() -> None:
    centres = GRID.centres_of(np.arange(GRID.cells)).reshape(*GRID.shape, 2)
    np.testing.assert_array_equal(centres[:, 0, 0], GRID.centres_east_m())
    np.testing.assert_array_equal(centres[0, :, 1], GRID.centres_north_m())


@pytest.mark.parametrize(
    ("east_m", "north_m", "cell"),
    [(-1e9, 60.0, (0, 1)), (1e9, 1e9, (6, 3)), (-100.0, 50.0, (0, 0)), (-30.0, 90.0, (6, 3))],
)
def test_points_outside_give_the_nearest_border_cell(east_m: float, north_m: float, cell: tuple[int, int]) -> None:
    assert GRID.cell_of(east_m, north_m) == cell


@pytest.mark.parametrize("cell_m", [0.1, 0.3, 7.0, 20.0, 33.3])
def test_over_covers_its_rectangle_without_a_spare_row(cell_m: float) -> None:
    grid = Grid.over(-5.0, 3.0, -5.0 + 30 * cell_m, 3.0 + 7.5 * cell_m, cell_m)
    assert grid.shape == (30, 8)


def test_rounding_makes_no_spare_row() -> None:
    assert 3 * 0.1 / 0.1 > 3
    assert Grid.over(0.0, 0.0, 3 * 0.1, 3 * 0.1, 0.1).shape == (3, 3)


def test_a_rectangle_smaller_than_a_cell_has_one() -> None:
    assert Grid.over(0.0, 0.0, 0.1, 0.1, 5.0).shape == (1, 1)


def test_the_border_is_inside() -> None:
    assert GRID.contains(-100.0, 50.0)
    assert GRID.contains(-30.0, 90.0)
    assert not GRID.contains(-30.0001 + 0.001, 90.0)


@pytest.mark.parametrize("cell_m", [0.0, -1.0, float("nan"), float("inf")])
def test_impossible_cells_are_refused(cell_m: float) -> None:
    with pytest.raises(ValueError, match="cell_m"):
        Grid(0.0, 0.0, cell_m, 1, 1)


def test_a_grid_without_cells_is_refused() -> None:
    with pytest.raises(ValueError, match="at least one cell"):
        Grid(0.0, 0.0, 1.0, 0, 5)
