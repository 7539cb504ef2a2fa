"""Up and down over home: nobody comes down on a teammate or up into one, and who rests there makes way."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import msgspec
import pytest

from tests.fakes.agent_bench import EPOCH_S, AgentBench, command
from tests.fakes.bench_team import BenchTeam
from tests.fakes.hill_missions import copters
from tests.fakes.sim_missions import GROUND_M, sim_plan
from tests.fakes.talking_fleet import Voice
from vehicle_agent.behaviour.units import to_centimetres
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.ports import Arm, FlightMode, Land, Landed
from vehicle_agent.wire.messages import Event, Stage, Status, Verb

SEPARATION_M = 20.0
HOME = (200.0, 200.0)
NAMES = ("ada", "bob", "cyd")


def team_plan(*starts: tuple[float, float], max_above_terrain_m: float = 150.0, **changes: Any) -> MissionPlan:
    team = copters(starts, NAMES, range_m=200.0, speed_m_s=15.0, max_above_terrain_m=max_above_terrain_m)
    return sim_plan(team=team, safety={"separation_m": SEPARATION_M}, **changes)


def send_to(bench: AgentBench, number: int, east_m: float, north_m: float) -> None:
    point_cm = to_centimetres((east_m, north_m, 0.0))
    bench.hear(command(Verb.GO_TO, number, bench.agent.name, point_cm=point_cm))


class Bob(Voice):
    """A teammate whose home is at (260, 200)."""

    def __init__(self) -> None:
        super().__init__("bob")

    def at(self, place: tuple[float, float, float], **changes: Any) -> Status:
        here = to_centimetres(place)
        home = (26_000, 20_000, round(100 * GROUND_M))
        return self.status(**({"position_cm": here, "leg_end_cm": here, "home_cm": home} | changes))


def hover(bench: AgentBench, seconds: float, tell: Callable[[], Status]) -> None:
    """Let time pass while a teammate says again and again where it is."""
    for _ in range(round(2.0 * seconds)):
        bench.hear(msgspec.structs.replace(tell(), stamp_ms=round((EPOCH_S + bench.time_s) * 1000)))
        bench.tick()


def over_home() -> tuple[AgentBench, Bob, tuple[float, float, float]]:
    """A vehicle that has come back over home, where bob hovers low."""
    bench, bob = AgentBench(team_plan(HOME, (260.0, 200.0))), Bob()
    below = (HOME[0] + 3.0, HOME[1], GROUND_M + 12.0)
    bench.run_until(Stage.WORKING)
    bench.hear(command(Verb.RETURN, target="ada"), bob.at(below))
    hover(bench, 30.0, lambda: bob.at(below))
    return bench, bob, below


def test_it_waits_over_home_while_somebody_is_below_and_says_for_whom() -> None:
    bench, bob, _ = over_home()
    assert bench.agent.stage is Stage.RETURNING
    assert not bench.orders(Land)
    assert bench.said(Status)[-1].why == "waits at home: bob is in the way"
    assert [event.text for event in bench.said(Event) if event.code == "waiting"] == [
        "waits at home: bob is in the way"
    ]
    gone = (HOME[0] + 40.0, HOME[1], GROUND_M + 12.0)
    hover(bench, 3.0, lambda: bob.at(gone))
    assert bench.agent.stage is Stage.LANDING
    bench.run_until(Stage.DONE)


def test_who_can_wait_no_longer_goes_down() -> None:
    bench, bob, below = over_home()
    reserve = bench.plan.mission.stop.battery_reserve
    bench.set(battery_fraction=0.8 * reserve)
    hover(bench, 10.0, lambda: bob.at(below))
    assert bench.agent.stage is Stage.RETURNING
    bench.set(battery_fraction=0.4 * reserve)
    hover(bench, 1.0, lambda: bob.at(below))
    assert bench.agent.stage is Stage.LANDING
    assert "can wait no longer for bob" in next(e.text for e in bench.said(Event) if e.code == "landing")


@pytest.mark.parametrize(
    "parked",
    [{"armed": False, "stage": Stage.DONE}, {"armed": True, "stage": Stage.LANDING}],
    ids=["on the ground", "landing"],
)
def test_homes_nearer_than_the_separation_keep_nobody_from_landing(parked: dict[str, Any]) -> None:
    bench, bob = AgentBench(team_plan(HOME, (206.0, 200.0))), Bob()
    home_cm = (20_600, 20_000, round(100 * GROUND_M))
    fields = parked | {"home_cm": home_cm, "leg_end_cm": home_cm}
    bench.run_until(Stage.WORKING)
    bench.hear(command(Verb.RETURN, target="ada"))
    hover(bench, 60.0, lambda: bob.at((206.0, 200.0, GROUND_M + (2.0 if parked["armed"] else 0.0)), **fields))
    assert bench.agent.stage is Stage.DONE


def test_nobody_arms_below_a_teammate() -> None:
    bench, bob = AgentBench(team_plan(HOME, (260.0, 200.0))), Bob()
    above = (HOME[0], HOME[1], GROUND_M + 45.0)
    hover(bench, 20.0, lambda: bob.at(above))
    assert bench.agent.stage is Stage.ARMING
    assert not bench.orders(Arm)
    assert [event.text for event in bench.said(Event) if event.code == "waiting"] == [
        "waits to set out: bob is in the way"
    ]
    hover(bench, 8.0, lambda: bob.at((HOME[0] + 30.0, HOME[1], GROUND_M + 45.0)))
    assert bench.agent.stage in (Stage.TAKING_OFF, Stage.WORKING)


@pytest.mark.parametrize("verb", [Verb.HOLD, Verb.RESUME])
@pytest.mark.parametrize("stage", [Stage.RETURNING, Stage.ARMING])
def test_who_rests_over_a_home_makes_way_for_its_owner(verb: Verb, stage: Stage) -> None:
    bench, bob = AgentBench(team_plan(HOME, (260.0, 200.0), task={"kind": "cover"})), Bob()
    bench.run_until(Stage.WORKING)
    send_to(bench, 1, 262.0, 203.0)
    bench.run_until(Stage.HOLDING)
    bench.run(5.0)
    bench.hear(command(verb, 2, "ada"))
    bench.tick()
    if stage is Stage.RETURNING:
        hover(bench, 30.0, lambda: bob.at((310.0, 200.0, GROUND_M + 45.0), stage=stage))
    else:
        above = (26_000, 20_000, 8_300)
        place = (260.0, 200.0, GROUND_M)
        hover(bench, 30.0, lambda: bob.at(place, stage=stage, armed=False, leg_end_cm=above))
    east_m, north_m, _ = bench.state.position_enu_m
    assert math.hypot(east_m - 260.0, north_m - 200.0) >= SEPARATION_M
    if verb is Verb.HOLD:
        assert bench.agent.stage is Stage.HOLDING
        assert bench.said(Status)[-1].why == "makes way for bob"


def held_up() -> tuple[AgentBench, Callable[[], Status]]:
    """A vehicle on its way home, across which bob reserves a leg that it can neither pass below nor above."""
    team = copters((HOME, (260.0, 800.0)), NAMES, range_m=200.0, speed_m_s=15.0, max_above_terrain_m=50.0)
    bench, bob = AgentBench(sim_plan(team=team, safety={"separation_m": SEPARATION_M}, task={"kind": "cover"})), Bob()
    bench.run_until(Stage.WORKING)
    send_to(bench, 1, 420.0, 200.0)
    bench.run_until(Stage.HOLDING)
    bench.hear(command(Verb.RETURN, 2, "ada"))
    place, end = (300.0, 0.0, GROUND_M + 40.0), to_centimetres((300.0, 900.0, GROUND_M + 40.0))
    return bench, lambda: bob.at(place, leg_end_cm=end, stage=Stage.YIELDED)


def test_who_is_held_up_on_the_way_home_comes_down_there_before_its_charge_is_gone() -> None:
    bench, in_the_way = held_up()
    reserve = bench.plan.mission.stop.battery_reserve
    bench.set(battery_fraction=0.9 * reserve)
    hover(bench, 60.0, in_the_way)
    assert bench.agent.stage is Stage.RETURNING
    bench.set(battery_fraction=0.45 * reserve)
    hover(bench, 2.0, in_the_way)
    assert bench.agent.stage is Stage.LANDING
    hover(bench, 60.0, in_the_way)
    assert bench.agent.stage is Stage.DONE
    assert bench.state.position_enu_m[0] > 300.0 + SEPARATION_M - 0.2


def test_who_is_held_up_goes_home_once_the_way_is_free() -> None:
    bench, in_the_way = held_up()
    hover(bench, 60.0, in_the_way)
    assert bench.agent.stage is Stage.RETURNING
    bench.run_until(Stage.DONE)
    assert math.dist(bench.state.position_enu_m[:2], HOME) < 5.0


def test_with_little_charge_on_a_free_way_it_still_goes_home() -> None:
    bench, _ = held_up()
    bench.set(battery_fraction=0.45 * bench.plan.mission.stop.battery_reserve)
    bench.run_until(Stage.DONE)
    assert math.dist(bench.state.position_enu_m[:2], HOME) < 5.0


# Teams


def hold_over_home_of(team: BenchTeam, holder: int, owner: int, height_m: float) -> None:
    """Bring a vehicle to rest over a teammate's home, low enough to be in the way."""
    home = team.benches[owner].plan.mission.vehicles[owner].start_enu_m
    bench = team.benches[holder]
    send_to(bench, 10 + holder, home[0], home[1])
    team.run_until(lambda: bench.agent.stage is Stage.HOLDING)
    bench._target = (home[0] + 2.0, home[1], GROUND_M + height_m)
    bench.set(mode=FlightMode.GUIDED)
    team.run(20.0)


