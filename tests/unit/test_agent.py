"""The agent's life against a scripted autopilot: who steers, what it orders, what it says, and when it gives way."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.fakes.agent_bench import AgentBench, command, flight_orders, working
from tests.fakes.sim_missions import GROUND_M, sim_plan
from tests.fakes.talking_fleet import Voice
from vehicle_agent.behaviour.authority import YIELD_AFTER_S
from vehicle_agent.behaviour.map_exchange import encode_record
from vehicle_agent.domain.elevation import CellObservations
from vehicle_agent.ports import (
    Arm,
    FlightMode,
    GoTo,
    Land,
    Landed,
    SensorScan,
    SetParameter,
    TakeOff,
)
from vehicle_agent.wire.messages import (
    Claim,
    Digest,
    Event,
    MapDelta,
    Repair,
    Stage,
    Status,
    Verb,
)

FLYING = (150.0, 200.0, 90.0)


# A whole life


def test_a_mission_from_connecting_to_done() -> None:
    bench = AgentBench(sim_plan(vehicles=1, stop={"observed_fraction": 0.9}))
    bench.run_until(Stage.DONE)
    assert bench.agent.finished
    assert bench.stages_told() == [
        Stage.CONFIGURING,
        Stage.ARMING,
        Stage.TAKING_OFF,
        Stage.WORKING,
        Stage.RETURNING,
        Stage.LANDING,
        Stage.DONE,
    ]
    names = [order.name for order in bench.orders(SetParameter)]
    assert names.index("SYSID_MYGCS") < names.index("FS_GCS_ENABLE")
    first_arm = next(n for n, action in enumerate(bench.actions) if isinstance(action.order, Arm))
    last_check = max(n for n, a in enumerate(bench.actions[:first_arm]) if isinstance(a.order, SetParameter))
    assert last_check < first_arm
    assert len(bench.orders(Arm)) == len(bench.orders(TakeOff)) == len(bench.orders(Land)) == 1
    assert bench.agent.known_fraction >= 0.9
    home = bench.state.home_enu_m
    assert home is not None
    assert math.dist(bench.state.position_enu_m[:2], home[:2]) < 5.0
    assert [action.action_id for action in bench.actions] == list(range(1, len(bench.actions) + 1))
    sequences = [message.sequence for message in bench.messages]
    assert sequences == list(range(len(sequences)))


def test_a_status_is_said_about_once_a_second() -> None:
    bench = working()
    before = len(bench.said(Status))
    bench.run(30.0, dt_s=0.1)
    assert 30 <= len(bench.said(Status)) - before <= 50


def test_nothing_is_ordered_before_the_autopilot_is_heard() -> None:
    bench = AgentBench()
    for _ in range(20):
        outbox = bench.tick(tell_state=False)
        assert not outbox.actions
        assert not bench.said(Status)
    assert bench.agent.stage is Stage.CONNECTING


# Who steers


@pytest.mark.parametrize("mode", [FlightMode.MANUAL, FlightMode.RETURN, FlightMode.LAND, FlightMode.UNKNOWN])
def test_a_foreign_mode_is_never_fought_and_after_a_while_yielded_to(mode: FlightMode) -> None:
    bench = working()
    since, heard = len(bench.actions), len(bench.messages)
    bench._target = None
    bench.set(mode=mode)
    bench.tick()
    bench.run(YIELD_AFTER_S - 0.5)
    assert bench.agent.stage is Stage.WORKING
    bench.run(1.5)
    assert bench.agent.stage is Stage.YIELDED
    bench.run(30.0)
    assert flight_orders(bench, since) == []
    claims = bench.said(Claim, heard)
    assert not claims or not claims[-1].active
    assert mode.value in bench.said(Status)[-1].why


def test_a_foreign_mode_for_a_moment_is_no_reason_to_yield() -> None:
    bench = working()
    for _ in range(5):
        bench.set(mode=FlightMode.MANUAL)
        bench.run(2.0)
        bench.set(mode=FlightMode.GUIDED)
        bench.run(1.0)
    assert bench.agent.stage is Stage.WORKING
    assert "yielded" not in bench.codes()


def test_a_vehicle_handed_back_works_on() -> None:
    bench = working()
    bench.set(mode=FlightMode.MANUAL)
    bench.run_until(Stage.YIELDED)
    since = len(bench.actions)
    bench.set(mode=FlightMode.GUIDED)
    bench.run(3.0)
    assert bench.agent.stage is Stage.WORKING
    assert "handed-back" in bench.codes()
    assert any(isinstance(order, GoTo) for order in flight_orders(bench, since))


def test_a_vehicle_handed_back_on_its_way_home_goes_home() -> None:
    bench = working()
    bench.hear(command(Verb.RETURN))
    bench.tick()
    assert bench.agent.stage is Stage.RETURNING
    bench.set(mode=FlightMode.MANUAL)
    bench.run_until(Stage.YIELDED)
    bench.set(mode=FlightMode.GUIDED)
    bench.tick()
    assert bench.agent.stage is Stage.RETURNING
    bench.run_until(Stage.DONE)


def test_a_pilot_may_take_over_a_landing() -> None:
    bench = working()
    bench.hear(command(Verb.LAND))
    bench.run(2.0)
    assert bench.state.mode is FlightMode.LAND
    since = len(bench.actions)
    bench._target = None
    bench.set(mode=FlightMode.MANUAL)
    bench.run(30.0)
    assert bench.agent.stage is Stage.YIELDED
    assert flight_orders(bench, since) == []


def test_a_failsafe_that_lands_and_disarms_ends_the_mission() -> None:
    bench = working()
    bench.set(mode=FlightMode.RETURN)
    bench.run_until(Stage.YIELDED)
    bench.set(armed=False, landed=Landed.ON_GROUND)
    bench.run(2.0)
    assert bench.agent.stage is Stage.DONE
    assert bench.agent.finished


def test_a_refused_target_is_told_and_ordered_again() -> None:
    bench = working()
    bench.refuse = lambda order: "no EKF" if isinstance(order, GoTo) else ""
    bench.run(20.0)
    assert bench.codes().count("order-refused") == 1
    bench.refuse = lambda order: ""
    since = len(bench.actions)
    bench.run(4.0)
    assert bench.orders(GoTo, since)
    bench.run_until(Stage.DONE)


# Limits


def test_a_low_battery_calls_home() -> None:
    bench = working()
    bench.set(battery_fraction=0.14)
    bench.tick()
    assert bench.agent.stage is Stage.RETURNING
    assert "battery at 14 %" in next(e.text for e in bench.said(Event) if e.code == "returning")


def test_a_low_battery_ends_a_hold_and_brings_the_vehicle_home() -> None:
    bench = working()
    bench.hear(command(Verb.HOLD))
    bench.run_until(Stage.HOLDING)
    for _ in range(40):
        bench.tick()
    assert bench.agent.stage is Stage.HOLDING
    bench.set(battery_fraction=0.14)
    bench.run_until(Stage.RETURNING)
    assert "held no longer: battery at 14 %" in next(e.text for e in bench.said(Event) if e.code == "returning")
    bench.run_until(Stage.DONE)


def test_the_time_limit_calls_home() -> None:
    bench = AgentBench(sim_plan(stop={"time_limit_s": 20.0}))
    bench.run_until(Stage.RETURNING)
    assert "time limit" in bench.said(Event)[-1].text
    bench.run_until(Stage.DONE)


def test_the_return_altitude_rises_above_the_known_ground() -> None:
    bench = working()
    hill = CellObservations(np.array([3]), np.array([4_000], dtype=np.int32), np.array([1_000]))
    bench.tick(scans=[SensorScan(hill)])
    bench.run(8.0)
    height_m = [order.value for order in bench.orders(SetParameter) if order.name == "RTL_ALT"][-1] / 100.0
    assert GROUND_M + height_m >= 400.0 + 30.0
    assert bench.said(Status)[-1].return_up_cm == pytest.approx((GROUND_M + height_m) * 100.0)


def test_a_return_altitude_counts_only_when_it_was_taken() -> None:
    bench = working()
    bench.refuse = lambda order: "busy" if getattr(order, "name", "") == "RTL_ALT" else ""
    hill = CellObservations(np.array([3]), np.array([4_000], dtype=np.int32), np.array([1_000]))
    bench.tick(scans=[SensorScan(hill)])
    bench.run(10.0)
    asked = [order for order in bench.orders(SetParameter) if order.name == "RTL_ALT"]
    assert len(asked) >= 3
    assert bench.said(Status)[-1].return_up_cm < 20_000


# Maps


def test_a_delta_is_journalled_in_the_step_in_which_it_is_first_said() -> None:
    bench = AgentBench()
    for _ in range(120):
        outbox = bench.tick()
        said = [message.record for message in outbox.messages if isinstance(message, MapDelta)]
        assert outbox.journal == [encode_record(record) for record in said]
    assert bench.journal


def test_a_restart_in_the_air_resumes_the_map_and_its_stream() -> None:
    first = working()
    first.run(20.0)
    again = AgentBench(boot_id=6, journal=first.journal, start=first.state.position_enu_m, time_s=first.time_s)
    again.set(armed=True, landed=Landed.IN_AIR, mode=FlightMode.GUIDED)
    told = [m.record for m in first.said(MapDelta)]
    assert again.agent.map.observed.sum() > 0.9 * first.agent.map.observed.sum()
    again.run(30.0)
    assert again.agent.stage is Stage.WORKING
    assert "resumed" in again.codes()
    assert not again.orders(Arm)
    new = [m.record for m in again.said(MapDelta)]
    assert {r.stream_id for r in told + new} == {5}
    assert [r.delta_sequence for r in told + new] == list(range(len(told) + len(new)))
    assert {order.name for order in again.orders(SetParameter)} >= {"SYSID_MYGCS", "FS_GCS_ENABLE"}


@pytest.mark.parametrize("mode", [FlightMode.RETURN, FlightMode.MANUAL, FlightMode.LAND])
def test_a_restart_under_a_failsafe_or_a_pilot_leaves_it_to_them(mode: FlightMode) -> None:
    bench = AgentBench(start=FLYING)
    bench.set(armed=True, landed=Landed.LANDING if mode is FlightMode.LAND else Landed.IN_AIR, mode=mode)
    bench.run(20.0)
    assert bench.agent.stage is Stage.YIELDED
    assert flight_orders(bench, 0) == []
    bench.hear(command(Verb.RESUME))
    bench.run(3.0)
    assert bench.agent.stage is Stage.WORKING


def test_a_silent_teammate_is_told_once_and_greeted_when_it_is_back() -> None:
    bench = working()
    teammate = Voice("copter-1")
    bench.hear(teammate.status())
    bench.run(40.0)
    assert bench.codes().count("teammate-lost") == 1
    bench.hear(teammate.status())
    bench.tick()
    assert bench.codes().count("teammate-back") == 1


@pytest.mark.parametrize("sender", ["copter-0", "copter-1", "station-1"])
def test_anybodys_empty_digest_is_answered_without_fear(sender: str) -> None:
    bench = working()
    bench.run(5.0)
    bench.hear(Digest(sender=sender, boot_id=1, sequence=0, stamp_ms=0, streams=()))
    bench.tick()
    repairs = bench.said(Repair)
    assert bool(repairs) == (sender != "copter-0")


# Nonsense from the autopilot


@pytest.mark.parametrize(
    "nonsense",
    [
        {"position_enu_m": (math.nan, 0.0, 0.0)},
        {"position_enu_m": (0.0, math.inf, 0.0)},
        {"position_enu_m": (0.0, 0.0, 1e30)},
        {"velocity_enu_m_s": (0.0, 0.0, math.nan)},
    ],
)
def test_an_impossible_position_is_told_once_and_not_acted_on(nonsense: dict[str, object]) -> None:
    bench = working()
    since = len(bench.actions)
    bench.nonsense = nonsense
    bench.run(10.0)
    assert flight_orders(bench, since) == []
    assert bench.codes().count("no-position") == 1
    bench.nonsense = {}
    bench.run(1.0)
    assert bench.codes().count("position-back") == 1
    assert bench.agent.stage is Stage.WORKING


@pytest.mark.parametrize(
    "nonsense",
    [
        {"heading_deg": math.nan},
        {"heading_deg": -720.5},
        {"battery_fraction": math.nan},
        {"battery_fraction": -0.01},
        {"battery_fraction": 7.0},
        {"home_enu_m": (math.nan, 0.0, 0.0)},
    ],
)
def test_the_rest_of_a_state_survives_a_senseless_part(nonsense: dict[str, object]) -> None:
    bench = working()
    bench.nonsense = nonsense
    bench.run(5.0)
    assert bench.agent.stage is Stage.WORKING
    (status,) = bench.said(Status)[-1:]
    assert 0 <= status.heading_deg < 360
    assert -1 <= status.battery_permille <= 1000
