"""A relief goes through good soundings, smooths poor ones, and knows where it is uncertain."""

from __future__ import annotations

import numpy as np
import pytest

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.relief import Relief


def humps(places: FloatArray) -> FloatArray:
    return -10.0 + 2.0 * np.sin(places[:, 0] / 8.0) + 1.5 * np.cos(places[:, 1] / 11.0)


def lattice(step: float, low: float = 0.0, high: float = 60.0) -> FloatArray:
    axis = np.arange(low, high + 1e-9, step)
    return np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)


def test_it_draws_a_smooth_surface_between_its_soundings() -> None:
    places = lattice(6.0)
    relief = Relief(places, humps(places), np.full(len(places), 0.02))
    between = lattice(6.0, 9.0, 51.0)
    assert np.abs(relief.heights_at(between) - humps(between)).max() < 0.25


def test_it_is_surer_where_it_was_sounded_than_far_away() -> None:
    places = lattice(5.0, 0.0, 30.0)
    relief = Relief(places, humps(places), np.full(len(places), 0.05))
    near, far = relief.sds_at(np.array([[15.0, 15.0], [58.0, 58.0]]))
    assert near < 0.3 * far


@pytest.mark.parametrize("strength", [0.1, 1.0])
def test_its_standard_deviations_are_the_errors_that_it_makes(strength: float) -> None:
    """On surfaces with the roughness that it assumes, half of which was sounded; over many, the errors are as told."""
    shares = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        places = rng.uniform(0.0, 60.0, (300, 2))
        away = np.hypot(*(places[:, None] - places).transpose(2, 0, 1))
        rough = np.exp(-((away / 40.0) ** 1.5)) + 1e-9 * np.eye(len(places))
        truth = -12.0 + strength * np.linalg.cholesky(rough) @ rng.standard_normal(len(places))
        sounded, asked = slice(None, None, 2), slice(1, None, 2)
        relief = Relief(places[sounded], (truth + 0.02 * rng.standard_normal(300))[sounded], np.full(150, 0.02))
        errors = relief.heights_at(places[asked]) - truth[asked]
        shares.append(np.mean((errors / np.hypot(relief.sds_at(places[asked]), 1e-6)) ** 2))
    assert 0.6 < np.sqrt(np.mean(shares)) < 1.4


def test_it_tells_where_the_ground_is_rough() -> None:
    rng = np.random.default_rng(4)
    places = lattice(4.0)
    rough = places[:, 0] > 30.0
    heights = humps(places) + np.where(rough, 0.7, 0.05) * rng.standard_normal(len(places))
    relief = Relief(places, heights, np.full(len(places), 0.03))
    even, uneven = relief.strength_at(np.array([[12.0, 30.0], [48.0, 30.0]]))
    assert uneven > 3.0 * even


def test_rough_ground_is_less_certain_than_smooth_ground_sounded_alike() -> None:
    rng = np.random.default_rng(1)
    places = lattice(4.0)
    rough = places[:, 0] > 30.0
    heights = humps(places) + np.where(rough, 0.7 * rng.standard_normal(len(places)), 0.0)
    relief = Relief(places, heights, np.full(len(places), 0.03))
    smooth_sd, rough_sd = relief.sds_at(np.array([[14.0, 30.0], [46.0, 30.0]]))
    assert rough_sd > 2.0 * smooth_sd


def test_good_soundings_count_more_than_poor_ones_at_the_same_place() -> None:
    places = np.array([[0.0, 0.0], [0.1, 0.0], [30.0, 30.0]])
    relief = Relief(places, np.array([-10.0, -14.0, -10.0]), np.array([0.01, 5.0, 0.01]))
    assert relief.heights_at(np.array([[0.0, 0.0]]))[0] == pytest.approx(-10.0, abs=0.1)


def test_many_places_are_worked_out_as_few_are() -> None:
    places = lattice(10.0)
    relief = Relief(places, humps(places), np.full(len(places), 0.1))
    asked = lattice(1.0, 0.0, 49.0)
    assert np.allclose(relief.heights_at(asked)[:5], relief.heights_at(asked[:5]))
    assert len(relief.heights_at(asked[:0])) == 0


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_nonsense_is_refused(bad: float) -> None:
    places = lattice(30.0)
    heights = humps(places)
    heights[3] = bad
    with pytest.raises(ValueError, match="finite"):
        Relief(places, heights, np.full(len(places), 0.1))
    with pytest.raises(ValueError, match="soundings"):
        Relief(places[:0], heights[:0], heights[:0])