def all_down(team: BenchTeam) -> bool:
    return all(bench.agent.stage is Stage.DONE for bench in team.benches)


@pytest.mark.parametrize("height_m", [12.0, 40.0])
def test_a_team_keeps_apart_when_one_holds_over_the_home_of_one_who_returns(height_m: float) -> None:
    team = BenchTeam(team_plan((200.0, 200.0), (260.0, 200.0)))
    team.run_until(lambda: all(bench.agent.stage is Stage.WORKING for bench in team.benches))
    send_to(team.benches[0], 1, 500.0, 500.0)
    team.run_until(lambda: team.benches[0].agent.stage is Stage.HOLDING)
    hold_over_home_of(team, 1, 0, height_m)
    team.benches[0].hear(command(Verb.RETURN, 2, "ada"))
    team.run_until(lambda: team.benches[0].agent.stage is Stage.DONE)
    assert team.benches[1].agent.stage is Stage.HOLDING
    assert team.closest_m >= SEPARATION_M - 0.2


def test_who_rests_on_the_way_home_of_one_who_is_held_up_makes_way() -> None:
    team = BenchTeam(team_plan((200.0, 200.0), (260.0, 600.0), max_above_terrain_m=50.0))
    team.run_until(lambda: all(bench.agent.stage is Stage.WORKING for bench in team.benches))
    send_to(team.benches[0], 1, 460.0, 200.0)
    team.run_until(lambda: team.benches[0].agent.stage is Stage.HOLDING)
    send_to(team.benches[1], 2, 330.0, 200.0)
    team.run_until(lambda: team.benches[1].agent.stage is Stage.HOLDING)
    team.benches[0].hear(command(Verb.RETURN, 3, "ada"))
    team.run_until(lambda: team.benches[0].agent.stage is Stage.DONE)
    assert math.dist(team.benches[0].state.position_enu_m[:2], HOME) < 5.0
    assert team.closest_m >= SEPARATION_M - 0.2


