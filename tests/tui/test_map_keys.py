"""Looking at the map, choosing vehicles, filtering events: every key of the dashboard that sends nothing."""

from __future__ import annotations

import pytest
from textual.pilot import Pilot

from ground_station.screens.layers import LayersDialog
from ground_station.screens.troubles import TroublesDialog
from ground_station.views.ink import Look
from ground_station.views.window import Ground, Layer, scale_bar
from tests.fakes.talking_fleet import NAMES, Voice
from tests.tui.conftest import Bench
from vehicle_agent.wire.messages import Orders, Severity, Stage, Zone

Size = tuple[int, int]


async def fly(bench: Bench, pilot: Pilot[None]) -> dict[str, Voice]:
    voices = {name: Voice(name) for name in NAMES}
    await bench.hear(
        pilot,
        voices["merlin"].delta(range(200), 3.0),
        *(voices[name].status(65.0, position_cm=(4_000 + 4_000 * at, 5_000, 3_000)) for at, name in enumerate(NAMES)),
    )
    return voices


async def press(bench: Bench, pilot: Pilot[None], *keys: str) -> None:
    await pilot.press(*keys)
    await bench.drawn(pilot)


async def test_zooming_and_panning_move_the_view_and_zero_shows_all_again(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        await fly(bench, pilot)
        whole, scale = bench.app._dashboard._raster.view, bench.text("caption")
        await press(bench, pilot, "plus", "plus", "plus", "plus")
        near = bench.app._dashboard._raster.view
        assert near.pixel_width_m < 0.3 * whole.pixel_width_m
        assert bench.text("caption") != scale
        await press(bench, pilot, "right")
        assert bench.app._dashboard._raster.view.west_m == pytest.approx(
            near.west_m + 0.25 * near.width * near.pixel_width_m
        )
        await press(bench, pilot, "0")
        assert bench.app._dashboard._raster.view == whole


async def test_the_view_follows_the_chosen_vehicle(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        voices = await fly(bench, pilot)
        await press(bench, pilot, "tab", "tab", "f")
        assert bench.app._dashboard.window.follow == "kestrel"
        for second in range(5):
            place = (8_000 + 2_000 * second, 5_000 + 3_000 * second, 3_000)
            await bench.hear(pilot, voices["kestrel"].status(66.0 + second, position_cm=place))
            assert "2→" in bench.text("map")
        await press(bench, pilot, "f")
        assert bench.app._dashboard.window.follow == ""


async def test_the_cursor_tells_place_ground_and_who_saw_it_first_and_when(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        await fly(bench, pilot)
        await press(bench, pilot, "tab", "c")
        text = bench.text("curve")
        assert "47.000" in text
        assert "8.000" in text
        assert "400 m amsl" in text
        assert "first seen 0:00:00 by merlin" in text
        assert "┼" in bench.text("map")
        await press(bench, pilot, *["shift+right"] * 4)
        assert "not seen yet" in bench.text("curve")
        await press(bench, pilot, "escape")
        assert "coverage" in bench.text("curve")
        assert "┼" not in bench.text("map")


async def test_a_click_puts_the_cursor_there() -> None:
    bench = Bench()
    async with bench.app.run_test(size=(120, 40)) as pilot:
        await fly(bench, pilot)
        await pilot.click("#map", offset=(5, 5))
        await bench.drawn(pilot)
        assert bench.app._dashboard.window.cursor_en_m is not None
        assert bench.text("map").splitlines()[5][5] == "┼"


async def test_every_ground_colouring_and_layer_can_be_chosen(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        voices = await fly(bench, pilot)
        await bench.hear(pilot, voices["merlin"].claim())
        captions = set()
        for _ in Ground:
            captions.add(bench.text("caption"))
            await press(bench, pilot, "g")
        assert len(captions) == len(Ground)
        await press(bench, pilot, "l")
        assert isinstance(bench.app.screen, LayersDialog)
        for number, layer in enumerate(Layer, 1):
            assert f"{number} [{' ' if layer is Layer.FENCE else 'x'}] {layer.value}" in bench.dialog
        assert "◇" in bench.text("map")
        await press(bench, pilot, "2", "g")
        assert "◇" not in bench.text("map")
        assert "(*) observed" in bench.dialog
        await press(bench, pilot, "escape")
        assert len(bench.app.screen_stack) == 1


@pytest.mark.parametrize("look", [Look(), Look(unicode=False), Look(unicode=False, colour=False)])
async def test_zones_and_fences_are_drawn_in_every_look(look: Look) -> None:
    bench = Bench(look=look)
    async with bench.app.run_test(size=(120, 40)) as pilot:
        voices = await fly(bench, pilot)
        voices["merlin"].sequence += 1
        corners = ((12_000, 12_000), (18_000, 12_000), (18_000, 18_000), (12_000, 18_000))
        orders = Orders(sender="merlin", boot_id=1, sequence=90, stamp_ms=1, no_fly=(Zone(1, corners),))
        before = bench.app.export_screenshot()
        await bench.hear(pilot, orders)
        await press(bench, pilot, "l", "6", "escape")
        assert bench.app.export_screenshot() != before
        if not look.unicode:
            assert "#" in bench.text("map")
            assert "/" in bench.text("map")


async def test_curves_by_vehicle_name_the_best(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        await fly(bench, pilot)
        await press(bench, pilot, "v")
        assert "seen first: merlin 50.0%" in bench.text("curve")
        await press(bench, pilot, "v")
        assert "coverage 50.0%" in bench.text("curve")


async def test_events_are_filtered_by_severity_and_vehicle(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        voices = await fly(bench, pilot)
        await bench.hear(
            pilot,
            voices["merlin"].event("an old note", 1.0),
            voices["kestrel"].event("a warning", 2.0, Severity.WARNING),
            voices["merlin"].event("an error", 3.0, Severity.ERROR),
        )
        await press(bench, pilot, "e", "e")
        assert "(warnings only)" in bench.text("events")
        assert "an old note" not in bench.text("events")
        assert "a warning" in bench.text("events")
        await press(bench, pilot, "tab", "s")
        assert "(warnings merlin only)" in bench.text("events")
        assert "a warning" not in bench.text("events")
        assert "an error" in bench.text("events")
        await press(bench, pilot, "escape")
        assert "an old note" in bench.text("events")


async def test_the_roster_is_sorted_by_trouble_and_tells_it(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        voices = await fly(bench, pilot)
        await bench.hear(pilot, voices["harrier"].status(66.0, Stage.YIELDED, why="mode loiter"))
        lines = bench.text("roster").splitlines()
        assert "harrier" in lines[1]
        assert "pilot flies: mode loiter" in lines[2]
        assert "PILOT FLIES harrier" in bench.text("banner")


async def test_troubles_are_explained_acknowledged_and_muted(size: Size) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        voices = await fly(bench, pilot)
        await press(bench, pilot, "t")
        assert "Nothing is wrong" in bench.dialog
        await press(bench, pilot, "escape")
        await bench.hear(pilot, *(voices[name].status(66.0, Stage.YIELDED) for name in ("osprey", "harrier")))
        await press(bench, pilot, "t")
        assert isinstance(bench.app.screen, TroublesDialog)
        assert "Troubles: 2" in bench.dialog
        assert "the fleet:" in bench.dialog
        assert "you can:" in bench.dialog
        await press(bench, pilot, "a", "down", "m")
        assert "seen" in bench.dialog
        assert "muted" in bench.dialog
        await press(bench, pilot, "escape")
        assert "PILOT FLIES" not in bench.text("banner")


async def test_themes_go_round_and_the_palette_finds_commands() -> None:
    bench = Bench()
    async with bench.app.run_test(size=(100, 30)) as pilot:
        await fly(bench, pilot)
        seen = set()
        for _ in range(3):
            seen.add((bench.app.theme_name, bench.app.export_screenshot()))
            await press(bench, pilot, "T")
        assert len({shot for _, shot in seen}) == 3
        await pilot.press("ctrl+p")
        await pilot.press(*"troub")
        await bench.until(pilot, lambda: len(bench.app.screen_stack) == 2)
        await pilot.pause(0.3)
        await pilot.press("enter")
        await bench.until(pilot, lambda: isinstance(bench.app.screen, TroublesDialog))


@pytest.mark.parametrize(
    ("metres", "longest", "expected"),
    [(100.0, 8, (5, "500 m")), (7.0, 8, (7, "50 m")), (300.0, 8, (7, "2 km")), (0.01, 8, (5, "0.05 m"))],
)
def test_scale_bars_are_round_and_fit(metres: float, longest: int, expected: tuple[int, str]) -> None:
    assert scale_bar(metres, longest) == expected
