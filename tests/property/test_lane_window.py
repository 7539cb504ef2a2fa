"""What a plan of lanes is for is the nearest of what is unseen, and as much as was asked for."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.lane_window import Window, window_around

PLACE = st.tuples(st.floats(-3.0, 25.0), st.floats(-3.0, 25.0))


def spread_out(window: Window, shape: tuple[int, int]) -> FloatArray:
    """What a plan is for, over all blocks."""
    wanted = np.zeros(shape)
    wanted[window.columns, window.rows] = window.unseen
    return wanted


@given(st.integers(0, 2**32 - 1), st.lists(PLACE, min_size=1, max_size=4), st.floats(0.1, 300.0))
def test_a_window_holds_the_nearest_and_enough(seed: int, places: list[tuple[float, float]], most: float) -> None:
    rng = np.random.default_rng(seed)
    shape = (int(rng.integers(2, 24)), int(rng.integers(2, 24)))
    unseen = rng.random(shape) * (rng.random(shape) < rng.random())
    vehicles = np.array(places)
    window = window_around(unseen, vehicles, most)
    wanted = spread_out(window, shape)
    taken = wanted > 0.0
    assert np.array_equal(wanted[taken], unseen[taken])
    assert wanted.sum() >= min(most, unseen.sum()) - 1e-9
    assert window.is_all == (unseen.sum() <= most)
    columns, rows = np.indices(shape)
    apart = np.min([np.hypot(columns - u, rows - v) for u, v in vehicles], axis=0)
    rings = apart.astype(int)
    left = (unseen > 0.0) & ~taken
    if taken.any() and left.any():
        assert rings[taken].max() < rings[left].min()
        assert unseen[rings < rings[taken].max()].sum() < most
    for u, v in np.rint(vehicles):
        assert window.columns.start <= min(max(u, 0), shape[0] - 1) < window.columns.stop
        assert window.rows.start <= min(max(v, 0), shape[1] - 1) < window.rows.stop
