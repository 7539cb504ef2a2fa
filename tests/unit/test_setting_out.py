"""Before its work: what an agent checks and orders until its vehicle is under way, and when it refuses to fly."""

from __future__ import annotations

from tests.fakes.agent_bench import AgentBench, flight_orders
from tests.fakes.sim_missions import GROUND_M
from vehicle_agent.ports import (
    Arm,
    FlightMode,
    Landed,
    TakeOff,
)
from vehicle_agent.wire.messages import (
    Event,
    Severity,
    Stage,
)

FLYING = (150.0, 200.0, 90.0)


def test_a_rival_controller_is_refused() -> None:
    bench = AgentBench()
    bench.set(rival_controller=True)
    bench.run(2.0)
    assert bench.agent.stage is Stage.REFUSED
    assert bench.agent.finished
    assert not bench.actions
    (refusal,) = bench.said(Event)
    assert refusal.severity is Severity.ERROR
    assert "101" in refusal.text


def test_a_rival_that_shows_while_arming_is_refused() -> None:
    bench = AgentBench()
    bench.set(ready_to_arm=False)
    bench.run_until(Stage.ARMING)
    bench.set(rival_controller=True)
    bench.run(2.0)
    assert bench.agent.stage is Stage.REFUSED
    assert not bench.orders(Arm)


def test_a_parameter_that_is_refused_is_named_and_nobody_arms() -> None:
    bench = AgentBench()
    bench.refuse = lambda order: "read only" if getattr(order, "name", "") == "FS_GCS_ENABLE" else ""
    bench.run(60.0)
    assert bench.agent.stage is Stage.REFUSED
    assert not bench.orders(Arm)
    assert "FS_GCS_ENABLE" in bench.said(Event)[-1].text
    assert "read only" in bench.said(Event)[-1].text


def test_refused_arming_is_tried_again_and_explained_once() -> None:
    bench = AgentBench()
    bench.refuse = lambda order: "Arm: compass" if isinstance(order, Arm) else ""
    bench.run(30.0)
    assert bench.agent.stage is Stage.ARMING
    assert 5 <= len(bench.orders(Arm)) <= 12
    assert bench.codes().count("arming-refused") == 1
    bench.refuse = lambda order: "Arm: battery" if isinstance(order, Arm) else ""
    bench.run(10.0)
    assert [e.text for e in bench.said(Event) if e.code == "arming-refused"] == ["Arm: compass", "Arm: battery"]
    bench.refuse = lambda order: ""
    bench.run_until(Stage.WORKING)


def test_nobody_arms_before_the_autopilot_is_ready() -> None:
    bench = AgentBench()
    bench.set(ready_to_arm=False)
    bench.run(30.0)
    assert not bench.orders(Arm)
    bench.set(ready_to_arm=True)
    bench.run_until(Stage.WORKING)


def test_a_pilot_who_flies_before_the_agent_arms_keeps_the_vehicle() -> None:
    bench = AgentBench()
    bench.set(ready_to_arm=False)
    bench.run_until(Stage.ARMING)
    bench.set(armed=True, landed=Landed.IN_AIR, mode=FlightMode.MANUAL, position_enu_m=FLYING, ready_to_arm=True)
    since = len(bench.actions)
    bench.run(30.0)
    assert bench.agent.stage is Stage.YIELDED
    assert flight_orders(bench, since) == []


def test_a_vehicle_that_disarms_before_take_off_is_armed_again_but_not_for_ever() -> None:
    bench = AgentBench()
    bench.refuse = lambda order: "not now" if isinstance(order, TakeOff) else ""
    for _ in range(400):
        bench.tick()
        if bench.agent.stage is Stage.TAKING_OFF and bench.orders(TakeOff):
            bench.set(armed=False, mode=FlightMode.MANUAL)
        if bench.agent.finished:
            break
    assert bench.agent.stage is Stage.REFUSED
    assert len(bench.orders(Arm)) == 3


def test_a_take_off_that_a_pilot_ends_is_not_begun_again() -> None:
    bench = AgentBench()
    bench.run_until(Stage.TAKING_OFF)
    bench.run(2.0)
    assert bench.state.position_enu_m[2] > GROUND_M + 5.0
    bench._target = None
    bench.set(mode=FlightMode.MANUAL)
    since = len(bench.actions)
    bench.run(1.0)
    bench.set(armed=False, landed=Landed.ON_GROUND)
    bench.run(30.0)
    assert bench.agent.stage is Stage.DONE
    assert flight_orders(bench, since) == []


def test_a_lost_take_off_order_is_given_again() -> None:
    bench = AgentBench()
    bench.run_until(Stage.TAKING_OFF)
    bench.deaf = True
    bench.run(8.0)
    bench.deaf = False
    bench.run_until(Stage.WORKING)
    assert len(bench.orders(TakeOff)) >= 3
