"""What nobody can better on a sea floor: slopes that are the error's own, tracks that can be sailed, less error."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from missions.bench.bathymetry_foreknown import Foreknown, anywhere, descend, map_cells, map_error, sailed
from missions.bench.bathymetry_limits import Limit, rows_of
from missions.bench.bathymetry_run import STEP_M, STEPS, VEHICLES, on_floor
from missions.terrain.sea_floor import (
    CELL_M,
    COVARIANCE_CELL_M,
    SIDE_M,
    detail_covariance,
    floor_strength,
    floor_without_detail,
    sea_floor,
)

FEW, MOVED = 60, 12


def scattered(count: int, seed: int) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    return np.random.default_rng(seed).uniform(2.0, SIDE_M - 2.0, (count, 2))


def test_covariance_is_that_of_the_detail_drawn() -> None:
    """Of floors as they are sounded: interpolated halfway between cells as often as on them."""
    covariance = detail_covariance("sharp")
    middles = np.stack(np.meshgrid(*2 * [np.arange(5.0, 95.0, 0.8)], indexing="ij"), axis=-1).reshape(-1, 2)
    for lag_m in (0.0, 2.0, 5.0):
        products = []
        for seed in range(12):
            detail = sea_floor("sharp", seed) - floor_without_detail("sharp", seed)
            detail = detail / floor_strength("sharp", seed)
            products.append(np.mean(on_floor(detail, middles) * on_floor(detail, middles + np.array([lag_m, 0.0]))))
        expected = covariance[round(lag_m / COVARIANCE_CELL_M), 0]
        assert np.mean(products) == pytest.approx(expected, abs=0.08 * covariance[0, 0])


@pytest.mark.parametrize("kind", ["expected", "happened"])
def test_slope_is_how_the_error_changes(kind: str) -> None:
    known = Foreknown("slope", 4)
    known.floor_m = floor_without_detail("slope", 4) + gaussian_filter(
        known.floor_m - floor_without_detail("slope", 4), 4
    )
    known.strength = np.ones_like(known.strength)
    error = known.expected if kind == "expected" else known.happened
    soundings, places = scattered(FEW, 1), map_cells(5, (0, 0))
    slope = known.slope(soundings, places, error(soundings, places)[1])
    within_m = 4.0 * CELL_M / 10.0
    found = np.empty((MOVED, 2))
    for sounding in range(MOVED):
        for axis in (0, 1):
            squares = []
            for way_m in (within_m, -within_m):
                moved = soundings.copy()
                moved[sounding, axis] += way_m
                squares.append(error(moved, places)[0])
            found[sounding, axis] = (squares[0] - squares[1]) / (2.0 * within_m)
    assert np.corrcoef(found.ravel(), slope[:MOVED].ravel())[0, 1] > 0.98
    assert np.abs(found).mean() == pytest.approx(np.abs(slope[:MOVED]).mean(), rel=0.1)


def test_what_is_expected_is_what_happens_on_average() -> None:
    soundings, places = scattered(200, 2), map_cells(4, (0, 0))
    floors = [Foreknown("slope", seed) for seed in range(6)]
    happened = np.mean([floor.happened(soundings, places)[0] for floor in floors])
    expected = np.mean([floor.expected(soundings, places)[0] for floor in floors])
    assert happened == pytest.approx(expected, rel=0.1)


def test_mended_tracks_can_be_sailed() -> None:
    track = sailed(np.random.default_rng(5).uniform(-20.0, 120.0, (VEHICLES * STEPS, 2)))
    for half in np.split(track, VEHICLES):
        assert np.hypot(*np.diff(half, axis=0).T).max() <= STEP_M + 1e-9
    assert track.min() >= 0.0
    assert track.max() <= SIDE_M


def test_descent_lessens_the_error() -> None:
    known, start = Foreknown("sharp", 3), scattered(FEW, 3)
    end = descend(known, known.expected, start, anywhere, 30, 1)
    assert map_error(known.expected, end, 2) < 0.99 * map_error(known.expected, start, 2)


def test_rows_pair_each_error_with_the_lawnmowers() -> None:
    limits = [Limit("sharp", seed, "anywhere", 6.0, lines, 5.0) for seed, lines in ((1, 12.0), (2, 8.0))]
    rows = rows_of(limits)
    assert [(row["method"], row["over_lines"], row["over_more_lines"]) for row in rows] == [("anywhere", 0.625, 1.2)]
