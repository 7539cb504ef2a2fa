"""What unknown ground is expected to look like beside known ground."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.planning.ground_spline import GroundSpline

RANGE_BLOCKS = 4.0
SHAPE = (30, 24)


def hills() -> FloatArray:
    east, north = np.meshgrid(np.arange(30.0), np.arange(24.0), indexing="ij")
    return 8.0 * np.exp(-((east - 14.0) ** 2 + (north - 9.0) ** 2) / 50.0) + 0.1 * north


def known_west_of(column: int, heights: FloatArray) -> FloatArray:
    known = heights.copy()
    known[column:] = np.nan
    return known


def test_what_is_known_stays_and_the_rest_goes_on_from_it() -> None:
    truth = hills()
    known = known_west_of(12, truth)
    ground = GroundSpline(RANGE_BLOCKS).expect(known)
    assert ground.heights[:12] == pytest.approx(truth[:12])
    beside = slice(12, 14)
    as_the_nearest = np.abs(truth[beside] - truth[11]).mean()
    assert np.abs(ground.heights[beside] - truth[beside]).mean() < 0.3 * as_the_nearest


def test_a_slope_goes_on_and_fades() -> None:
    plane = np.broadcast_to(0.5 * np.arange(30.0)[:, None], SHAPE)
    heights = GroundSpline(RANGE_BLOCKS).expect(known_west_of(10, np.array(plane))).heights
    slopes = np.diff(heights, axis=0)[:, 12]
    assert slopes[9] > 0.35
    assert slopes[9] > slopes[12] > slopes[15]
    assert heights[-1, 12] == pytest.approx(plane[9, 12], abs=3.0)


def test_far_from_what_is_known_ground_is_level() -> None:
    heights = GroundSpline(1.0).expect(known_west_of(10, hills())).heights
    assert heights[16:] == pytest.approx(hills()[:10].mean())


def test_doubt_grows_with_the_distance_from_what_is_known() -> None:
    ground = GroundSpline(RANGE_BLOCKS).expect(known_west_of(10, hills()))
    assert (ground.doubt[:10] == 0.0).all()
    assert (np.diff(ground.doubt[9:, 5]) > 0.0).all()
    assert ground.doubt[-1, 5] > 0.9


def test_of_nothing_known_nothing_is_expected() -> None:
    for known in (np.full(SHAPE, np.nan), known_west_of(1, np.full((30, 8), 3.0))):
        ground = GroundSpline(RANGE_BLOCKS).expect(known)
        assert (ground.heights == 0.0).all()
        assert (ground.doubt == 1.0).all()


def test_one_spline_serves_windows_of_any_shape() -> None:
    spline = GroundSpline(RANGE_BLOCKS)
    whole, part = known_west_of(12, hills()), known_west_of(12, hills())[4:20, :10]
    first = spline.expect(whole).heights
    assert spline.expect(part).heights == pytest.approx(GroundSpline(RANGE_BLOCKS).expect(part).heights)
    assert spline.expect(whole).heights == pytest.approx(first)


@settings(deadline=None)
@given(
    arrays(
        np.float64, st.tuples(st.integers(1, 9), st.integers(1, 9)), elements=st.floats(-50.0, 50.0) | st.just(np.nan)
    )
)
def test_heights_are_finite_and_never_wild(known: FloatArray) -> None:
    ground = GroundSpline(RANGE_BLOCKS).expect(known)
    assert np.isfinite(ground.heights).all()
    assert np.isfinite(ground.stretch)
    assert ground.stretch >= 1.0
    finite = np.isfinite(known)
    if np.count_nonzero(finite) >= 9:
        assert ground.heights[finite] == pytest.approx(known[finite])
        assert np.abs(ground.heights).max() < 50.0 * 40.0
