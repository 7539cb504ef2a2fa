"""The main screens as pictures, on a small and a large terminal.

A change that is meant is taken over with `UPDATE_SNAPSHOTS=1 pytest tests/tui/test_snapshots.py`; look at the SVG files
before they are committed. `SNAPSHOT_REPEATS=50` draws each as often and compares every time.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from textual.pilot import Pilot

from ground_station.screens.dialog import Dialog
from tests.fakes.talking_fleet import NAMES, Voice
from tests.tui.conftest import Bench
from vehicle_agent.wire.messages import Orders, Severity, Stage, Zone

FOLDER = Path(__file__).parent / "snapshots"
REPEATS = int(os.environ.get("SNAPSHOT_REPEATS", "1"))
UPDATES = "UPDATE_SNAPSHOTS" in os.environ
SCREENS: dict[str, tuple[str, ...]] = {
    "working": (),
    "map-cursor": ("tab", "f", "c", "right", "up", "v"),
    "drawing": ("c", "d", "right", "right", "d", "up", "up", "d", "enter"),
    "hold": ("h",),
    "troubles": ("t",),
    "proposal": ("n",),
    "layers": ("l",),
    "help": ("question_mark",),
}
"""Keys that lead to each screen."""


async def fly(bench: Bench, pilot: Pilot[None]) -> None:
    """A mission half way through: one vehicle low on battery, one lost, a no-fly zone, events of each severity."""
    voices = {name: Voice(name) for name in NAMES}
    for second in range(0, 90, 3):
        for at, voice in enumerate(voices.values()):
            if voice.name == "osprey" and second > 60:
                continue
            place = (2_000 + 4_000 * at + 15 * second, 2_000 + 150 * second, 6_000)
            goal = (place[0] + 1_000, min(19_000, place[1] + 3_000), 6_000)
            low = 990 - 10 * second if voice.name == "kestrel" else 900
            stage = Stage.HOLDING if voice.name == "harrier" else Stage.WORKING
            status = voice.status(
                second,
                stage,
                position_cm=place,
                leg_end_cm=goal,
                home_cm=(2_000, 2_000, 0),
                battery_permille=max(0, low),
            )
            cells = [20 * (2 + 4 * at + column) + second // 5 for column in range(4)]
            bench.link.arriving += [status, voice.delta(cells, second, elevation_dm=1_000 + 20 * second)]
        bench.now_s += 3.0
        bench.station.step(bench.now_s)
    merlin = voices["merlin"]
    head = merlin.status(88.0)
    zone = Zone(1, ((12_000, 2_000), (17_000, 2_000), (17_000, 6_000)))
    orders = Orders(sender="merlin", boot_id=head.boot_id, sequence=head.sequence + 1, stamp_ms=head.stamp_ms,
                    no_fly=(zone,))  # fmt: skip
    merlin = Voice("merlin", boot_id=head.boot_id)
    await bench.hear(
        pilot, orders,
        *(voices["kestrel"].event(f"{severity.name.lower()} for the picture", 80.0, severity) for severity in Severity),
    )  # fmt: skip


@pytest.mark.parametrize("repeat", range(REPEATS))
@pytest.mark.parametrize("name", SCREENS)
async def test_screens_look_as_they_did(name: str, size: tuple[int, int], repeat: int, tmp_path: Path) -> None:
    bench = Bench()
    async with bench.app.run_test(size=size) as pilot:
        await bench.connected(pilot)
        await fly(bench, pilot)
        await pilot.press(*SCREENS[name])
        if SCREENS[name] and name != "map-cursor":
            await bench.until(pilot, lambda: isinstance(bench.app.screen, Dialog))
        await bench.drawn(pilot)
        svg = bench.app.export_screenshot(title="", simplify=True)
    file = FOLDER / f"{name}-{size[0]}x{size[1]}.svg"
    if UPDATES:
        FOLDER.mkdir(exist_ok=True)
        file.write_text(svg, encoding="utf-8")
    actual = tmp_path / file.name
    actual.write_text(svg, encoding="utf-8")
    assert svg == file.read_text(encoding="utf-8"), f"{actual} differs from {file}: look at both in a browser"
