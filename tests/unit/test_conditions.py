"""Named conditions: when each begins and ends, and what acknowledging and muting do."""

from __future__ import annotations

from typing import Any

import pytest

from ground_station.conditions import ADVICE, SEVERITIES, Kind
from ground_station.evidence import distance_to_leg_m
from ground_station.fleet_state import fold
from ground_station.inputs import Acknowledged, AliveChanged, Heard, Muted, Tick
from ground_station.picture import FleetState
from tests.fakes.talking_fleet import NAMES, Voice, small_plan
from vehicle_agent.wire.messages import Severity, Stage

PLAN = small_plan()


class Story:
    """A fleet told second by second; station time runs as vehicle time."""

    def __init__(self) -> None:
        self.state = FleetState.initial(PLAN, "station-0001", 9, 0.0)
        self.voices = {name: Voice(name) for name in NAMES}
        self.now_s = 0.0

    def say(self, name: str, elapsed_s: float | None = None, **changes: Any) -> None:
        status = self.voices[name].status(self.now_s if elapsed_s is None else elapsed_s, **changes)
        self.state = fold(self.state, [Heard(status, self.now_s)])

    def pass_second(self) -> None:
        self.now_s += 1.0
        self.state = fold(self.state, [Tick(self.now_s)])

    def kinds(self, name: str = "merlin") -> set[Kind]:
        return {one.kind for one in self.state.troubles if one.vehicle == name}

    def codes(self) -> list[str]:
        return [entry.code for entry in self.state.log]


@pytest.fixture
def story() -> Story:
    return Story()


def test_every_kind_has_a_severity_and_tells_what_the_fleet_does_and_the_operator_can() -> None:
    assert set(SEVERITIES) == set(ADVICE) == set(Kind)
    assert all(does and can for does, can in ADVICE.values())


def test_a_dead_agent_and_one_out_of_reach_are_told_apart(story: Story) -> None:
    story.say("merlin")
    story.say("osprey")
    story.state = fold(story.state, [AliveChanged("osprey", False, 0.5), Tick(0.5)])
    assert story.kinds("osprey") == {Kind.AGENT_DEAD}
    for _ in range(5):
        story.pass_second()
    assert story.kinds("merlin") == {Kind.OUT_OF_REACH}


def test_a_token_that_goes_after_a_silent_lease_tells_of_the_link_and_not_of_a_death(story: Story) -> None:
    story.say("merlin")
    for _ in range(3):
        story.pass_second()
    story.state = fold(story.state, [AliveChanged("merlin", False, 3.0), Tick(3.1)])
    assert story.kinds("merlin") == {Kind.OUT_OF_REACH}


def test_a_vehicle_that_gets_nowhere_is_stuck_until_it_moves(story: Story) -> None:
    for _ in range(70):
        story.say("merlin", why="the way is taken")
        story.pass_second()
    assert story.kinds() == {Kind.STUCK}
    assert "the way is taken" in story.state.troubles[0].text
    story.say("merlin", position_cm=(9_000, 5_000, 3_000))
    story.pass_second()
    assert story.kinds() == set()
    assert story.codes()[-2:] == ["stuck", "stuck-over"]


def test_one_that_holds_or_sees_new_ground_is_not_stuck(story: Story) -> None:
    for second in range(70):
        story.say("merlin", first_seen_cells=second)
        story.say("kestrel", stage=Stage.HOLDING)
        story.pass_second()
    assert story.kinds() == set()
    assert story.kinds("kestrel") == set()


def test_a_vehicle_far_from_its_leg_is_diverging_after_a_while(story: Story) -> None:
    for second in range(14):
        story.say("merlin", position_cm=(5_000, 5_000 + 1_000 * second, 3_000))
        story.pass_second()
    assert Kind.ASTRAY in story.kinds()


def test_a_new_leg_ends_the_divergence(story: Story) -> None:
    for second in range(14):
        story.say("merlin", position_cm=(5_000, 5_000 + 1_000 * second, 3_000))
        story.pass_second()
    story.say("merlin", position_cm=(5_000, 17_000, 3_000), leg_end_cm=(5_000, 18_000, 3_000))
    story.pass_second()
    assert Kind.ASTRAY not in story.kinds()


