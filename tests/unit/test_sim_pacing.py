"""Simulated time keeps pace, catches up gently and does not leap."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim_bridge.pacing import FORGIVEN_S, Pacer

STEP_S = 0.005


def run(pacer: Pacer, times_s: list[float]) -> list[int]:
    return [pacer.steps_due(now_s) for now_s in times_s]


def test_it_keeps_the_pace_when_woken_in_time() -> None:
    pacer = Pacer(STEP_S, started_s=100.0)
    steps = run(pacer, [100.0 + 0.005 * n for n in range(1, 1001)])
    assert sum(steps) in (1000, 1001)
    assert pacer.late_ticks == 0


def test_after_a_short_stall_it_catches_up_at_twice_the_pace() -> None:
    pacer = Pacer(STEP_S, started_s=0.0)
    run(pacer, [0.005 * n for n in range(1, 101)])
    resumed = run(pacer, [0.9] + [0.9 + 0.005 * n for n in range(1, 201)])
    assert max(resumed[1:]) == 2
    assert resumed[-1] == 1
    assert pacer.late_ticks > 0
    assert pacer.forgiven_s == 0.0
    assert pacer.until_next_s(1.9) <= STEP_S


def test_a_long_pause_is_forgiven() -> None:
    pacer = Pacer(STEP_S, started_s=0.0)
    run(pacer, [0.005, 0.01])
    assert pacer.steps_due(3600.0) <= 2 * FORGIVEN_S / STEP_S
    assert pacer.forgiven_s == pytest.approx(3600.0 - FORGIVEN_S, abs=0.1)


def test_a_step_needs_a_length() -> None:
    with pytest.raises(ValueError, match="step_wall_s"):
        Pacer(0.0, 0.0)


@given(gaps_s=st.lists(st.floats(0.0, 30.0), max_size=60), step_s=st.floats(1e-4, 2.0))
def test_simulated_time_never_runs_ahead(gaps_s: list[float], step_s: float) -> None:
    pacer, now_s, done = Pacer(step_s, 0.0), 0.0, 0
    for gap_s in gaps_s:
        now_s += gap_s
        done += pacer.steps_due(now_s)
        assert done * step_s <= now_s + step_s * (1 + 1e-6)
