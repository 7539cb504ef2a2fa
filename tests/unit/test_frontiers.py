"""Frontier cells, their gathering into candidates, and the unseen ground around places."""

from __future__ import annotations

import numpy as np
import pytest

from vehicle_agent.domain.grid import Grid
from vehicle_agent.planning.frontiers import candidate_frontiers, frontier_cells, unknown_around

GRID = Grid(100.0, -50.0, 10.0, 12, 9)


def area() -> np.ndarray:
    return np.ones(GRID.shape, dtype=bool)


def test_frontier_is_the_rim_of_what_is_observed() -> None:
    observed = np.zeros(GRID.shape, dtype=bool)
    observed[3:8, 2:7] = True
    expected = observed.copy()
    expected[4:7, 3:6] = False
    assert np.array_equal(frontier_cells(observed, area()), expected)


def test_the_border_of_the_area_is_no_frontier() -> None:
    observed = np.zeros(GRID.shape, dtype=bool)
    observed[:6, :] = True
    frontier = frontier_cells(observed, area())
    assert np.flatnonzero(frontier.any(axis=1)).tolist() == [5]
    within = area()
    within[6:, :] = False
    assert not frontier_cells(observed, within).any()


def test_no_frontier_before_and_after_everything_is_seen() -> None:
    assert not frontier_cells(np.zeros(GRID.shape, dtype=bool), area()).any()
    assert not frontier_cells(area(), area()).any()


def test_a_diagonal_neighbour_counts() -> None:
    observed = area()
    observed[0, 0] = False
    assert np.argwhere(frontier_cells(observed, area())).tolist() == [[0, 1], [1, 0], [1, 1]]


@pytest.mark.parametrize("block_cells", [1, 2, 3, 5, 50])
def test_candidates_stand_for_every_frontier_cell_once(block_cells: int) -> None:
    frontier = np.random.default_rng(block_cells).random(GRID.shape) < 0.3
    candidates = candidate_frontiers(GRID, frontier, block_cells)
    assert candidates.sizes.sum() == frontier.sum()
    assert frontier.ravel()[candidates.cell_indices].all()
    assert np.allclose(GRID.centres_of(candidates.cell_indices), candidates.points_en_m)
    columns, rows = np.divmod(candidates.cell_indices, GRID.rows)
    blocks = set(zip((columns // block_cells).tolist(), (rows // block_cells).tolist(), strict=True))
    assert len(blocks) == len(candidates)
    all_columns, all_rows = np.nonzero(frontier)
    assert blocks == set(zip((all_columns // block_cells).tolist(), (all_rows // block_cells).tolist(), strict=True))


def test_a_candidate_is_the_cell_nearest_to_the_middle_of_its_block() -> None:
    frontier = np.zeros(GRID.shape, dtype=bool)
    frontier[0:5, 1] = True
    candidates = candidate_frontiers(GRID, frontier, 50)
    assert candidates.points_en_m.tolist() == [list(GRID.centre_of(2, 1))]


def test_no_frontier_gives_no_candidates() -> None:
    assert len(candidate_frontiers(GRID, np.zeros(GRID.shape, dtype=bool), 3)) == 0


def test_unknown_ground_is_counted_in_squares() -> None:
    unknown = np.random.default_rng(0).random(GRID.shape) < 0.5
    for column, row, half_cells in ((0, 0, 2), (5, 4, 1), (11, 8, 3), (6, 2, 20)):
        east_m, north_m = GRID.west_m + column * 10.0, GRID.south_m + row * 10.0  # on a cell's corner
        counted = unknown_around(unknown, GRID, np.array([[east_m, north_m]]), half_cells * 10.0)[0]
        inside = unknown[max(0, column - half_cells) : column + half_cells, max(0, row - half_cells) : row + half_cells]
        assert counted == inside.sum()


def test_far_away_nothing_is_unknown() -> None:
    assert unknown_around(area(), GRID, np.array([[-1e5, 1e5]]), 50.0)[0] == 0
