"""Legs that are told before they are flown: who waits for whose word, and that nobody then meets."""

from __future__ import annotations

import pytest

from tests.fakes.agent_bench import command
from tests.fakes.bench_team import BenchTeam
from tests.fakes.hill_missions import copters
from tests.fakes.sim_missions import GROUND_M, sim_plan
from vehicle_agent.behaviour.intent import Line, Whereabouts, awaited, within_reach_m
from vehicle_agent.behaviour.units import to_centimetres
from vehicle_agent.planning.constraints import Reservation
from vehicle_agent.wire.messages import Stage, Status, Verb

SINCE_MS, SINCE_S, WITHIN_M, PATIENCE_S = 50_000, 50.0, 100.0, 15.0
LEG: Line = ((0.0, 0.0, 60.0), (50.0, 0.0, 60.0))
SEPARATION_M = 20.0


def mate(east_m: float, stamp_ms: int, heard_at_s: float = 49.0, strayed_m: float = 0.0) -> Whereabouts:
    place = (east_m, 0.0, 60.0)
    return Whereabouts(3, stamp_ms, heard_at_s, ((place, place),), strayed_m)


@pytest.mark.parametrize(
    ("known", "waits"),
    [
        pytest.param(mate(100.0, 49_000), True, id="near, last heard from before"),
        pytest.param(mate(100.0, 50_000), True, id="near, heard from the same moment"),
        pytest.param(mate(100.0, 50_001), False, id="near, heard from after"),
        pytest.param(mate(151.0, 49_000), False, id="too far off to cross"),
        pytest.param(mate(151.0, 49_000, strayed_m=5.0), True, id="far off, but may have come nearer"),
        pytest.param(mate(100.0, 1_000, 64.0), True, id="a clock that lags"),
        pytest.param(mate(100.0, 1_000, 66.0), False, id="a clock that lags, heard long after"),
    ],
)
def test_a_word_from_after_is_awaited_of_those_who_may_cross(known: Whereabouts, waits: bool) -> None:
    assert awaited((LEG,), SINCE_MS, SINCE_S, (known,), WITHIN_M, PATIENCE_S) == [3] * waits


def test_of_two_intents_the_earlier_has_the_way_and_what_is_flown_before_both() -> None:
    flown = Reservation(*LEG, owner_index=2)
    earlier, same, later = (Reservation(*LEG, owner_index=2, since_ms=ms) for ms in (900, 1_000, 1_100))
    assert flown.precedes_intent(1_000, 1)
    assert earlier.precedes_intent(1_000, 1)
    assert not same.precedes_intent(1_000, 1)
    assert same.precedes_intent(1_000, 3)
    assert not later.precedes_intent(1_000, 3)


def crossing_team(delay_s: float, loss: float, seed: int) -> BenchTeam:
    """Two vehicles that are sent at the same moment each to where the other's way leads, before they hear of it."""
    team = copters(((200.0, 200.0), (200.0, 320.0)), range_m=200.0, speed_m_s=15.0, max_above_terrain_m=150.0)
    plan = sim_plan(team=team, safety={"separation_m": SEPARATION_M}, task={"kind": "cover", "step_m": 180.0})
    benches = BenchTeam(plan, delay_s, loss, seed)
    benches.run_until(lambda: all(bench.agent.stage is Stage.WORKING for bench in benches.benches))
    for bench, north_m in zip(benches.benches, (320.0, 200.0), strict=True):
        bench.hear(command(Verb.GO_TO, 1, bench.agent.name, point_cm=to_centimetres((330.0, north_m, 0.0))))
    return benches


@pytest.mark.parametrize("loss", [0.0, 0.3])
@pytest.mark.parametrize("delay_s", [0.0, 1.0, 3.0])
def test_vehicles_that_decide_at_the_same_moment_keep_apart_however_late_they_hear(delay_s: float, loss: float) -> None:
    for seed in range(3):
        team = crossing_team(delay_s, loss, seed)
        team.run_until(lambda team=team: all(bench.agent.stage is Stage.HOLDING for bench in team.benches))
        assert team.closest_m >= SEPARATION_M


def test_with_a_good_radio_a_word_is_answered_at_once() -> None:
    team = crossing_team(0.0, 0.0, 0)
    first = team.benches[0]
    team.run_until(lambda: first.said(Status)[-1].next_end_cm is not None, 5.0)
    told_at_s = first.time_s
    team.run_until(lambda: first.said(Status)[-1].next_end_cm is None, 5.0)
    assert first.time_s - told_at_s <= 1.0  # there and back, a tick each: no regular status was waited for


def test_alone_nobody_waits() -> None:
    team = copters(((200.0, 200.0), (900.0, 900.0)), range_m=200.0, speed_m_s=15.0, max_above_terrain_m=150.0)
    plan = sim_plan(team=team, task={"kind": "cover", "step_m": 180.0})
    assert within_reach_m(plan) < 500.0
    benches = BenchTeam(plan, 3.0)
    benches.run(120.0)
    for bench in benches.benches:
        assert all(s.next_end_cm is None for s in bench.said(Status) if s.stage is Stage.WORKING)
        assert bench.agent.stage is Stage.WORKING
        assert bench.state.position_enu_m[2] > GROUND_M
