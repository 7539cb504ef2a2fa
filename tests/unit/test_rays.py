"""Line of sight where the answer is known by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.sensing import visible_surface

GRID = Grid(0.0, 0.0, 10.0, 9, 9)
LEVEL = np.zeros(GRID.shape)
MIDDLE = (45.0, 45.0)


def seen(elevation_m: np.ndarray, position: tuple[float, float, float], range_m: float) -> set[tuple[int, int]]:
    return {divmod(int(flat), GRID.rows) for flat in visible_surface(GRID, elevation_m, position, range_m)}


def test_over_level_ground_all_within_range_is_seen() -> None:
    for range_m in (15.0, 23.0, 40.0, 200.0):
        expected = {
            (column, row)
            for column in range(9)
            for row in range(9)
            if math.dist((*GRID.centre_of(column, row), 0.0), (*MIDDLE, 10.0)) <= range_m
        }
        assert seen(LEVEL, (*MIDDLE, 10.0), range_m) == expected


def test_a_cell_exactly_at_the_range_is_seen() -> None:
    assert (7, 4) in seen(LEVEL, (*MIDDLE, 40.0), 50.0)  # 30 m east, 40 m below
    assert (7, 4) not in seen(LEVEL, (*MIDDLE, 40.0), 49.999)


def test_range_counts_in_space_and_not_over_ground() -> None:
    assert seen(LEVEL, (*MIDDLE, 30.0), 29.0) == set()
    assert seen(LEVEL, (*MIDDLE, 30.0), 30.0) == {(4, 4)}


def test_a_wall_hides_what_lies_behind_it_and_shows_itself() -> None:
    walled = LEVEL.copy()
    walled[6, :] = 100.0
    visible = seen(walled, (*MIDDLE, 20.0), 1_000.0)
    assert {(6, row) for row in range(9)} <= visible
    assert not {(column, row) for column in (7, 8) for row in range(9)} & visible
    assert {(column, row) for column in range(6) for row in range(9)} <= visible


def test_from_high_enough_the_wall_hides_nothing() -> None:
    walled = LEVEL.copy()
    walled[6, :] = 100.0
    assert len(seen(walled, (*MIDDLE, 1_000.0), 5_000.0)) == GRID.cells


@pytest.mark.parametrize("turn", [1, 2, 3])
def test_quarter_turns_of_the_terrain_turn_what_is_seen(turn: int) -> None:
    rough = np.random.default_rng(4).uniform(0.0, 40.0, GRID.shape)
    here = np.zeros(GRID.shape, dtype=bool)
    here.ravel()[visible_surface(GRID, rough, (*MIDDLE, 35.0), 60.0)] = True
    turned = np.zeros(GRID.shape, dtype=bool)
    turned.ravel()[visible_surface(GRID, np.rot90(rough, turn), (*MIDDLE, 35.0), 60.0)] = True
    assert np.array_equal(np.rot90(here, turn), turned)


def test_a_viewer_below_the_ground_sees_no_further_than_the_neighbours() -> None:
    assert seen(LEVEL, (*MIDDLE, -30.0), 1_000.0) <= {(c, r) for c in (3, 4, 5) for r in (3, 4, 5)}


def test_a_viewer_on_a_cells_edge_sees_both_sides_alike() -> None:
    rough = np.zeros(GRID.shape)
    rough[2, :] = rough[7, :] = 30.0  # mirror images about the edge between columns 4 and 5
    visible = seen(rough, (50.0, 45.0, 20.0), 1_000.0)
    assert (2, 4) in visible
    assert (7, 4) in visible
    assert (1, 4) not in visible
    assert (8, 4) not in visible


def test_a_viewer_outside_the_grid_sees_into_it() -> None:
    walled = LEVEL.copy()
    walled[3, :] = 100.0
    visible = seen(walled, (-200.0, 45.0, 20.0), 1_000.0)
    assert (0, 4) in visible
    assert (3, 4) in visible
    assert (4, 4) not in visible
    assert seen(LEVEL, (-200.0, 45.0, 20.0), 100.0) == set()


def test_unknown_cells_are_not_seen_and_hide_nothing() -> None:
    holed = LEVEL.copy()
    holed[5:7, :] = math.nan
    visible = seen(holed, (*MIDDLE, 10.0), 1_000.0)
    assert visible == {(c, r) for c in range(9) for r in range(9) if c not in (5, 6)}


def test_an_unknown_neighbour_does_not_open_a_known_wall() -> None:
    walled = LEVEL.copy()
    walled[6, 4] = 100.0
    walled[6, 5] = math.nan
    assert (8, 4) not in seen(walled, (*MIDDLE, 10.0), 1_000.0)


def test_straight_down_nothing_is_in_the_way() -> None:
    pit = np.full(GRID.shape, 50.0)
    pit[4, 4] = 0.0
    assert (4, 4) in seen(pit, (*MIDDLE, 60.0), 1_000.0)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_from_nowhere_nothing_is_seen(bad: float, axis: int) -> None:
    position = [45.0, 45.0, 20.0]
    position[axis] = bad
    assert len(visible_surface(GRID, LEVEL, (position[0], position[1], position[2]), 100.0)) == 0