def test_distances_to_legs() -> None:
    assert distance_to_leg_m((500, 300, 0), (0, 0, 0), (1_000, 0, 0)) == 3.0
    assert distance_to_leg_m((-300, 400, 0), (0, 0, 0), (1_000, 0, 0)) == 5.0
    assert distance_to_leg_m((300, 400, 0), (0, 0, 0), (0, 0, 0)) == 5.0


def fly_on_battery(story: Story, stage: Stage, left_at_end: int) -> None:
    for second in range(31):
        charge = round(900 + (left_at_end - 900) * second / 30)
        story.say("merlin", stage=stage, battery_permille=charge, position_cm=(19_000 - second, 19_000, 3_000))
        story.pass_second()


def test_a_battery_that_hardly_brings_it_home_is_a_warning_and_one_that_does_not_an_error(story: Story) -> None:
    fly_on_battery(story, Stage.HOLDING, 890)
    assert story.kinds() == set()
    story = Story()
    fly_on_battery(story, Stage.HOLDING, 540)  # 12 permille a second, home is 24 s away, 150 in reserve
    assert [one.severity for one in story.state.troubles] == [Severity.WARNING]
    story = Story()
    fly_on_battery(story, Stage.RETURNING, 300)
    assert [(one.kind, one.severity) for one in story.state.troubles] == [(Kind.LOW_BATTERY, Severity.ERROR)]


def test_an_agent_that_speaks_while_its_autopilots_clock_stands_has_a_silent_autopilot(story: Story) -> None:
    story.say("merlin", 0.0)
    for _ in range(6):
        story.pass_second()
        story.say("merlin", 0.0)
    assert story.kinds() == {Kind.AUTOPILOT_SILENT}


def test_two_programs_with_one_name_are_told_and_a_restart_is_not(story: Story) -> None:
    second_life = Voice("merlin", boot_id=2)
    story.say("merlin")
    story.state = fold(story.state, [Heard(second_life.status(1.0), 1.0)])
    story.pass_second()
    assert Kind.DUPLICATE not in story.kinds()
    for _ in range(2):
        story.say("merlin")
        story.state = fold(story.state, [Heard(second_life.status(story.now_s), story.now_s)])
        story.pass_second()
    assert Kind.DUPLICATE in story.kinds()


def test_a_clock_that_differs_from_the_others_is_named(story: Story) -> None:
    for _ in range(3):
        for name in NAMES:
            story.say(name, story.now_s + (30.0 if name == "osprey" else 0.0))
        story.pass_second()
    assert story.kinds("osprey") == {Kind.CLOCK_SKEW}
    assert story.kinds("merlin") == set()
    assert "ahead" in story.state.troubles[0].text


def test_pilots_and_refusals_are_conditions_too(story: Story) -> None:
    story.say("merlin", stage=Stage.YIELDED, why="mode loiter, not ordered by this agent")
    story.say("osprey", stage=Stage.REFUSED)
    story.pass_second()
    assert story.kinds() == {Kind.PILOT}
    assert story.kinds("osprey") == {Kind.REFUSED}


def test_acknowledged_stays_so_while_it_lasts_and_comes_back_unseen(story: Story) -> None:
    story.say("merlin", stage=Stage.YIELDED)
    story.pass_second()
    story.state = fold(story.state, [Acknowledged("merlin", "PILOT")])
    story.say("merlin", stage=Stage.YIELDED)
    story.pass_second()
    assert [one.acknowledged for one in story.state.troubles] == [True]
    story.say("merlin")
    story.pass_second()
    story.say("merlin", stage=Stage.YIELDED)
    story.pass_second()
    assert [one.acknowledged for one in story.state.troubles] == [False]


def test_muted_troubles_are_neither_audible_nor_logged(story: Story) -> None:
    story.state = fold(story.state, [Muted("merlin", "STUCK")])
    for _ in range(70):
        story.say("merlin")
        story.pass_second()
    assert [one.kind for one in story.state.troubles] == [Kind.STUCK]
    assert story.state.audible_troubles == ()
    assert "stuck" not in story.codes()
    story.state = fold(story.state, [Muted("merlin", "STUCK", False)])
    assert len(story.state.audible_troubles) == 1
