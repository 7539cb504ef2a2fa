"""Heights between blocks, and how long ways over them are."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_agent.domain.expected_ground import ExpectedGround, flown_length, height_at, level_ground

EAST, NORTH = np.meshgrid(np.arange(8.0), np.arange(6.0), indexing="ij")
PLANE = 2.0 + 0.75 * EAST - 0.5 * NORTH
SLOPE = ExpectedGround(PLANE, np.zeros(PLANE.shape), 0.0, 1.0)


@settings(deadline=None)  # the first call compiles
@given(st.floats(0.0, 7.0), st.floats(0.0, 5.0))
def test_heights_of_a_plane_are_its_own(u: float, v: float) -> None:
    assert height_at(PLANE, u, v) == pytest.approx(2.0 + 0.75 * u - 0.5 * v)


@settings(deadline=None)
@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6))
def test_beside_the_ground_it_is_as_high_as_at_its_edge(u: float, v: float) -> None:
    assert height_at(PLANE, u, v) == pytest.approx(2.0 + 0.75 * min(max(u, 0.0), 7.0) - 0.5 * min(max(v, 0.0), 5.0))


def test_a_way_up_is_longer_than_one_along_the_slope() -> None:
    along = np.array((0.5, 0.75)) / math.hypot(0.5, 0.75)
    start = np.array((2.0, 1.0))
    assert flown_length(SLOPE, start, start + 3.0 * along) == pytest.approx(3.0)
    assert flown_length(SLOPE, start, start + np.array((4.0, 0.0))) == pytest.approx(5.0)


def test_slopes_that_are_unknown_make_ways_longer_all_alike() -> None:
    ground = level_ground((8, 6))._replace(slope_squared=3.0, stretch=1.6)
    for end in ((6.0, 1.0), (2.0, 5.0)):
        flat = math.dist((2.0, 1.0), end)
        assert flown_length(ground, np.array((2.0, 1.0)), np.array(end)) == pytest.approx(2.0 * flat / 1.6)


def test_one_row_of_blocks_has_heights_too() -> None:
    assert height_at(np.array([[1.0, 3.0]]), 5.0, 0.5) == pytest.approx(2.0)
    assert height_at(np.array([[4.0]]), 0.0, 0.0) == 4.0
