"""Every named condition from the bytes on the wire to the words on the screen, and what wrong bytes look like there."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
import pytest
from textual.pilot import Pilot

from ground_station.conditions import ADVICE, Kind
from ground_station.inputs import AutopilotHeard
from tests.fakes.talking_fleet import NAMES, Voice
from tests.tui.conftest import Bench
from vehicle_agent.wire.codec import Codec
from vehicle_agent.wire.messages import AnyMessage, Stage

CODEC = Codec()


class Teller:
    """Tells a story second by second, every word as bytes."""

    def __init__(self, bench: Bench) -> None:
        self.bench = bench
        self.voices = {name: Voice(name) for name in NAMES}
        self.began_s = bench.now_s

    @property
    def second(self) -> float:
        return self.bench.now_s - self.began_s

    def say(self, name: str = "merlin", elapsed_s: float | None = None, **changes: Any) -> None:
        self.hear(self.voices[name].status(self.second if elapsed_s is None else elapsed_s, **changes))

    def hear(self, message: AnyMessage) -> None:
        decoded = CODEC.decode(CODEC.encode(message))
        assert decoded == message
        self.bench.link.arriving.append(decoded)

    def pass_second(self) -> None:
        self.bench.now_s += 1.0
        self.bench.station.step(self.bench.now_s)


def die(teller: Teller) -> None:
    teller.say()
    teller.pass_second()
    teller.bench.link.alive_changes.append(("merlin", False))
    teller.pass_second()


def fall_silent(teller: Teller) -> None:
    teller.say()
    for _ in range(6):
        teller.pass_second()


def be_overdue(teller: Teller) -> None:
    teller.say()
    for _ in range(4):
        teller.pass_second()


def be_two(teller: Teller) -> None:
    other = Voice("merlin", boot_id=2)
    for _ in range(3):
        teller.say()
        teller.hear(other.status(teller.second))
        teller.pass_second()


def share_an_id(teller: Teller) -> None:
    teller.say()
    now_s = teller.bench.now_s
    teller.bench.station.take([AutopilotHeard(1, True, False, source, now_s) for source in ("udp a:1", "udp b:2")])
    teller.pass_second()


def lose_the_autopilot(teller: Teller) -> None:
    for _ in range(7):
        teller.say(elapsed_s=0.0)
        teller.pass_second()


def run_low(teller: Teller) -> None:
    for second in range(31):
        place = (19_000 - second, 19_000, 3_000)
        teller.say(stage=Stage.HOLDING, battery_permille=900 - 12 * second, position_cm=place)
        teller.pass_second()


def stray(teller: Teller) -> None:
    for second in range(14):
        teller.say(position_cm=(5_000, 5_000 + 1_000 * second, 3_000))
        teller.pass_second()


def stand(teller: Teller) -> None:
    for _ in range(70):
        teller.say(why="the way is taken")
        teller.pass_second()


def be_ahead(teller: Teller) -> None:
    for _ in range(3):
        for name in NAMES:
            teller.say(name, teller.second + (30.0 if name == "merlin" else 0.0))
        teller.pass_second()


def yield_to_a_pilot(teller: Teller) -> None:
    teller.say(stage=Stage.YIELDED, why="mode loiter, not ordered by this agent")
    teller.pass_second()


def refuse(teller: Teller) -> None:
    teller.say(stage=Stage.REFUSED, why="another program speaks with its id")
    teller.pass_second()


STORIES: dict[Kind, Callable[[Teller], None]] = {
    Kind.AGENT_DEAD: die,
    Kind.OUT_OF_REACH: fall_silent,
    Kind.SUSPECT: be_overdue,
    Kind.DUPLICATE: be_two,
    Kind.DUPLICATE_ID: share_an_id,
    Kind.AUTOPILOT_SILENT: lose_the_autopilot,
    Kind.LOW_BATTERY: run_low,
    Kind.ASTRAY: stray,
    Kind.STUCK: stand,
    Kind.CLOCK_SKEW: be_ahead,
    Kind.PILOT: yield_to_a_pilot,
    Kind.REFUSED: refuse,
}


@pytest.mark.parametrize("kind", Kind, ids=lambda kind: kind.name.lower())
async def test_a_condition_is_named_in_the_roster_and_explained(kind: Kind, size: tuple[int, int]) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        await bench.connected(pilot)
        STORIES[kind](Teller(bench))
        await bench.drawn(pilot)
        assert f"{kind.value}:" in bench.text("roster")
        await shown(bench, pilot)
        words = " ".join(bench.dialog.split())
        assert kind.value in words
        for advice in ADVICE[kind]:
            assert advice in words


async def shown(bench: Bench, pilot: Pilot[None]) -> None:
    await pilot.press("t")
    await bench.until(pilot, lambda: len(bench.app.screen_stack) > 1)
    await bench.drawn(pilot)


FOREIGN = {
    "an unknown kind of message": lambda status: [99, *status[1:]],
    "a name of 200 characters": lambda status: [status[0], "x" * 200, *status[2:]],
    "a name with control codes": lambda status: [status[0], "mer\x1b[2Jlin", *status[2:]],
    "a stage from the future": lambda status: [*status[:5], 77, *status[6:]],
}


@pytest.mark.parametrize("what", FOREIGN)
async def test_what_a_newer_or_hostile_program_says_is_counted_and_never_shown(what: str) -> None:
    plain = msgspec.msgpack.decode(CODEC.encode(Voice("merlin").status()))
    assert CODEC.decode(msgspec.msgpack.encode(FOREIGN[what](plain))) is None
    bench = Bench()
    async with bench.app.run_test(size=(80, 24)) as pilot:
        await bench.connected(pilot)
        bench.link.counters.undecodable += 1
        await bench.hear(pilot, Voice("kestrel").status())
        assert "1 bad messages dropped" in bench.text("events")
        assert "x" * 10 not in bench.text("roster")


def test_fields_that_a_newer_program_adds_are_passed_over() -> None:
    status = Voice("merlin").status()
    longer = [*msgspec.msgpack.decode(CODEC.encode(status)), "a field from the future"]
    assert CODEC.decode(msgspec.msgpack.encode(longer)) == status
