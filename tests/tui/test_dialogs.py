"""Every key and every dialog: nothing is sent before it was asked, and every answer is shown."""

from __future__ import annotations

import pytest
from textual.pilot import Pilot

from ground_station.screens.command import CommandDialog
from ground_station.screens.help import HelpDialog
from ground_station.screens.leave import LeaveDialog
from tests.fakes.talking_fleet import NAMES, Voice
from tests.tui.conftest import Bench
from vehicle_agent.wire.messages import Outcome, Stage, Verb

Size = tuple[int, int]


async def fly(bench: Bench, pilot: Pilot[None]) -> dict[str, Voice]:
    voices = {name: Voice(name) for name in NAMES}
    stages = dict.fromkeys(NAMES, Stage.WORKING) | {"osprey": Stage.RETURNING}
    await bench.hear(pilot, *(voices[name].status(stage=stages[name]) for name in NAMES))
    return voices


@pytest.mark.parametrize(
    ("key", "verb", "title"),
    [
        ("h", Verb.HOLD, "Hold: all 4 vehicles?"),
        ("r", Verb.RESUME, "Resume: all 4 vehicles?"),
        ("b", Verb.RETURN, "Return home: all 4 vehicles?"),
        ("x", Verb.RETURN, "Return home: all 4 vehicles?"),
    ],
)
async def test_a_command_asks_lists_its_targets_and_is_sent_on_enter(
    size: Size, key: str, verb: Verb, title: str
) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        await fly(bench, pilot)
        await pilot.press(key)
        await bench.drawn(pilot)
        assert isinstance(bench.app.screen, CommandDialog)
        assert title in bench.dialog
        for name in NAMES:
            assert any(line.startswith(f"▸ {name}") for line in bench.dialog.splitlines())
        assert any("osprey" in line and "returning" in line for line in bench.dialog.splitlines())
        assert bench.link.commands() == []
        await pilot.press("enter")
        (command,) = bench.link.commands()
        assert (command.verb, command.targets, command.sender) == (verb, NAMES, "station-0001")


@pytest.mark.parametrize("key", ["escape", "n", "q"])
async def test_a_command_that_is_cancelled_is_not_sent(key: str) -> None:
    bench = Bench()
    async with bench.app.run_test() as pilot:
        await fly(bench, pilot)
        await pilot.press("h", key)
        await pilot.pause()
        assert len(bench.app.screen_stack) == 1
        assert bench.link.commands() == []
        assert bench.app.is_running