def test_two_that_rest_over_each_others_home_both_come_down() -> None:
    team = BenchTeam(team_plan((200.0, 200.0), (260.0, 200.0)))
    team.run_until(lambda: all(bench.agent.stage is Stage.WORKING for bench in team.benches))
    send_to(team.benches[0], 1, 500.0, 500.0)
    team.run_until(lambda: team.benches[0].agent.stage is Stage.HOLDING)
    hold_over_home_of(team, 1, 0, 40.0)
    hold_over_home_of(team, 0, 1, 40.0)
    for number, bench in enumerate(team.benches):
        bench.hear(command(Verb.RETURN, 30 + number, bench.agent.name))
    team.run_until(lambda: all_down(team))
    assert team.closest_m >= SEPARATION_M - 0.2


@pytest.mark.parametrize("gap_m", [6.0, 15.0, 40.0])
def test_a_team_comes_home_together_and_keeps_the_distance_of_its_homes(gap_m: float) -> None:
    team = BenchTeam(team_plan(*((200.0 + gap_m * number, 200.0) for number in range(3))))
    team.run_until(lambda: all(bench.agent.stage is Stage.WORKING for bench in team.benches))
    team.run(30.0)
    for number, bench in enumerate(team.benches):
        bench.hear(command(Verb.RETURN, 30 + number, bench.agent.name))
    team.run_until(lambda: all_down(team))
    assert all(bench.state.landed is Landed.ON_GROUND for bench in team.benches)
    assert team.closest_m >= min(gap_m, SEPARATION_M) - 0.2
