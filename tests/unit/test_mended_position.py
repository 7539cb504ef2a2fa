"""A mapping vehicle whose position is mended by ranges: what it tells and where it steers is where it truly is."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.fakes.map_missions import map_plan
from vehicle_agent.behaviour.depth_navigator import DepthNavigator
from vehicle_agent.behaviour.guide import Surroundings
from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.mission.tasks import MapTask
from vehicle_agent.ports import Inbox, Sounding, TeammateRange, VehicleState
from vehicle_agent.survey_agent import SurveyAgent
from vehicle_agent.wire.messages import Landmarks, Stage

ASTRAY_M = 12.0
"""So far east of the truth the autopilot reckons itself to be."""
DEPTH_M = 3.5
START_MS = 1_767_225_600_000


class Dive:
    """`brisa` under water for a quarter of an hour, hearing of `alba` every ten seconds from all around."""

    def __init__(self, ranging: bool) -> None:
        self.plan = map_plan(task=MapTask(step_m=20.0, accurate_sd_m=0.2, surfacing=False, ranging=ranging))
        self.agent = SurveyAgent(self.plan, 1, 5, np.random.default_rng(0))
        surface_m = self.plan.mission.simulation.water_level_m
        self.reckoned: Point = (20.0 + ASTRAY_M, 20.0, surface_m - DEPTH_M)
        self.truth: Point = (20.0, 20.0, surface_m - DEPTH_M)
        self.now_ms = START_MS
        self.sequence = 0

    def wait(self, seconds: int) -> None:
        for _ in range(seconds):
            self.step(Inbox())

    def step(self, inbox: Inbox) -> None:
        self.now_ms += 1_000
        inbox.state = VehicleState(stamp_ms=self.now_ms, position_enu_m=self.reckoned)
        self.agent.step(self.now_ms / 1_000, inbox)

    def hear(self, bearing_rad: float, error_m: float = 0.0, repeat: bool = False) -> None:
        """A packet and its range, from 30 m away."""
        self.sequence += not repeat
        east, north = 20.0 + 30.0 * math.sin(bearing_rad), 20.0 + 30.0 * math.cos(bearing_rad)
        packet = Landmarks(
            sender="alba", boot_id=1, sequence=self.sequence, stamp_ms=self.now_ms,
            position_cm=(round(100 * east), round(100 * north), round(100 * self.truth[2])), position_sd_cm=100,
            records=b"",
        )  # fmt: skip
        measured = TeammateRange("alba", self.sequence, 30.0 + error_m)
        self.step(Inbox(messages=[packet], ranges=[measured]))

    @property
    def off_m(self) -> float:
        east_m, north_m = self.agent._drift.correction_m
        return math.dist((self.reckoned[0] + east_m, self.reckoned[1] + north_m), self.truth[:2])


def test_ranges_from_all_around_bring_it_back_to_where_it_is() -> None:
    dive = Dive(ranging=True)
    dive.wait(400)
    assert dive.off_m == pytest.approx(ASTRAY_M)
    sd_before_m = dive.agent._drift.position_sd_m
    for number in range(12):
        dive.hear(number * math.tau / 6.0)
        dive.wait(9)
    assert dive.off_m < 2.5
    assert dive.agent._drift.position_sd_m < 0.4 * sd_before_m


def test_a_mission_may_do_without_and_a_packet_counts_once() -> None:
    deaf = Dive(ranging=False)
    deaf.wait(400)
    deaf.hear(1.0)
    assert deaf.agent._drift.ranges_used == 0
    dive = Dive(ranging=True)
    dive.wait(400)
    dive.hear(1.0)
    assert dive.agent._drift.ranges_used == 1
    dive.hear(1.0, repeat=True)
    assert dive.agent._drift.ranges_used == 1


def test_a_range_without_its_packet_or_far_beyond_belief_changes_nothing() -> None:
    dive = Dive(ranging=True)
    dive.wait(400)
    dive.step(Inbox(ranges=[TeammateRange("alba", 99, 30.0), TeammateRange("nobody", 1, 5.0)]))
    dive.hear(0.5, error_m=5_000.0)
    assert dive.agent._drift.ranges_used == 0
    assert dive.agent._drift.correction_m == (0.0, 0.0)


def test_a_target_is_sent_again_when_the_position_is_mended_under_way() -> None:
    dive = Dive(ranging=True)
    navigator = dive.agent._flight.navigator
    assert isinstance(navigator, DepthNavigator)

    def around() -> Surroundings:
        east_m, north_m = dive.agent._drift.correction_m
        here = (dive.reckoned[0] + east_m, dive.reckoned[1] + north_m, dive.reckoned[2])
        return Surroundings(dive.now_ms / 1_000, VehicleState(dive.now_ms, here), 1, (), (), (), 0.0)

    dive.wait(400)
    target = navigator.go_home(around(), (5.0, 5.0, 0.0))
    assert target is not None
    assert navigator.go_home(around(), (5.0, 5.0, 0.0)) is None
    dive.hear(math.pi / 2.0)
    assert math.hypot(*dive.agent._drift.correction_m) > 1.0
    assert navigator.go_home(around(), (5.0, 5.0, 0.0)) == target
    assert navigator.go_home(around(), (5.0, 5.0, 0.0)) is None


def test_a_sounding_counts_where_it_was_taken_and_not_where_it_is_heard() -> None:
    plan = map_plan()
    agent = SurveyAgent(plan, 0, 5, np.random.default_rng(0))
    agent._flight.stage = Stage.WORKING
    up_m = plan.mission.simulation.water_level_m - 2.0
    heard: list[tuple[Point, float]] = []
    share, sound = agent._share, agent._share.sound

    def listen(position_enu_m: Point, range_m: float, unfixed_s: float) -> tuple[IndexArray, IndexArray]:
        heard.append((position_enu_m, range_m))
        return sound(position_enu_m, range_m, unfixed_s)

    share.sound = listen  # type: ignore[method-assign]
    for tick in range(3):
        now_ms = START_MS + 200 * tick
        reading = Sounding(START_MS + 300, 7.0) if tick == 2 else None
        state = VehicleState(stamp_ms=now_ms, position_enu_m=(20.0 + 3.0 * tick, 20.0, up_m), sounding=reading)
        agent._drift.watch(now_ms / 1_000, state)
        agent._sound(state.sounding)
    assert heard == [(pytest.approx((24.5, 20.0, up_m)), 7.0)]
