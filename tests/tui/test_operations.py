"""Orders with places, polygons and numbers; proposals; Ctrl-C; replays: each asks before it acts."""

from __future__ import annotations

from pathlib import Path

import pytest
from textual.pilot import Pilot

from ground_station.app import GroundStationApp
from ground_station.player import Player
from ground_station.recording import FILE_NAME, Recording, RecordingWriter
from ground_station.screens.command import CommandDialog
from ground_station.screens.leave import LeaveDialog
from ground_station.screens.proposal import ProposalDialog
from ground_station.station import Station
from ground_station.views.ink import Look
from tests.fakes.talking_fleet import NAMES, ListLink, Voice, small_plan
from tests.tui.conftest import Bench
from vehicle_agent.wire.messages import Orders, Verb, Zone

Size = tuple[int, int]


async def fly(bench: Bench, pilot: Pilot[None]) -> dict[str, Voice]:
    voices = {name: Voice(name) for name in NAMES}
    first = [voice.status(0.0) for voice in voices.values()]
    await bench.hear(pilot, *first, voices["merlin"].delta(range(40), 1.0))
    await bench.hear(
        pilot,
        *(voices[name].status(65.0, position_cm=(3_000 + 4_500 * at, 9_000, 3_000)) for at, name in enumerate(NAMES)),
    )
    return voices


async def press(bench: Bench, pilot: Pilot[None], *keys: str) -> None:
    await pilot.press(*keys)
    await bench.drawn(pilot)


@pytest.mark.parametrize(("key", "verb"), [("o", Verb.GO_TO), ("p", Verb.VISIT)])
async def test_a_vehicle_is_sent_to_the_cursor(size: Size, key: str, verb: Verb) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        await fly(bench, pilot)
        await press(bench, pilot, key)
        assert bench.app._dashboard.window.cursor_en_m is not None
        await press(bench, pilot, "tab", "tab", "shift+right", "up", key)
        assert isinstance(bench.app.screen, CommandDialog)
        assert "kestrel?" in bench.dialog
        await press(bench, pilot, "enter")
        (command,) = bench.link.commands()
        assert (command.verb, command.targets) == (verb, ("kestrel",))
        assert command.point_cm[0] > 10_000


async def test_without_a_choice_the_nearest_vehicle_goes() -> None:
    bench = Bench()
    async with bench.app.run_test(size=(120, 40)) as pilot:
        await fly(bench, pilot)
        await press(bench, pilot, "c", *["shift+right"] * 3, "o", "enter")
        assert bench.link.commands()[0].targets == ("harrier",)


async def draw_square(bench: Bench, pilot: Pilot[None]) -> None:
    await press(bench, pilot, "c", "d", *["right"] * 6, "d", *["up"] * 3, "d", *["left"] * 6, "d", "enter")


@pytest.mark.parametrize(
    ("key", "verb", "title"),
    [("n", Verb.NO_FLY, "No-fly zone 1: all"), ("a", Verb.AREA, "Area: all"), ("s", Verb.SECTOR, "Sector: all")],
)
async def test_a_polygon_is_drawn_with_keys_and_put_to_use(size: Size, key: str, verb: Verb, title: str) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        await fly(bench, pilot)
        await draw_square(bench, pilot)
        assert "A polygon of 4 corners" in bench.dialog
        await press(bench, pilot, key)
        await bench.until(pilot, lambda: isinstance(bench.app.screen, CommandDialog))
        await bench.drawn(pilot)
        assert title in bench.dialog
        await press(bench, pilot, "enter")
        (command,) = bench.link.commands()
        assert (command.verb, command.targets, len(command.polygon_cm)) == (verb, NAMES, 4)


