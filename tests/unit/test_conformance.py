"""The simulated vehicles answer as the recorded ones, and the comparison would notice if they did not."""

from __future__ import annotations

import pytest

from missions.bench.conformance import FIRMWARES, compare, examine
from missions.bench.golden_answers import recorded_answers, reply_of
from missions.bench.interview import dialect
from missions.bench.questions import Answered


@pytest.mark.parametrize("firmware", FIRMWARES)
def test_every_answer_agrees_or_differs_for_a_known_reason(firmware: str) -> None:
    verdicts = examine(firmware)
    assert len(verdicts) == 65
    assert [(v.question, v.difference) for v in verdicts if not v.passes] == []
    assert sum(v.agrees for v in verdicts) >= 62


@pytest.mark.parametrize("firmware", FIRMWARES)
def test_the_recordings_are_read_whole(firmware: str) -> None:
    answers = recorded_answers(firmware)
    assert len(answers) == 65
    assert answers["HEARTBEAT"].replies[0].fields["autopilot"] == "3"
    assert answers["MISSION with invalid lat"].replies[0].fields["type"] == "10"
    assert answers["PING"].replies == ()
    assert answers["CMD 410 [0, 0]"].replies[0].kind == "HOME_POSITION"
    assert len(answers["after REQUEST_DATA_STREAM"].rates) > 10


def test_cut_off_messages_lose_only_their_last_field() -> None:
    reply = reply_of("HOME_POSITION {latitude : 473977420, q : [nan, nan, nan, nan], approach_x : 0.0,  ")
    assert reply is not None
    assert reply.fields == {"latitude": "473977420", "q": "[nan, nan, nan, nan]"}
    assert reply_of("no message") is None


def acknowledgement(command: int, result: int) -> object:
    return dialect.MAVLink_command_ack_message(command, result, 0, 0, 255, 190)


@pytest.mark.parametrize(
    ("question", "messages"),
    [
        ("unsupported command DO_ORBIT", (acknowledgement(34, 4),)),
        ("unsupported command DO_ORBIT", ()),
        ("to wrong sysid 77", (acknowledgement(512, 0),)),
        ("REQUEST_MESSAGE AVAILABLE_MODES", (acknowledgement(512, 0),)),
        ("RALLY upload", (dialect.MAVLink_mission_ack_message(255, 190, 0, 0),)),
    ],
)
def test_a_wrong_answer_is_noticed(question: str, messages: tuple[object, ...]) -> None:
    verdict = compare("copter", Answered(question, messages), recorded_answers("copter")[question])
    assert not verdict.passes
