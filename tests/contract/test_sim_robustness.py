"""A hundred thousand hostile frames: no exception, no hang, memory flat, and without the key nothing is obeyed."""

from __future__ import annotations

import random

import pytest

from missions.bench.conformance import three_vehicles
from missions.bench.interview import dialect
from missions.bench.mutations import Mutations
from missions.bench.robustness import Target, attack_open, attack_signing

FRAMES = 50_000


@pytest.mark.parametrize("attack", [attack_open, attack_signing])
def test_hostile_frames_do_no_harm(attack: object) -> None:
    report = attack(three_vehicles(), FRAMES, random.Random(11), lambda count: None)  # type: ignore[operator]
    assert (report.first_exception, report.first_obeyed) == ("", "")
    assert (report.exceptions, report.obeyed, report.served) == (0, 0, True)
    assert report.refused > FRAMES // 10
    assert report.growth_bytes < 20_000_000


def test_the_frames_are_hostile_but_partly_well_formed() -> None:
    """Without well-formed frames nothing behind the parser would be tried."""
    mutations = Mutations(random.Random(2), 1, (400, 511))
    ears = dialect.MAVLink(None)
    ears.robust_parsing = True
    heard = [message for _ in range(2_000) for message in ears.parse_buffer(mutations.frame()) or ()]
    kinds = {message.get_type() for message in heard}
    assert "BAD_DATA" in kinds
    assert {"COMMAND_LONG", "COMMAND_INT", "MISSION_ITEM_INT", "PARAM_SET", "FILE_TRANSFER_PROTOCOL"} <= kinds


def test_intact_frames_are_intact() -> None:
    mutations = Mutations(random.Random(3), 1, ())
    for _ in range(500):
        ears = dialect.MAVLink(None)
        ears.robust_parsing = True
        (message,) = ears.parse_buffer(mutations.intact())
        assert message.get_type() != "BAD_DATA"


def test_an_attack_that_succeeds_would_be_seen() -> None:
    """The signing bench counts what is obeyed; a vehicle without a key obeys."""
    target = Target(three_vehicles())
    before = target.state()
    target.vehicle.set_parameter("RTL_ALT", 9_999)
    assert target.state() != before
