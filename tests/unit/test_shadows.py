"""What clear rays tell of ground that a sensor did not see, and how much unseen ground lies beside a way."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vehicle_agent.domain.elevation import UNOBSERVED_STAMP_MS
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.sensing import visible_surface
from vehicle_agent.domain.shadows import guess_hidden_ground
from vehicle_agent.domain.sweeps import unseen_beside

RANGE_M = 8.0


@pytest.mark.parametrize("seed", range(6))
def test_no_hidden_ground_within_the_range_is_higher_than_the_guess(seed: int) -> None:
    rng = np.random.default_rng(seed)
    grid = Grid(0.0, 0.0, 1.0, 40, 40)
    east, north = np.meshgrid(np.arange(40.0), np.arange(40.0), indexing="ij")
    truth = np.zeros((40, 40))
    for _ in range(4):
        centre, height = rng.uniform(0.0, 40.0, 2), rng.uniform(3.0, 10.0)
        truth += height * np.exp(-((east - centre[0]) ** 2 + (north - centre[1]) ** 2) / 72.0)
    hidden_cells = 0
    for _ in range(30):
        known, guess_m = np.full((40, 40), math.nan), np.full((40, 40), math.inf)
        u, v = rng.uniform(3.0, 36.0, 2)
        eye = (u + 0.5, v + 0.5, float(truth[round(u), round(v)]) + rng.uniform(0.5, 3.0))
        seen = visible_surface(grid, truth, eye, RANGE_M)
        known.ravel()[seen] = truth.ravel()[seen]
        guess_hidden_ground(known, u, v, eye[2], 1.0, RANGE_M, guess_m)
        in_range = (east - u) ** 2 + (north - v) ** 2 + (truth - eye[2]) ** 2 < RANGE_M**2
        hidden = np.isnan(known) & np.isfinite(guess_m) & in_range
        hidden_cells += int(hidden.sum())
        assert (truth[hidden] <= guess_m[hidden]).all()
    assert hidden_cells > 0


def test_behind_a_wall_the_guess_is_its_shadow() -> None:
    known = np.zeros((12, 3))
    known[4:] = math.nan
    known[3] = 2.0
    guess_m = np.full((12, 3), math.inf)
    guess_hidden_ground(known, 0.0, 1.0, 5.0, 1.0, RANGE_M, guess_m)
    assert guess_m[4, 1] == pytest.approx(5.0 - 1.0 * 4.0 + 0.3)
    assert math.isinf(guess_m[11, 1])


def test_unseen_cells_beside_a_way_are_counted_once() -> None:
    first_stamp_ms = np.full((20, 10), UNOBSERVED_STAMP_MS)
    first_stamp_ms[:, :5] = 7
    area = np.ones((20, 10), dtype=bool)
    ends = np.array([[10.0, 5.0], [10.0, 2.0]])
    counts = unseen_beside(first_stamp_ms, area, np.array([5.0, 5.0]), ends, 0.5)
    assert counts.tolist() == [6.0, 1.0]
