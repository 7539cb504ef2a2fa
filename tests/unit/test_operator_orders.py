"""What a flying agent does with an operator's orders, against the simulated copter and without sockets."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np
import pytest

from missions.lockstep_vehicle import LockstepVehicle
from sim_bridge.fleet import Fleet
from sim_bridge.world import World
from tests.fakes.talking_fleet import Voice, small_plan
from vehicle_agent.agent import VehicleAgent
from vehicle_agent.mission.load import MissionPlan, plan_mission
from vehicle_agent.wire.messages import Command, CommandResult, Orders, Outcome, Stage, Verb

TICK_S = 0.2


def wide_plan() -> MissionPlan:
    """One copter over 600 m x 600 m of flat ground."""
    mission = small_plan(2).mission
    area = msgspec.structs.replace(mission.area, rectangle_enu_m=(0.0, 0.0, 600.0, 600.0), fence_margin_m=10.0)
    return plan_mission(msgspec.structs.replace(mission, area=area))


class Flight:
    """One agent on its simulated copter."""

    def __init__(self) -> None:
        self.plan = wide_plan()
        self.fleet = Fleet(self.plan, World.of(self.plan))
        self.agent = VehicleAgent(self.plan, 0, 1, np.random.default_rng(0))
        self.vehicle = LockstepVehicle(self.plan, 0, self.fleet)
        self.said: list[Any] = []
        self.commands = 0

    def step(self) -> None:
        self.fleet.step(TICK_S)
        now_s, inbox = self.vehicle.take_inbox()
        outbox = self.agent.step(now_s, inbox)
        self.vehicle.carry_out(outbox.actions)
        self.said += outbox.messages

    def until(self, condition: Callable[[], bool], limit_s: float = 900.0) -> None:
        for _ in range(round(limit_s / TICK_S)):
            if condition():
                return
            self.step()
        pytest.fail("the agent did not get there")

    def order(self, verb: Verb, **payload: Any) -> CommandResult:
        self.commands += 1
        stamp_ms = self.fleet.vehicles[0].snapshot.stamp_ms
        command = Command(
            sender="station-1", boot_id=1, sequence=self.commands, stamp_ms=stamp_ms, command_id=self.commands,
            verb=verb, targets=("merlin",), **payload,
        )  # fmt: skip
        self.vehicle.inbox.messages.append(command)
        self.step()
        return next(one for one in reversed(self.said) if isinstance(one, CommandResult))

    @property
    def position_m(self) -> tuple[float, float, float]:
        return self.fleet.vehicles[0].pilot.position_enu_m

    @property
    def standing(self) -> Orders:
        return next(one for one in reversed(self.said) if isinstance(one, Orders))


@pytest.fixture
def flight() -> Flight:
    flight = Flight()
    flight.until(lambda: flight.agent.stage is Stage.WORKING)
    for _ in range(20):
        flight.step()
    return flight


def test_it_goes_where_it_is_sent_and_holds_there(flight: Flight) -> None:
    assert flight.order(Verb.GO_TO, point_cm=(15_000, 5_000, 0)).outcome is Outcome.ACCEPTED
    flight.until(lambda: flight.agent.stage is Stage.HOLDING)
    east_m, north_m, _ = flight.position_m
    assert abs(east_m - 150) < 15
    assert abs(north_m - 50) < 15


def test_it_visits_a_point_and_goes_on_with_the_mission(flight: Flight) -> None:
    flight.order(Verb.VISIT, point_cm=(15_000, 5_000, 0))
    flight.until(lambda: any(getattr(one, "code", "") == "arrived" for one in flight.said))
    assert flight.agent.stage is Stage.WORKING
    flight.until(lambda: flight.agent.finished)


def test_it_never_enters_a_no_fly_zone_and_tells_that_it_stands(flight: Flight) -> None:
    corners = ((20_000, 20_000), (40_000, 20_000), (40_000, 40_000), (20_000, 40_000))
    assert flight.order(Verb.NO_FLY, number=1, polygon_cm=corners).outcome is Outcome.ACCEPTED
    assert flight.standing.no_fly[0].polygon_cm == corners
    inside: list[tuple[float, float, float]] = []

    def watch() -> bool:
        east_m, north_m, _ = flight.position_m
        if 205 < east_m < 395 and 205 < north_m < 395:
            inside.append(flight.position_m)
        return flight.agent.finished

    flight.until(watch, 1_500.0)
    assert inside == []
    assert flight.agent.stage is Stage.DONE


def test_a_smaller_area_ends_the_mission_sooner(flight: Flight) -> None:
    whole = flight.agent.known_fraction
    flight.order(Verb.AREA, polygon_cm=((0, 0), (20_000, 0), (20_000, 20_000), (0, 20_000)))
    assert flight.agent.known_fraction > whole
    flight.until(lambda: flight.agent.finished)
    assert flight.agent.map.observed.mean() < 0.6


def test_a_sector_is_seen_first_and_then_dropped(flight: Flight) -> None:
    flight.order(Verb.SECTOR, polygon_cm=((40_000, 0), (60_000, 0), (60_000, 20_000), (40_000, 20_000)))
    assert flight.standing.sector_cm
    flight.until(lambda: not flight.standing.sector_cm)
    observed = flight.agent.map.observed
    assert observed[40:60, 0:20].all()
    assert not observed[40:60, 40:60].all()


def test_it_keeps_a_speed_limit(flight: Flight) -> None:
    flight.order(Verb.SPEED, number=300)
    for _ in range(30):
        flight.step()
    before = flight.position_m
    for _ in range(50):
        flight.step()
    assert np.hypot(flight.position_m[0] - before[0], flight.position_m[1] - before[1]) <= 3.0 * 10.0 + 1.0


@pytest.mark.parametrize(
    ("verb", "payload", "reason"),
    [
        (Verb.GO_TO, {"point_cm": (-5_000, 0, 0)}, "outside the fence"),
        (Verb.NO_FLY, {"number": 9}, "no zone 9"),
        (Verb.NO_FLY, {"number": 1, "polygon_cm": ((0, 0), (9_000, 0), (0, 9_000))}, "home"),
        (Verb.NO_FLY, {"number": 1, "polygon_cm": ((0, 0), (100, 100), (100, 0), (0, 100))}, "cross"),
        (Verb.AREA, {"polygon_cm": ((-900, -900), (-800, -900), (-800, -800))}, "nothing of the area"),
        (Verb.SPEED, {"number": 99_000}, "between 0.5 and 10 m/s"),
        (Verb.RELEASE, {"subject": "kestrel"}, "not a teammate"),
        (Verb.RELEASE, {"subject": "merlin"}, "not a teammate"),
    ],
)
def test_what_cannot_be_done_is_refused_with_the_reason(
    flight: Flight, verb: Verb, payload: dict[str, Any], reason: str
) -> None:
    result = flight.order(verb, **payload)
    assert result.outcome is Outcome.REFUSED
    assert reason in result.text


def test_a_released_teammate_counts_as_lost_until_it_is_heard_again(flight: Flight) -> None:
    kestrel = Voice("kestrel")
    stamp_s = 0.0
    flight.vehicle.inbox.messages.append(kestrel.status(stamp_s))
    flight.step()
    assert flight.order(Verb.RELEASE, subject="kestrel").outcome is Outcome.ACCEPTED
    assert flight.order(Verb.RELEASE, subject="kestrel").outcome is Outcome.ACCEPTED
    flight.vehicle.inbox.messages.append(kestrel.status(stamp_s + 1.0))
    flight.step()
    assert any(getattr(one, "code", "") == "teammate-back" for one in flight.said)