async def test_one_vehicle_is_chosen_with_up_and_down_and_all_with_a(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        await fly(bench, pilot)
        await pilot.press("h", "down", "down")
        assert "Hold: kestrel?" in bench.dialog
        await pilot.press("up", "up", "up")
        assert "Hold: merlin?" in bench.dialog
        await pilot.press("a")
        assert "Hold: all 4 vehicles?" in bench.dialog
        await pilot.press("up")
        assert "Hold: harrier?" in bench.dialog
        await pilot.press("enter")
        (command,) = bench.link.commands()
        assert command.targets == ("harrier",)


async def test_each_vehicle_gets_its_own_result(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        voices = await fly(bench, pilot)
        await pilot.press("b", "enter")
        await bench.drawn(pilot)
        assert bench.dialog.count("sent") == 4
        (command,) = bench.link.commands()
        await bench.hear(
            pilot,
            voices["merlin"].answer(command),
            voices["osprey"].answer(command, Outcome.REFUSED, "a pilot flies it"),
        )
        lines = bench.dialog.splitlines()
        assert any("merlin" in line and "accepted" in line for line in lines)
        assert any("osprey" in line and "refused: a pilot flies it" in line for line in lines)
        assert sum("sent" in line for line in lines) == 2
        await bench.pass_time(pilot, 5.5)
        assert sum("timed out" in line for line in bench.dialog.splitlines()) == 2
        await pilot.press("enter")
        assert len(bench.app.screen_stack) == 1
        assert len(bench.link.commands()) == 1
        log = [(entry.source, entry.code) for entry in bench.station.state.log]
        assert ("osprey", "return-refused") in log
        assert ("kestrel", "return-timed-out") in log


async def test_keys_pressed_twice_send_once() -> None:
    bench = Bench()
    async with bench.app.run_test() as pilot:
        await fly(bench, pilot)
        await pilot.press("h", "enter", "enter", "h", "escape")
        assert len(bench.link.commands()) == 1


async def test_two_commands_have_different_numbers() -> None:
    bench = Bench()
    async with bench.app.run_test() as pilot:
        await fly(bench, pilot)
        await pilot.press("h", "enter", "enter", "r", "enter", "enter")
        first, second = bench.link.commands()
        assert first.command_id != second.command_id
        assert first.sequence != second.sequence


async def test_without_a_link_the_dialog_says_that_nothing_was_sent() -> None:
    bench = Bench()
    async with bench.app.run_test() as pilot:
        await bench.connected(pilot)
        bench.station._link = None
        await pilot.press("h", "enter")
        assert "not sent" in bench.dialog


async def test_a_dialog_with_many_vehicles_fits_and_follows_the_choice() -> None:
    bench = Bench(vehicles=40)
    async with bench.app.run_test(size=(80, 24)) as pilot:
        await bench.connected(pilot)
        await pilot.press("h")
        await bench.drawn(pilot)
        await pilot.press(*["down"] * 30)
        await bench.drawn(pilot)
        chosen = bench.station.state.vehicles[29].name
        assert f"▸ {chosen}" in bench.dialog
        assert "enter send" in bench.dialog


async def test_quitting_asks_and_says_that_the_mission_goes_on(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        await fly(bench, pilot)
        await pilot.press("q")
        await bench.drawn(pilot)
        assert isinstance(bench.app.screen, LeaveDialog)
        assert "mission goes on without the dashboard" in bench.dialog.replace("\n", " ")
        await pilot.press("escape")
        assert len(bench.app.screen_stack) == 1
        assert bench.app.is_running
        await pilot.press("q", "enter")
        await bench.until(pilot, lambda: bench.app.return_code == 0)
    assert bench.link.commands() == []


@pytest.mark.parametrize("keys", [("ctrl+c", "ctrl+c"), ("ctrl+q", "ctrl+q"), ("q", "y"), ("q", "q")])
async def test_other_ways_to_leave(keys: tuple[str, str]) -> None:
    bench = Bench()
    async with bench.app.run_test() as pilot:
        await bench.connected(pilot)
        await pilot.press(keys[0])
        assert isinstance(bench.app.screen, LeaveDialog)
        await pilot.press(keys[1])
        await bench.until(pilot, lambda: bench.app.return_code == 0)


@pytest.mark.parametrize("close", ["escape", "enter", "question_mark", "q", "ctrl+c"])
async def test_help_lists_every_key(size: Size, close: str) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        await fly(bench, pilot)
        await pilot.press("question_mark")
        await bench.drawn(pilot)
        assert isinstance(bench.app.screen, HelpDialog)
        pages = [bench.dialog]
        for _ in range(2):
            await pilot.press("space")
            await bench.drawn(pilot)
            pages.append(bench.dialog)
        assert all("esc close" in page for page in pages)
        for word in ("hold", "resume", "return home", "scroll", "leave", "lost", "frontier", "no-fly", "re-plan"):
            assert word in " ".join(pages)
        await pilot.press(close)
        await pilot.pause()
        assert len(bench.app.screen_stack) == 1
        assert bench.app.is_running


async def test_the_dashboard_lives_on_under_a_dialog(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        voices = await fly(bench, pilot)
        await pilot.press("h")
        await bench.hear(pilot, voices["merlin"].status(2.0, Stage.LANDING))
        assert any("merlin" in line and "landing" in line for line in bench.dialog.splitlines())
        assert any("merlin" in line and "landing" in line for line in bench.text("roster").splitlines())


async def test_a_dialog_survives_a_resize() -> None:
    bench = Bench()
    async with bench.app.run_test(size=(120, 40)) as pilot:
        await fly(bench, pilot)
        await pilot.press("h")
        await pilot.resize_terminal(60, 20)
        await bench.drawn(pilot)
        assert "enter send" in bench.dialog
        box = bench.app.screen.query_one("#box").region
        assert box.right <= 60
        assert box.bottom <= 20
