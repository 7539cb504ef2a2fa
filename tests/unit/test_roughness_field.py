"""How rough ground is, from innovations of soundings: even unless they tell otherwise, calibrated when they do."""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.relief import swell_and_roughness
from vehicle_agent.domain.roughness_field import RoughnessField

AXIS = np.arange(2.0, 100.0, 4.0)
NODES: FloatArray = np.stack(np.meshgrid(AXIS, AXIS, indexing="ij"), axis=-1).reshape(-1, 2)
LINES: FloatArray = np.stack(
    np.meshgrid([12.0, 37.0, 62.0, 87.0], np.arange(1.0, 100.0, 2.0), indexing="ij"), axis=-1
).reshape(-1, 2)
NOISE_M = 0.03


def sounded(places: FloatArray, rough_m: FloatArray, seed: int) -> FloatArray:
    """Heights of ground drawn from the prior, as rough as stated at each place."""
    away_m = np.hypot(*(places[:, None] - places).transpose(2, 0, 1))
    _, rough = swell_and_roughness(away_m)
    covariance = rough_m[:, None] * rough_m * rough + NOISE_M**2 * np.eye(len(places))
    drawn = np.linalg.cholesky(covariance) @ np.random.default_rng(seed).standard_normal(len(places))
    return np.asarray(drawn - 12.0)


def told(places: FloatArray, heights_m: FloatArray) -> FloatArray:
    return RoughnessField(places, heights_m, np.full(len(places), NOISE_M), 1.0, NODES).logs_at(NODES)


def test_even_ground_is_told_to_be_even() -> None:
    spreads = [told(LINES, sounded(LINES, np.full(len(LINES), 3.0), seed)).std() for seed in range(3)]
    assert np.mean(spreads) < 0.15


def test_the_rough_half_is_told_by_how_much_it_is_rougher() -> None:
    found = []
    for seed in range(3):
        logs = told(LINES, sounded(LINES, np.where(LINES[:, 1] > 50.0, 3.0, 0.6), seed))
        found.append(logs[NODES[:, 1] > 65.0].mean() - logs[NODES[:, 1] < 35.0].mean())
    assert 0.7 * np.log(5.0) < np.mean(found) < 1.2 * np.log(5.0)


def test_the_unit_of_the_first_guess_does_not_matter() -> None:
    heights_m, sds_m = sounded(LINES, np.where(LINES[:, 1] > 50.0, 3.0, 0.6), 1), np.full(len(LINES), NOISE_M)
    low, high = (RoughnessField(LINES, heights_m, sds_m, guess_m, NODES).logs_at(NODES) for guess_m in (0.3, 15.0))
    assert np.corrcoef(low, high)[0, 1] > 0.95
    assert abs(low.std() - high.std()) < 0.2 * high.std()


def test_one_sounding_and_soundings_of_one_place_tell_no_difference() -> None:
    for places in (np.array([[20.0, 30.0]]), np.array([[20.0, 30.0]] * 3)):
        logs = told(places, np.linspace(-10.0, -10.1, len(places)))
        assert np.isfinite(logs).all()
        assert logs.std() < 0.3


def test_wide_areas_are_carried_by_few_knots() -> None:
    wide = LINES * np.array([20.0, 1.0])
    field = RoughnessField(wide, np.linspace(-9.0, -8.0, len(wide)), np.full(len(wide), 0.1), 1.0, wide)
    assert np.isfinite(field.logs_at(wide)).all()