async def test_a_zone_across_a_way_home_tells_what_an_autopilot_alone_would_do(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        await fly(bench, pilot)
        bench.app.ask_for_polygon([(60.0, 40.0), (70.0, 40.0), (70.0, 60.0), (60.0, 60.0)])
        await bench.until(pilot, lambda: len(bench.app.screen_stack) > 1)
        await press(bench, pilot, "n")
        await bench.until(pilot, lambda: "No-fly zone 1" in bench.dialog)
        words = " ".join(bench.dialog.split())
        assert "should an agent die, its autopilot flies straight home through it: osprey" in words
        assert "its autopilot flies straight home" not in bench.text("events")


async def test_corners_are_set_with_the_mouse_too() -> None:
    bench = Bench()
    async with bench.app.run_test(size=(120, 40)) as pilot:
        await fly(bench, pilot)
        for offset in ((5, 5), (20, 5), (20, 15)):
            await pilot.click("#map", offset=offset)
            await press(bench, pilot, "d")
        assert len(bench.app._dashboard.window.drawn_en_m) == 3
        await press(bench, pilot, "escape")
        assert bench.app._dashboard.window.drawn_en_m == ()


async def test_a_crossed_polygon_is_not_taken() -> None:
    bench = Bench()
    async with bench.app.run_test(size=(120, 40)) as pilot:
        await fly(bench, pilot)
        for offset in ((5, 5), (20, 15), (20, 5), (5, 15)):
            await pilot.click("#map", offset=offset)
            await press(bench, pilot, "d")
        await press(bench, pilot, "enter")
        assert "must not cross" in bench.dialog
        assert bench.link.commands() == []


async def test_zones_are_lifted_and_the_area_made_whole(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        await fly(bench, pilot)
        zone = Zone(3, ((0, 0), (9_000, 0), (0, 9_000)))
        await bench.hear(pilot, Orders(sender="merlin", boot_id=1, sequence=80, stamp_ms=1, no_fly=(zone,)))
        await press(bench, pilot, "a")
        assert "lift no-fly zone 3" in bench.dialog
        await press(bench, pilot, "1")
        await bench.until(pilot, lambda: isinstance(bench.app.screen, CommandDialog))
        await press(bench, pilot, "enter", "escape", "a", "w")
        await bench.until(pilot, lambda: isinstance(bench.app.screen, CommandDialog))
        await press(bench, pilot, "enter")
        lift, area = bench.link.commands()
        assert (lift.verb, lift.number, lift.polygon_cm) == (Verb.NO_FLY, 3, ())
        assert (area.verb, area.polygon_cm) == (Verb.AREA, ())


async def test_an_area_is_imported_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "area.wkt"
    path.write_text("POLYGON ((8.0 47.0, 8.001 47.0, 8.001 47.001))")
    bench = Bench()
    async with bench.app.run_test(size=(120, 40)) as pilot:
        await fly(bench, pilot)
        await press(bench, pilot, "a", "i")
        await pilot.pause()
        await pilot.press(*"nowhere")
        await press(bench, pilot, "enter")
        assert "No such file" in bench.dialog
        await press(bench, pilot, *["backspace"] * 7)
        for character in str(path):
            await pilot.press(
                {"/": "slash", ".": "full_stop", "-": "minus", "_": "underscore"}.get(character, character)
            )
        await press(bench, pilot, "enter")
        await pilot.pause()
        assert "A polygon of 3 corners" in bench.dialog
        await press(bench, pilot, "a")
        await bench.until(pilot, lambda: isinstance(bench.app.screen, CommandDialog))
        await press(bench, pilot, "enter")
        assert bench.link.commands()[0].verb is Verb.AREA


async def test_a_speed_limit_is_typed(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        await fly(bench, pilot)
        await press(bench, pilot, "k", "x", "enter")
        assert "write a number" in bench.dialog
        await press(bench, pilot, "backspace", "7", "full_stop", "5", "enter")
        await bench.drawn(pilot)
        assert "no faster than 7.5 m/s" in bench.dialog
        await press(bench, pilot, "enter")
        assert bench.link.commands()[0].number == 750


async def test_a_loss_is_proposed_at_once_and_sent_on_a_key(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        voices = await fly(bench, pilot)
        bench.link.alive_changes.append(("osprey", False))
        await bench.until(pilot, lambda: "RE-PLAN: osprey is lost" in bench.text("banner"))
        assert "LOST osprey" in bench.text("banner")
        await press(bench, pilot, "n")
        assert isinstance(bench.app.screen, ProposalDialog)
        assert "Release osprey" in bench.dialog
        assert "before" in bench.dialog
        assert bench.link.commands() == []
        await press(bench, pilot, "enter")
        (command,) = bench.link.commands()
        assert (command.verb, command.subject) == (Verb.RELEASE, "osprey")
        await bench.hear(pilot, voices["merlin"].answer(command))
        assert any("merlin" in line and "accepted" in line for line in bench.dialog.splitlines())
        await press(bench, pilot, "enter")
        assert len(bench.link.commands()) == 1
        assert "RE-PLAN" not in bench.text("banner")


async def test_a_proposal_can_be_left_to_the_agents() -> None:
    bench = Bench()
    async with bench.app.run_test(size=(80, 24)) as pilot:
        await fly(bench, pilot)
        bench.link.alive_changes.append(("osprey", False))
        await bench.until(pilot, lambda: bench.station.proposal is not None)
        await press(bench, pilot, "n", "n")
        assert bench.station.proposal is None
        assert bench.link.commands() == []


async def test_ctrl_c_stops_the_whole_run_after_a_second_thought_and_q_only_leaves() -> None:
    for keys, code in ((("ctrl+c", "enter"), 130), (("ctrl+c", "ctrl+c"), 130), (("q", "enter"), 0)):
        bench = Bench(stops_mission=True)
        async with bench.app.run_test(size=(80, 24)) as pilot:
            await fly(bench, pilot)
            await press(bench, pilot, keys[0])
            assert isinstance(bench.app.screen, LeaveDialog)
            assert ("Stop the whole mission" in bench.dialog) == (code == 130)
            await pilot.press(keys[1])
            await bench.until(pilot, lambda code=code, bench=bench: bench.app.return_code == code)  # type: ignore[misc]


async def test_a_replay_pauses_seeks_steps_and_sends_nothing(tmp_path: Path, size: Size) -> None:
    recording = RecordingWriter(tmp_path / FILE_NAME)
    station, link = Station(small_plan(), "station-0001", 9, 0.0, recording=recording), ListLink()
    station.attach(link)
    voices = {name: Voice(name) for name in NAMES}
    for second in range(120):
        link.arriving += [voice.status(second) for voice in voices.values()]
        link.arriving.append(voices["merlin"].delta(range(3 * second, 3 * second + 3), second))
        station.step(float(second))
    station.close()
    now = [0.0]
    app = GroundStationApp(Player(Recording(tmp_path)), None, Look(), clock=lambda: now[0])
    async with app.run_test(size=size) as pilot:
        player = app.station
        assert isinstance(player, Player)
        await pilot.press("space", "right_square_bracket", "right_square_bracket", "right_square_bracket")
        await pilot.pause()
        assert player.position_s == pytest.approx(30.0, abs=2.0)
        assert not player.playing
        await pilot.press("left_square_bracket", "full_stop", "greater_than_sign", "greater_than_sign")
        assert player.position_s == pytest.approx(21.0, abs=2.0)
        assert player.speed == 4.0
        await pilot.press("space")
        now[0] += 60.0
        player.step(now[0])
        now[0] += 60.0
        app.draw()
        await pilot.pause()
        text = app.screen.query_one("#banner").text  # type: ignore[attr-defined]
        assert "REPLAY" in text
        await pilot.press("h", "enter")
        await pilot.pause()
        assert "not sent" in app.screen.query_one("#content").text  # type: ignore[attr-defined]
