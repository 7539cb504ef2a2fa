"""Steepness of ground: what is known, and what is guessed beside it."""

from __future__ import annotations

import numpy as np
import pytest

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.lane_sight import sight_of, sweep
from vehicle_agent.planning.patches import PatchDivision
from vehicle_agent.planning.steep_ground import ground_steepness

GRID = Grid(0.0, 0.0, 1.0, 80, 60)
DIVISION = PatchDivision(GRID, 2.0, 10_000)
BLOCK_M = np.array([2.0, 2.0])


def steepness_of(surface_m: FloatArray) -> FloatArray:
    return ground_steepness(surface_m, *DIVISION.middle_cells(), BLOCK_M, 8.0)


def test_level_and_unknown_ground_is_like_the_mean() -> None:
    assert steepness_of(np.full(GRID.shape, np.nan)) == pytest.approx(1.0)
    assert steepness_of(np.full(GRID.shape, 7.0)) == pytest.approx(1.0)


def test_steepness_is_the_surface_by_the_map_and_carries_on_beside_what_is_known() -> None:
    surface_m = np.zeros(GRID.shape)
    east = np.arange(GRID.columns)
    surface_m[40:] = (1.5 * (east[40:] - 40))[:, None]
    surface_m[60:] = np.nan
    steepness = steepness_of(surface_m)
    level, steep = steepness[5, 15], steepness[25, 15]
    assert steep / level == pytest.approx(np.sqrt(1.0 + 1.5**2))
    assert steepness[30, 15] == pytest.approx(steep, rel=0.1)
    assert steep > steepness[33, 15] > steepness[39, 15] > level


def test_middle_cells_lie_in_their_patches() -> None:
    division = PatchDivision(GRID, 7.0)
    columns, rows = division.middle_cells()
    for across, column in enumerate(columns):
        for along, row in enumerate(rows):
            inside = division.cells_of(across * division.shape[1] + along)
            assert inside[0].start <= column < inside[0].stop
            assert inside[1].start <= row < inside[1].stop


def test_of_steep_ground_a_lane_shows_a_narrower_strip() -> None:
    sight = sight_of(4.0, (20, 20))
    sight.stretch[:, 10:] = 2.0
    summed = np.zeros((20, 20), dtype=np.int32)
    sweep(sight, np.ones((20, 20)), summed, 2.0, 9.5, 17.0, 9.5, 1)
    assert np.count_nonzero(summed[10, 10:]) < np.count_nonzero(summed[10, :10])
    assert (summed[10, 10:] <= summed[10, 9::-1]).all()
