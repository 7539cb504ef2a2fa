"""When the charge that is left calls a vehicle home."""

from __future__ import annotations

from vehicle_agent.behaviour.energy import DETOUR, STUCK_S, EnergyWatch, Headway


def watched(drain_per_s: float, until_s: float) -> EnergyWatch:
    watch = EnergyWatch(reserve=0.15)
    for second in range(int(until_s) + 1):
        watch.note(1e9 + second, 0.9 - drain_per_s * second)
    return watch


def test_an_unknown_charge_calls_nobody_home() -> None:
    watch = EnergyWatch(0.15)
    watch.note(0.0, None)
    assert not watch.must_return(None, 1e9)


def test_the_reserve_alone_counts_until_the_drain_is_known() -> None:
    watch = watched(0.001, 5.0)
    assert not watch.must_return(0.16, 1e6)
    assert watch.must_return(0.15, 0.0)


def test_the_way_home_is_reckoned_with_a_detour() -> None:
    watch = watched(0.001, 100.0)
    needed = 0.001 * DETOUR * 200.0
    assert watch.must_return(0.15 + needed - 1e-6, 200.0)
    assert not watch.must_return(0.15 + needed + 1e-3, 200.0)


def test_a_charge_that_rises_is_no_reason_to_fear_or_hope() -> None:
    watch = watched(-0.001, 100.0)
    assert not watch.must_return(0.2, 1e6)
    assert watch.must_return(0.1, 0.0)


def test_who_comes_no_nearer_for_a_while_is_stuck() -> None:
    headway = Headway()
    headway.begin(1_000.0)
    assert not headway.is_stuck(1_000.0 + STUCK_S, 300.0)
    assert not headway.is_stuck(1_000.0 + 2.0 * STUCK_S, 299.5)
    assert headway.is_stuck(1_000.1 + 2.0 * STUCK_S, 299.5)
    assert not headway.is_stuck(1_001.0 + 2.0 * STUCK_S, 280.0)
    headway.begin(2_000.0)
    assert not headway.is_stuck(2_001.0, 400.0)
