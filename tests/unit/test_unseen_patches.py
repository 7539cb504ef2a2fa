"""Unseen ground counted by patch as the map grows, and ways found without looking at all of it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vehicle_agent.domain.elevation import CellObservations, ElevationMap
from vehicle_agent.domain.grid import Grid, IndexArray
from vehicle_agent.domain.paths import nearest_known_cell, travel_distances
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.planning.patches import PatchDivision, Stops, UnseenPatches
from vehicle_agent.planning.travel import _shortest_way

GRID = Grid(-20.0, 30.0, 2.0, 23, 31)


def observe(team_map: ElevationMap, cells: IndexArray, observer: int = 0) -> None:
    team_map.observe(observer, CellObservations(cells, np.zeros(len(cells), dtype=np.int32), 5 + cells))


def check(unseen: UnseenPatches, division: PatchDivision, team_map: ElevationMap, area: BoolArray) -> None:
    for number in range(division.shape[0] * division.shape[1]):
        columns, rows = division.cells_of(number)
        cells = np.argwhere((area & ~team_map.observed)[columns, rows])
        assert unseen.unseen_in(number) == len(cells)
    stops = unseen.stops(set(), 6.0, 0.0, 0.0)
    assert unseen.any_left(set()) == bool(len(stops))
    left = np.argwhere(area & ~team_map.observed)
    middles = np.array([GRID.centre_of(*cell) for cell in left]).reshape(-1, 2)
    away_m = np.hypot(*(middles[:, None, :] - stops.places_en_m[None, :, :]).transpose(2, 0, 1))
    assert stops.unseen.sum() == (away_m <= 6.0 + 1e-9).any(axis=1).sum()  # each cell counts for one stop
    assert np.all(np.diff(stops.numbers) > 0)


def test_counts_follow_a_growing_map_and_begin_anew_with_another_map_or_area() -> None:
    rng = np.random.default_rng(4)
    area = rng.random(GRID.shape) < 0.8
    division = PatchDivision(GRID, 9.0)
    unseen, team_map = UnseenPatches(division), ElevationMap(GRID)
    observe(team_map, np.arange(40))
    for observer in range(4):
        unseen.follow(team_map, area)
        check(unseen, division, team_map, area)
        observe(team_map, np.sort(rng.choice(GRID.cells, 60, replace=False)), observer)
    other = ElevationMap(GRID)
    observe(other, np.arange(90, 200))
    team_map.merge(other)
    unseen.follow(team_map, area)
    check(unseen, division, team_map, area)
    smaller = area & (rng.random(GRID.shape) < 0.5)
    for followed, cells in ((team_map, smaller), (other, smaller), (team_map.copy(), area)):
        unseen.follow(followed, cells)
        check(unseen, division, followed, cells)
    loaded = ElevationMap.of_arrays(GRID, team_map.arrays())
    unseen.follow(loaded, area)
    observe(loaded, np.arange(GRID.cells))
    unseen.follow(loaded, area)
    check(unseen, division, loaded, area)
    assert np.array_equal(np.sort(loaded.observed_since(0)), np.arange(GRID.cells))


def stops_of_line(unseen_columns: list[int], radius_m: float, remnant: float, beside_m: float) -> Stops:
    """Stops on a strip of 60 x 5 metres in patches of 5 x 5, where only some columns are unseen."""
    grid = Grid(0.0, 0.0, 1.0, 60, 5)
    area = np.ones(grid.shape, dtype=np.bool_)
    team_map = ElevationMap(grid)
    observe(team_map, np.flatnonzero(~np.isin(np.arange(grid.cells) // grid.rows, unseen_columns)))
    unseen = UnseenPatches(PatchDivision(grid, 5.0))
    unseen.follow(team_map, area)
    return unseen.stops(set(), radius_m, remnant, beside_m)


def test_what_the_stop_of_one_patch_shows_needs_no_other() -> None:
    stops = stops_of_line([10, 11, 12, 13, 14, 15, 21], 4.0, 0.0, 0.0)
    assert stops.numbers.tolist() == [2, 4]  # column 15 lies in patch 3, and is seen from patch 2
    assert stops.places_en_m[0] == pytest.approx((12.5, 2.5))
    assert stops.unseen.tolist() == [30, 5]


def test_the_middle_is_that_of_what_no_stop_has_shown_yet() -> None:
    stops = stops_of_line([10, 11, 12, 13, 14, 15, 16, 19], 4.0, 0.0, 0.0)
    assert stops.numbers.tolist() == [2, 3]
    assert stops.places_en_m[1, 0] > 16.5  # the first stop shows a part of columns 15 and 16


def test_a_remnant_is_a_stop_only_where_no_other_stop_is_near() -> None:
    assert stops_of_line([10, 11, 12, 13, 14, 19, 40], 3.0, 10.0, 8.0).numbers.tolist() == [2, 8]
    assert stops_of_line([10, 11, 12, 13, 14, 19, 40], 3.0, 10.0, 4.0).numbers.tolist() == [2, 3, 8]


def test_a_patch_given_up_is_no_stop() -> None:
    grid = Grid(0.0, 0.0, 1.0, 10, 5)
    area = np.ones(grid.shape, dtype=np.bool_)
    unseen = UnseenPatches(PatchDivision(grid, 5.0))
    unseen.follow(ElevationMap(grid), area)
    assert unseen.stops({0}, 2.0, 0.0, 0.0).numbers.tolist() == [1]
    assert not unseen.any_left({0, 1})
    assert len(unseen.stops({0, 1}, 2.0, 0.0, 0.0)) == 0


def test_the_nearest_known_cell_is_that_of_a_search_through_all() -> None:
    rng = np.random.default_rng(8)
    for _ in range(200):
        surface = np.where(rng.random((9, 14)) < 0.08, 1.0, math.nan)
        column, row = int(rng.integers(9)), int(rng.integers(14))
        known = np.argwhere(~np.isnan(surface))
        if len(known) == 0:
            assert nearest_known_cell(surface, column, row) == (-1, -1)
        else:
            best = known[np.argmin((known[:, 0] - column) ** 2 + (known[:, 1] - row) ** 2)]
            assert nearest_known_cell(surface, column, row) == tuple(best)


def test_a_way_found_nearby_is_as_short_as_one_looked_for_everywhere() -> None:
    rng = np.random.default_rng(2)
    for density in (0.5, 0.7, 0.9):
        for _ in range(20):
            surface = np.where(rng.random((60, 50)) < density, 1.0, math.nan)
            surface[20:40, 24] = math.nan  # a wall to go round
            start, goal = (30, 20), (int(rng.integers(60)), int(rng.integers(50)))
            surface[start] = 1.0
            cells, length = _shortest_way(surface, start, goal)
            distances, _ = travel_distances(~np.isnan(surface), *start, -1, -1)
            reached = np.argwhere(np.isfinite(distances))
            best = reached[np.argmin((reached[:, 0] - goal[0]) ** 2 + (reached[:, 1] - goal[1]) ** 2)]
            assert cells[0] == start
            assert cells[-1] == tuple(best)
            assert length == pytest.approx(distances[tuple(best)])


def test_middle_cells_lie_in_their_patches() -> None:
    division = PatchDivision(GRID, 7.0)
    columns, rows = division.middle_cells()
    for across, column in enumerate(columns):
        for along, row in enumerate(rows):
            inside = division.cells_of(across * division.shape[1] + along)
            assert inside[0].start <= column < inside[0].stop
            assert inside[1].start <= row < inside[1].stop
