"""What the dashboard shows, at the sizes of a small and a large terminal."""

from __future__ import annotations

from pathlib import Path

import pytest

from ground_station.views.ink import Look
from ground_station.widgets.lines import Lines
from tests.fakes.talking_fleet import NAMES, Voice
from tests.tui.conftest import Bench
from vehicle_agent.wire.messages import Severity, Stage

Size = tuple[int, int]


async def test_before_any_message_it_says_for_whom_it_waits(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        await bench.connected(pilot)
        await bench.pass_time(pilot, 7.0)
        assert "waiting for vehicles: merlin, kestrel, osprey, harrier (7 s)" in bench.text("banner")
        assert "4 awaited" in bench.text("header")


async def test_a_notice_is_shown_until_a_vehicle_is_live_and_read_anew(size: Size, tmp_path: Path) -> None:
    file = tmp_path / "notice"
    bench = Bench(notice_file=file)
    async with bench.app.run_test(size=size) as pilot:
        await bench.connected(pilot)
        file.write_text("starting: compiling kernels (first start only)\n")
        await bench.drawn(pilot)
        assert "starting: compiling kernels (first start only)" in bench.text("banner")
        file.write_text("starting: vehicles\n")
        await bench.drawn(pilot)
        assert "starting: vehicles" in bench.text("banner")
        await bench.hear(pilot, Voice("merlin").status())
        assert "starting" not in bench.text("banner")


async def test_header_roster_and_events_tell_what_was_heard(size: Size) -> None:
    bench = Bench()
    merlin = Voice("merlin")
    async with bench.app.run_test(size=size) as pilot:
        await bench.hear(
            pilot,
            merlin.event("climbing to 60 m", code="took-off"),
            merlin.delta(range(100), 1.0),
            merlin.status(65.0),
            Voice("kestrel").status(65.0, Stage.HOLDING, battery_permille=90),
        )
        assert "meadow" in bench.text("header")
        assert "0:01:05" in bench.text("header")
        assert "25.0% seen" in bench.text("header")
        assert "2 live" in bench.text("header")
        roster = bench.text("roster").splitlines()
        line = next(line for line in roster if "merlin" in line)
        assert "● working" in line
        assert "guided" in line
        assert "87%" in line
        reason = roster[roster.index(line) + 1]
        assert "25.0%" in reason
        assert "frontier 40 m E" in reason
        assert any("kestrel" in line and "■ holding" in line and "9%" in line for line in roster)
        assert "climbing to 60 m" in bench.text("events")
        assert "coverage 25.0%" in bench.text("curve")


async def test_the_map_shows_ground_vehicles_goals_and_homes(size: Size) -> None:
    bench = Bench()
    merlin = Voice("merlin")
    async with bench.app.run_test(size=size) as pilot:
        await bench.hear(pilot, merlin.delta(range(200)), merlin.status(1.0), merlin.claim())
        drawn = bench.text("map")
        assert "1→" in drawn
        assert "◇" in drawn
        assert "⌂" in drawn
        assert "▀" in drawn
        assert "400" in bench.text("caption")


async def test_a_lost_vehicle_is_shown_without_waiting_for_the_next_drawing(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        await bench.hear(pilot, *(Voice(name).status() for name in NAMES))
        bench.link.alive_changes.append(("osprey", False))
        await bench.until(pilot, lambda: "LOST osprey" in bench.text("banner"))
        assert "1 lost" in bench.text("header")
        assert any("osprey" in line and "✖ lost" in line for line in bench.text("roster").splitlines())
        assert "3✖" in bench.text("map")


async def test_silence_is_shown_as_suspect_then_lost(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        await bench.hear(pilot, Voice("merlin").status())
        await bench.pass_time(pilot, 2.5)
        assert "1 suspect" in bench.text("header")
        assert "◐" in bench.text("roster")
        await bench.pass_time(pilot, 2.5)
        assert "LOST merlin" in bench.text("banner")


async def test_it_leaves_by_itself_when_asked_to_and_all_are_done() -> None:
    bench = Bench(exit_when_done=True)
    async with bench.app.run_test() as pilot:
        await bench.hear(pilot, *(Voice(name).status(stage=Stage.DONE) for name in NAMES))
        assert "ended" in bench.text("banner")
        assert bench.app.is_running
        bench.now_s += 3.0
        await bench.until(pilot, lambda: bench.app.return_code == 0)


async def test_a_link_that_cannot_be_opened_ends_the_dashboard_with_the_reason() -> None:
    bench = Bench(refusal="tcp/nowhere:1: not an address of this machine; correct radio.endpoint_host")
    async with bench.app.run_test() as pilot:
        await bench.until(pilot, lambda: bool(bench.app.refusal))
    assert bench.app.refusal.startswith("tcp/nowhere:1")


async def test_too_small_a_terminal_says_so_and_recovers() -> None:
    bench = Bench()
    async with bench.app.run_test(size=(80, 24)) as pilot:
        await bench.hear(pilot, Voice("merlin").status())
        await pilot.resize_terminal(50, 12)
        await bench.until(pilot, lambda: "50x12: enlarge to 60x20" in bench.text("too-small"))
        assert not bench.app.screen_stack[0].query_one("#map").display or bench.app.screen.has_class("too-small")
        await pilot.press("h")
        assert len(bench.app.screen_stack) == 1
        await pilot.resize_terminal(20, 5)
        await bench.drawn(pilot)
        await pilot.resize_terminal(100, 30)
        await bench.drawn(pilot)
        assert not bench.app.screen.has_class("too-small")
        assert "1→" in bench.text("map")


@pytest.mark.parametrize("target", [(60, 20), (80, 24), (132, 43), (200, 50)])
async def test_every_line_fits_after_a_resize(target: Size) -> None:
    bench = Bench(vehicles=8)
    async with bench.app.run_test(size=(80, 24)) as pilot:
        await bench.hear(pilot, *(Voice(vehicle.name).status() for vehicle in bench.station.state.vehicles))
        await pilot.resize_terminal(*target)
        await bench.drawn(pilot)
        for pane in bench.app.screen.query(Lines):
            if pane.id == "too-small":
                continue
            assert pane.size.height > 0, pane.id
            assert pane.region.right <= target[0]
            assert all(len(line) <= pane.size.width for line in pane.text.splitlines())
        roster = bench.text("roster")
        assert all(vehicle.name in roster for vehicle in bench.station.state.vehicles)


async def test_with_more_vehicles_than_lines_the_troubled_ones_come_first() -> None:
    bench = Bench(vehicles=40)
    names = [vehicle.name for vehicle in bench.station.state.vehicles]
    async with bench.app.run_test(size=(80, 24)) as pilot:
        await bench.hear(pilot, *(Voice(name).status() for name in names))
        bench.link.alive_changes.append((names[-1], False))
        await bench.until(pilot, lambda: "1 lost" in bench.text("header"))
        lines = bench.text("roster").splitlines()
        assert "lost" in lines[1]
        assert "more, less troubled" in lines[-1]


async def test_the_event_log_scrolls_back_and_follows_again(size: Size) -> None:
    bench = Bench()
    merlin = Voice("merlin")
    async with bench.app.run_test(size=size) as pilot:
        await bench.hear(pilot, *(merlin.event(f"entry {number:03d}", number) for number in range(60)))
        assert "entry 059" in bench.text("events")
        for _ in range(4):
            await pilot.press("pageup")
        assert "entry 059" not in bench.text("events")
        assert "20 newer below" in bench.text("events")
        shown = bench.text("events").splitlines()[1:]
        await bench.hear(pilot, merlin.event("entry 060", 60))
        assert bench.text("events").splitlines()[1:] == shown
        await pilot.press("end")
        assert "entry 060" in bench.text("events")


async def test_hostile_text_is_shown_harmlessly(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        merlin = Voice("merlin")
        evil = "\x1b[2J[red]x[/red]\x07"
        await bench.hear(pilot, merlin.status(why=evil), merlin.event(evil, severity=Severity.CRITICAL))
        for pane in ("roster", "events"):
            assert "\x1b" not in bench.text(pane)
            assert "[red]x[/red]" in bench.text(pane)


async def test_an_unchanged_picture_sends_nothing(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        await bench.hear(pilot, Voice("merlin").status())
        refreshed: list[str | None] = []
        for pane in bench.app.screen.query(Lines):
            pane.refresh = lambda *regions, name=pane.id, **_: refreshed.append(name)  # type: ignore[method-assign, misc, assignment]
        bench.app.draw()
        assert refreshed == []


@pytest.mark.parametrize("look", [Look(unicode=False), Look(unicode=False, colour=False), Look(colour=False)])
async def test_without_unicode_or_colour_everything_is_still_told(look: Look, size: Size) -> None:
    bench = Bench(look=look)
    merlin = Voice("merlin")
    async with bench.app.run_test(size=size) as pilot:
        await bench.hear(
            pilot, merlin.delta(range(200)), merlin.status(30.0), merlin.claim(), merlin.event("größer"),
            Voice("kestrel").status(30.0, Stage.HOLDING, position_cm=(18_000, 2_000, 3_000)),
        )  # fmt: skip
        svg = bench.app.export_screenshot()
        styles = [style for line in bench.app.screen._compositor.render_strips() for _, style, _ in line]
        assert look.colour or all(
            colour is None or colour.is_default
            for style in styles
            if style is not None
            for colour in (style.color, style.bgcolor)
        )
        for pane in bench.app.screen.query(Lines):
            assert look.unicode or pane.text.replace("ö", "?").replace("ß", "?").isascii(), pane.id
        drawn = bench.text("map")
        assert "1→" in drawn if look.unicode else "1>" in drawn
        assert "." in drawn
        assert "~" in drawn
        assert "working" in bench.text("roster")
        assert "holding" in bench.text("roster")
        if not look.unicode:
            assert "größer" not in svg
