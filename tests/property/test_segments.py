"""The distance between two segments against minimisation and dense sampling."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from vehicle_agent.domain.segments import segment_distance_m

coordinates = st.one_of(st.floats(-1e3, 1e3), st.integers(-3, 3).map(float))
points = st.tuples(coordinates, coordinates, coordinates).map(np.array)


@given(points, points, points, points)
@settings(max_examples=300, deadline=None)
def test_distance_is_the_minimum(a0: np.ndarray, a1: np.ndarray, b0: np.ndarray, b1: np.ndarray) -> None:
    distance = segment_distance_m(a0, a1, b0, b1)
    grid = np.linspace(0.0, 1.0, 41)
    on_a, on_b = a0 + grid[:, None] * (a1 - a0), b0 + grid[:, None] * (b1 - b0)
    sampled = np.linalg.norm(on_a[:, None] - on_b[None, :], axis=2).min()
    assert distance <= sampled + 1e-6
    spacing = (np.linalg.norm(a1 - a0) + np.linalg.norm(b1 - b0)) / 80.0
    assert distance >= sampled - spacing - 1e-6
    least = lsq_linear(np.column_stack((a1 - a0, b0 - b1)), b0 - a0, bounds=(0.0, 1.0), tol=1e-12)
    assert distance <= np.sqrt(2.0 * least.cost) + 1e-5


@given(points, points, points, points)
@settings(max_examples=100, deadline=None)
def test_distance_is_symmetric_and_does_not_know_directions(
    a0: np.ndarray, a1: np.ndarray, b0: np.ndarray, b1: np.ndarray
) -> None:
    distance = segment_distance_m(a0, a1, b0, b1)
    for other in (
        segment_distance_m(b0, b1, a0, a1),
        segment_distance_m(a1, a0, b0, b1),
        segment_distance_m(a0, a1, b1, b0),
    ):
        assert abs(distance - other) <= 1e-6


@given(points, points, st.floats(0.0, 1.0))
@settings(max_examples=60, deadline=None)
def test_a_point_on_a_segment_is_at_no_distance(a0: np.ndarray, a1: np.ndarray, part: float) -> None:
    on_it = a0 + part * (a1 - a0)
    assert segment_distance_m(a0, a1, on_it, on_it) <= 1e-6
