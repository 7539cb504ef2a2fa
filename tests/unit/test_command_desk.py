"""Commands: for whom, how often, when, and how fresh."""

from __future__ import annotations

import pytest

from vehicle_agent.behaviour.command_desk import STALE_MS, CommandDesk
from vehicle_agent.wire.messages import Command, Outcome, Stage, Verb


def command(
    verb: Verb = Verb.HOLD,
    command_id: int = 1,
    targets: tuple[str, ...] = ("ada",),
    boot_id: int = 5,
    stamp_ms: int = 1_000_000,
) -> Command:
    return Command(
        sender="station-1",
        boot_id=boot_id,
        sequence=command_id,
        stamp_ms=stamp_ms,
        command_id=command_id,
        verb=verb,
        targets=targets,
    )


def test_only_the_targets_answer_and_only_once() -> None:
    desk = CommandDesk("ada")
    assert desk.judge(command(targets=("bob",)), Stage.WORKING) is None
    assert desk.judge(command(targets=("bob", "ada")), Stage.WORKING) == (Outcome.ACCEPTED, "")
    assert desk.judge(command(targets=("bob", "ada")), Stage.WORKING) is None


def test_another_number_and_a_restarted_station_are_other_commands() -> None:
    desk = CommandDesk("ada")
    assert desk.judge(command(), Stage.WORKING)
    assert desk.judge(command(command_id=2), Stage.WORKING)
    assert desk.judge(command(boot_id=6), Stage.WORKING)


@pytest.mark.parametrize(
    ("verb", "stages"),
    [
        (Verb.HOLD, {Stage.WORKING, Stage.RETURNING, Stage.LANDING, Stage.YIELDED}),
        (Verb.RESUME, {Stage.HOLDING, Stage.RETURNING, Stage.YIELDED}),
        (Verb.RETURN, {Stage.TAKING_OFF, Stage.WORKING, Stage.HOLDING, Stage.YIELDED}),
        (Verb.LAND, {Stage.TAKING_OFF, Stage.WORKING, Stage.HOLDING, Stage.RETURNING, Stage.YIELDED}),
    ],
)
def test_each_command_has_its_stages(verb: Verb, stages: set[Stage]) -> None:
    for stage in Stage:
        answer = CommandDesk("ada").judge(command(verb), stage)
        assert answer is not None
        outcome, reason = answer
        assert (outcome is Outcome.ACCEPTED) == (stage in stages)
        assert bool(reason) == (outcome is Outcome.REFUSED)


def test_a_refused_command_is_not_obeyed_when_it_comes_again() -> None:
    desk = CommandDesk("ada")
    answer = desk.judge(command(), Stage.ARMING)
    assert answer is not None
    assert answer[0] is Outcome.REFUSED
    assert desk.judge(command(), Stage.WORKING) is None


def test_what_was_said_to_the_agent_before_this_one_is_not_obeyed() -> None:
    began_ms = 1_000_000
    stale = CommandDesk("ada").judge(command(stamp_ms=began_ms - STALE_MS - 1), Stage.WORKING, began_ms)
    assert stale is not None
    assert stale[0] is Outcome.REFUSED
    fresh = CommandDesk("ada").judge(command(stamp_ms=began_ms - STALE_MS + 1), Stage.WORKING, began_ms)
    assert fresh == (Outcome.ACCEPTED, "")
