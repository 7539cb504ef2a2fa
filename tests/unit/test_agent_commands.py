"""What an agent does with an operator's commands, against a scripted autopilot."""

from __future__ import annotations

import math

from tests.fakes.agent_bench import EPOCH_S, AgentBench, command, flight_orders, working
from vehicle_agent.ports import (
    FlightMode,
    Hold,
)
from vehicle_agent.wire.messages import (
    CommandResult,
    Outcome,
    Stage,
    Status,
    Verb,
)


def test_hold_resume_return_each_once_with_a_result() -> None:
    bench = working()
    for number, (verb, stage) in enumerate(
        [(Verb.HOLD, Stage.HOLDING), (Verb.RESUME, Stage.WORKING), (Verb.RETURN, Stage.RETURNING)]
    ):
        order = command(verb, number)
        bench.hear(order, order)
        bench.tick()
        assert bench.agent.stage is stage
        bench.hear(order)
        bench.run(5.0)
        assert bench.agent.stage is stage
    results = bench.said(CommandResult)
    assert [(r.command_id, r.verb, r.outcome) for r in results] == [
        (0, Verb.HOLD, Outcome.ACCEPTED),
        (1, Verb.RESUME, Outcome.ACCEPTED),
        (2, Verb.RETURN, Outcome.ACCEPTED),
    ]
    assert all(r.station == "station-1" and r.station_boot_id == 3 for r in results)
    assert len(bench.orders(Hold)) == 1
    bench.run_until(Stage.DONE)


def test_a_held_vehicle_stays_and_orders_nothing() -> None:
    bench = working()
    bench.hear(command(Verb.HOLD))
    bench.run(2.0)
    since, place = len(bench.actions), bench.state.position_enu_m
    bench.run(60.0)
    assert flight_orders(bench, since) == []
    assert bench.state.position_enu_m == place
    assert bench.agent.stage is Stage.HOLDING


def test_a_hold_that_was_not_taken_is_ordered_again() -> None:
    bench = working()
    bench.refuse = lambda order: "busy" if isinstance(order, Hold) else ""
    bench.hear(command(Verb.HOLD))
    bench.run(5.0)
    bench.refuse = lambda order: ""
    bench.run(5.0)
    assert bench.state.mode is FlightMode.HOLD


def test_land_lands_here_and_now() -> None:
    bench = working()
    place = bench.state.position_enu_m
    bench.hear(command(Verb.LAND))
    bench.run_until(Stage.DONE)
    assert math.dist(bench.state.position_enu_m[:2], place[:2]) < 30.0
    (landing,) = [s for s in bench.said(Status) if s.stage is Stage.LANDING][:1]
    assert math.dist(landing.leg_end_cm[:2], landing.position_cm[:2]) == 0  # straight down, not along a way home


def test_a_landing_can_be_stopped() -> None:
    bench = working()
    bench.hear(command(Verb.LAND, 1))
    bench.run(3.0)
    bench.hear(command(Verb.HOLD, 2))
    bench.run(10.0)
    assert bench.agent.stage is Stage.HOLDING
    assert bench.state.armed


def test_a_take_off_can_be_broken_off() -> None:
    bench = AgentBench()
    bench.run_until(Stage.TAKING_OFF)
    bench.run(2.0)
    bench.hear(command(Verb.LAND))
    bench.run_until(Stage.DONE)
    assert "took-off" not in bench.codes()


def test_commands_out_of_place_are_refused_with_a_reason() -> None:
    bench = AgentBench()
    bench.set(ready_to_arm=False)
    bench.run(3.0)
    bench.hear(command(Verb.RETURN))
    bench.tick()
    (result,) = bench.said(CommandResult)
    assert result.outcome is Outcome.REFUSED
    assert result.text


def test_commands_of_the_time_before_this_agent_are_refused() -> None:
    bench = working(AgentBench(time_s=1e6))
    bench.hear(command(Verb.LAND, stamp_ms=round(EPOCH_S * 1000)))
    bench.tick()
    assert bench.agent.stage is Stage.WORKING
    assert bench.said(CommandResult)[-1].outcome is Outcome.REFUSED
