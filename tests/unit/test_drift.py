"""A fix is worth the way up when soundings have become poor enough, and only a stay at the surface gives one."""

from __future__ import annotations

import pytest

from vehicle_agent.behaviour.drift import FIX_TAKES_S, Drift
from vehicle_agent.mission.sounding import DRIFT_M_S
from vehicle_agent.ports import VehicleState

DEEP = VehicleState(stamp_ms=0, position_enu_m=(0.0, 0.0, -3.0))
UP = VehicleState(stamp_ms=0, position_enu_m=(0.0, 0.0, -0.1))


def first_fix_wanted_s(dive_s: float, sound_sd_m: float) -> float:
    drift, now_s = Drift(0.0, dive_s, sound_sd_m), 0.0
    while not drift.is_worth_a_fix():
        now_s += 1.0
        drift.watch(now_s, DEEP)
        assert now_s < 10_000
    return now_s


def test_nobody_surfaces_at_once() -> None:
    drift = Drift(0.0, 10.0, 0.2)
    drift.watch(0.0, DEEP)
    assert not drift.is_worth_a_fix()


def test_dear_fixes_and_rough_sensors_wait_longer() -> None:
    assert first_fix_wanted_s(10.0, 0.1) < first_fix_wanted_s(60.0, 0.1)
    assert first_fix_wanted_s(10.0, 0.1) < first_fix_wanted_s(10.0, 1.0)


def test_the_best_moment_is_where_the_average_over_cycles_is_greatest() -> None:
    """The rule against the brute search over cycle lengths."""
    import math

    dive_s, sd = 12.0, 0.2
    scale = sd / (DRIFT_M_S * 0.1)
    rates = {t: scale * math.atan(t / scale) / (t + dive_s + FIX_TAKES_S) for t in range(1, 2_000)}
    assert abs(first_fix_wanted_s(dive_s, sd) - max(rates, key=rates.__getitem__)) <= 2.0


def test_only_a_stay_at_the_surface_gives_a_fix() -> None:
    drift = Drift(0.0, 10.0, 0.2)
    drift.watch(0.0, DEEP)
    drift.watch(100.0, DEEP)
    drift.watch(101.0, UP)
    assert not drift.has_fix
    assert drift.unfixed_s == pytest.approx(101.0, rel=0.02)  # and the little that the log walks at random
    drift.watch(101.0 + FIX_TAKES_S, UP)
    assert drift.has_fix
    drift.watch(110.0, DEEP)
    assert drift.unfixed_s == pytest.approx(110.0 - 101.0 - FIX_TAKES_S, abs=2.0)


def test_a_place_is_told_for_a_moment_between_two_states() -> None:
    drift = Drift(0.0, 10.0, 0.2)
    for second in range(4):
        place = (1.5 * second, 0.0, -3.0)
        drift.watch(float(second), VehicleState(stamp_ms=1_000 * second, position_enu_m=place))
    assert drift.place_at(1_400) == pytest.approx((2.1, 0.0, -3.0))
    assert drift.place_at(2_000) == pytest.approx((3.0, 0.0, -3.0))
    assert drift.place_at(9_000) == pytest.approx((4.5, 0.0, -3.0))
    assert drift.place_at(-500) == pytest.approx((0.0, 0.0, -3.0))
