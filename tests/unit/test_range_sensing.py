"""The noisy range sensor, and maps of Gaussians: estimates are as good as they say."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vehicle_agent.domain.gaussian_map import fit_gaussian_map
from vehicle_agent.domain.landmark_layout import LandmarkParams
from vehicle_agent.domain.range_sensing import RangeSensor, expected_information, heights_from_ranges

SENSOR = RangeSensor(range_m=30.0, noise_share=0.02)
EYE = (0.0, 0.0, 10.0)
PLACES = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, -6.0], [8.0, 8.0]])
HEIGHTS = np.array([-5.0, 0.0, -8.0, 1.0])


def true_ranges() -> np.ndarray:
    return np.linalg.norm(np.column_stack((PLACES, HEIGHTS)) - np.array(EYE), axis=1)


def test_exact_ranges_give_exact_heights_and_looks_from_above_are_best() -> None:
    unknown = np.full(4, np.nan)
    heights, sds = heights_from_ranges(SENSOR, EYE, PLACES, true_ranges(), unknown)
    assert np.allclose(heights, HEIGHTS)
    assert sds[0] == pytest.approx(0.02 * 15.0)
    assert sds[3] > 0.02 * true_ranges()[3]


def test_estimates_are_as_good_as_they_say() -> None:
    rng = np.random.default_rng(1)
    supposed = HEIGHTS + 0.3
    errors = []
    for _ in range(2_000):
        heights, sds = heights_from_ranges(SENSOR, EYE, PLACES, SENSOR.measure(true_ranges(), rng), supposed)
        errors.append((heights - HEIGHTS) / sds)
    assert np.allclose(np.mean(errors, axis=0), 0.0, atol=0.15)
    assert np.allclose(np.std(errors, axis=0), 1.0, atol=0.1)


def test_a_range_shorter_than_the_way_over_ground_tells_nothing() -> None:
    heights, sds = heights_from_ranges(SENSOR, EYE, PLACES[3:], np.array([5.0]), np.array([np.nan]))
    assert np.isnan(heights[0])
    assert np.isnan(sds[0])


def test_noise_grows_with_range_and_with_time_since_a_fix() -> None:
    drifting = RangeSensor(range_m=30.0, noise_share=0.03, drift_m_per_s=0.04)
    assert drifting.noise_sd_m(np.array([10.0])) == pytest.approx(0.3)
    assert drifting.noise_sd_m(np.array([10.0]), unfixed_s=10.0) == pytest.approx(0.5)


def test_what_is_expected_is_what_is_measured() -> None:
    params = LandmarkParams(accurate_sd_m=0.4, best_sd_m=0.1, lowest_m=-20.0, highest_m=20.0)
    away, drop = np.linalg.norm(PLACES, axis=1), EYE[2] - HEIGHTS
    _, sds = heights_from_ranges(SENSOR, EYE, PLACES, true_ranges(), HEIGHTS)
    assert np.allclose(expected_information(SENSOR, params, away, drop), (0.4 / sds) ** 2)
    beam = RangeSensor(range_m=30.0, noise_share=0.02, footprint_m=1.0)
    assert np.count_nonzero(expected_information(beam, params, away, drop)) == 1
    assert np.all(expected_information(SENSOR, params, away, -drop) == 0.0)


@pytest.mark.parametrize(
    "wrong", [{"range_m": 0.0}, {"noise_share": math.nan}, {"footprint_m": -1.0}, {"drift_m_per_s": -0.1}]
)
def test_impossible_sensors_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        RangeSensor(**{"range_m": 1.0, "noise_share": 0.1, **wrong})


def surface(places: np.ndarray) -> np.ndarray:
    return 3.0 * np.sin(places[:, 0] / 6.0) * np.cos(places[:, 1] / 9.0)


def test_a_gaussian_map_is_near_the_surface_and_knows_how_near() -> None:
    rng = np.random.default_rng(2)
    places, points = rng.uniform(0.0, 60.0, (500, 2)), rng.uniform(5.0, 55.0, (400, 2))
    sds = rng.uniform(0.02, 0.2, 500)
    made = fit_gaussian_map(places, surface(places) + sds * rng.standard_normal(500), sds)
    heights, errors_m = made.at(points)
    misfit = heights - surface(points)
    assert np.sqrt(np.mean(misfit**2)) < 0.15
    assert 0.5 < np.sqrt(np.mean((misfit / errors_m) ** 2)) < 2.0
    assert made.at(np.array([[500.0, 500.0]]))[1][0] == pytest.approx(made.spread_m)


def test_a_gaussian_map_needs_landmarks_and_leaves_out_what_is_not_finite() -> None:
    places = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    with pytest.raises(ValueError, match="at least one"):
        fit_gaussian_map(places, np.full(3, np.nan), np.ones(3))
    with pytest.raises(ValueError, match="width_m"):
        fit_gaussian_map(places, np.zeros(3), np.ones(3), width_m=0.0)
    made = fit_gaussian_map(places, np.array([1.0, np.nan, 1.0]), np.array([0.1, 0.1, np.inf]))
    assert len(made.heights_m) == 1
    assert made.at(np.empty((0, 2)))[0].shape == (0,)
