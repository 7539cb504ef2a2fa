"""Ranges to teammates mend a reckoned position, and nobody ever believes to know it better than it does."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_agent.domain.reckoning import Reckoning, ReckoningParams

PARAMS = ReckoningParams()


class Diver:
    """A vehicle that goes to and fro, its reckoning astray as the parameters say."""

    def __init__(self, middle_m: float, rng: np.random.Generator) -> None:
        self.rng, self.middle_m = rng, middle_m
        self.true_m = np.array([middle_m, 0.0])
        self.reckoning = Reckoning(PARAMS)
        self.fix()

    def fix(self) -> None:
        self.reckoning.fix()
        self.error_m = PARAMS.fixed_sd_m * self.rng.standard_normal(2)
        self.bias_m_s = PARAMS.drift_m_s * self.rng.standard_normal(2)

    def sail(self, time_s: float, dt_s: float) -> None:
        self.true_m = np.array(
            [self.middle_m + 20.0 * math.sin(time_s / 40.0), 50.0 * math.sin(time_s / 97.0 + self.middle_m)]
        )
        step = PARAMS.walk_m_sqrt_s * math.sqrt(dt_s) * self.rng.standard_normal(2)
        self.error_m = self.error_m - self.bias_m_s * dt_s + step
        self.reckoning.advance(dt_s)

    @property
    def reckoned(self) -> tuple[float, float, float]:
        return (float(self.true_m[0] + self.error_m[0]), float(self.true_m[1] + self.error_m[1]), -3.0)

    @property
    def believed(self) -> tuple[float, float, float]:
        east, north, up = self.reckoned
        mend = self.reckoning.correction_m
        return (east + mend[0], north + mend[1], up)

    @property
    def off_m(self) -> float:
        return math.hypot(self.believed[0] - self.true_m[0], self.believed[1] - self.true_m[1])


def dive(seed: int, fix_every_s: float, talks: bool, minutes: int = 15) -> tuple[list[float], list[float]]:
    """Two divers, the first with fixes: the second's errors, and its errors over what it believed them to be."""
    rng = np.random.default_rng(seed)
    divers = (Diver(20.0, rng), Diver(70.0, rng))
    errors, ratios = [], []
    for tick in range(1, minutes * 6 + 1):
        for diver in divers:
            diver.sail(10.0 * tick, 10.0)
        if 10.0 * tick % fix_every_s < 10.0:
            divers[0].fix()
        if talks:
            for diver, mate in (divers, divers[::-1]):
                true_m = math.dist(diver.true_m, mate.true_m)
                measured_m = true_m + (PARAMS.range_sd_m + PARAMS.range_share * true_m) * rng.standard_normal()
                diver.reckoning.hear_range(measured_m, diver.reckoned, mate.believed, mate.reckoning.sd_m)
        errors.append(divers[1].off_m)
        ratios.append(divers[1].off_m / (math.sqrt(2.0) * divers[1].reckoning.sd_m))
    return errors, ratios


@pytest.mark.parametrize("fix_every_s", [60.0, 1e9])
def test_over_many_dives_the_true_error_is_no_greater_than_believed(fix_every_s: float) -> None:
    """With and without a teammate that has fixes; both mend each other again and again, so each hears its own echo."""
    ratios = np.array([dive(seed, fix_every_s, talks=True)[1] for seed in range(60)])
    assert np.sqrt(np.mean(ratios**2, axis=0)).max() < 1.25
    assert np.sqrt(np.mean(ratios**2)) < 1.05
    assert np.mean(ratios > 2.0) < 0.03


def test_a_teammate_with_fixes_keeps_the_error_small() -> None:
    mended, alone = (np.array([dive(seed, 60.0, talks)[0][-1] for seed in range(40)]) for talks in (True, False))
    assert np.sqrt(np.mean(mended**2)) < 0.4 * np.sqrt(np.mean(alone**2))


def test_a_lone_reckoning_grows_as_the_log_drifts() -> None:
    reckoning = Reckoning(PARAMS)
    for _ in range(100):
        reckoning.advance(1.0)
    assert reckoning.sd_m == pytest.approx(math.sqrt(1.0 + 3.0**2 + 0.05**2 * 100.0), rel=1e-3)
    reckoning.fix()
    assert reckoning.sd_m == pytest.approx(1.0)
    assert reckoning.correction_m == (0.0, 0.0)


@settings(max_examples=60, deadline=None)
@given(
    range_m=st.floats(allow_nan=True, allow_infinity=True),
    sd_m=st.floats(allow_nan=True, allow_infinity=True),
    east_m=st.floats(-500.0, 500.0),
    aged_s=st.floats(0.0, 2_000.0),
)
def test_no_range_makes_anybody_less_certain_or_lost(range_m: float, sd_m: float, east_m: float, aged_s: float) -> None:
    reckoning = Reckoning(PARAMS)
    reckoning.advance(aged_s)
    before_m = reckoning.sd_m
    used = reckoning.hear_range(range_m, (0.0, 0.0, -2.0), (east_m, 30.0, -4.0), sd_m)
    assert reckoning.sd_m <= before_m + 1e-9
    assert all(map(math.isfinite, reckoning.correction_m))
    assert used or reckoning.correction_m == (0.0, 0.0)
