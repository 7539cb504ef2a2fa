"""The elevation map: first observers, what an observation changes, what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from vehicle_agent.domain.elevation import UNOBSERVED_STAMP_MS, CellObservations, ElevationMap
from vehicle_agent.domain.grid import Grid

GRID = Grid(0.0, 0.0, 10.0, 4, 3)


def seen(indices: list[int], stamp_ms: int, elevation_dm: int = 100) -> CellObservations:
    count = len(indices)
    return CellObservations(
        np.array(indices, dtype=np.int64),
        np.full(count, elevation_dm, dtype=np.int32),
        np.full(count, stamp_ms, dtype=np.int64),
    )


def test_the_earlier_observer_keeps_the_honour() -> None:
    terrain = ElevationMap(GRID)
    terrain.observe(1, seen([0, 1, 2], 2_000))
    changed = terrain.observe(2, seen([1, 2, 3], 1_000))
    assert changed.cell_indices.tolist() == [1, 2, 3]
    assert terrain.first_observer_share(1) == 1.0
    assert terrain.first_observer_share(2) == 3.0


def test_a_tie_is_shared() -> None:
    terrain = ElevationMap(GRID)
    for observer in (0, 5, 63):
        terrain.observe(observer, seen([7], 1_000))
    assert [terrain.first_observer_share(observer) for observer in (0, 5, 63)] == pytest.approx([1 / 3] * 3)


def test_a_share_can_be_counted_within_a_part() -> None:
    terrain = ElevationMap(GRID)
    terrain.observe(0, seen([0, 1, 2, 3], 1_000))
    within = np.zeros(GRID.shape, dtype=np.bool_)
    within[0, :2] = True
    assert terrain.first_observer_share(0, within) == 2.0


def test_a_later_sight_changes_nothing() -> None:
    terrain = ElevationMap(GRID)
    terrain.observe(0, seen([4], 1_000, 50))
    before = terrain.copy()
    assert len(terrain.observe(1, seen([4], 1_001, 10))) == 0
    assert terrain == before


def test_elevation_is_nan_where_nobody_looked() -> None:
    terrain = ElevationMap(GRID)
    terrain.observe(0, seen([GRID.rows], 1_000, -123))
    assert terrain.elevation_m[1, 0] == pytest.approx(-12.3)
    assert np.isnan(terrain.elevation_m).sum() == GRID.cells - 1
    columns, rows = np.array([0, 1]), np.array([0, 1, 2])
    part = terrain.elevation_where(columns, rows)
    assert np.array_equal(part, terrain.elevation_m[np.ix_(columns, rows)], equal_nan=True)


def test_a_copy_lives_its_own_life() -> None:
    terrain = ElevationMap(GRID)
    duplicate = terrain.copy()
    terrain.observe(0, seen([0], 1_000))
    assert not duplicate.observed.any()
    assert duplicate != terrain


@pytest.mark.parametrize(
    ("observer", "observations", "trouble"),
    [
        (64, seen([0], 1), "observer index"),
        (-1, seen([0], 1), "observer index"),
        (0, seen([-1, 0], 1), "outside a grid"),
        (0, seen([0, 12], 1), "outside a grid"),
        (0, seen([0, 40, 2], 1), "increasing"),
        (0, seen([2, 2], 1), "increasing"),
        (0, seen([2], UNOBSERVED_STAMP_MS), "stamp"),
    ],
)
def test_wrong_observations_are_refused_and_change_nothing(
    observer: int, observations: CellObservations, trouble: str
) -> None:
    terrain = ElevationMap(GRID)
    with pytest.raises(ValueError, match=trouble):
        terrain.observe(observer, observations)
    assert terrain == ElevationMap(GRID)


def test_maps_of_different_grids_do_not_merge() -> None:
    with pytest.raises(ValueError, match="different grids"):
        ElevationMap(GRID).merge(ElevationMap(Grid(0.0, 0.0, 10.0, 3, 4)))
