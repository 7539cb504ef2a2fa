"""A dashboard under test: a link made of lists, and a clock that only the test moves."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from textual.pilot import Pilot

from ground_station.app import GroundStationApp
from ground_station.screens.dialog import Dialog
from ground_station.station import Station
from ground_station.views.ink import Look
from ground_station.widgets.lines import Lines
from tests.fakes.talking_fleet import ListLink, small_plan
from vehicle_agent.link.session import LinkError
from vehicle_agent.wire.messages import AnyMessage


class Bench:
    """An app with the hands that tests need."""

    def __init__(
        self, vehicles: int = 4, look: Look | None = None, notice_file: Path | None = None,
        exit_when_done: bool = False, refusal: str = "", stops_mission: bool = False,
    ) -> None:  # fmt: skip
        self.link = ListLink()
        self.now_s = 100.0
        self.station = Station(small_plan(vehicles), "station-0001", 9, self.now_s)
        self._refusal = refusal
        self.app = GroundStationApp(
            self.station,
            self._connect,
            look or Look(),
            clock=lambda: self.now_s,
            notice_file=notice_file,
            exit_when_done=exit_when_done,
            stops_mission=stops_mission,
        )

    def _connect(self) -> ListLink:
        if self._refusal:
            raise LinkError(self._refusal)
        return self.link

    async def connected(self, pilot: Pilot[None]) -> None:
        await self.until(pilot, lambda: self.station.connected)

    async def hear(self, pilot: Pilot[None], *messages: AnyMessage) -> None:
        """Let messages arrive, be folded and drawn."""
        await self.connected(pilot)
        self.link.arriving += messages
        await self.until(pilot, lambda: not self.link.arriving)
        await self.drawn(pilot)

    async def drawn(self, pilot: Pilot[None]) -> None:
        self.station.step(self.now_s)
        for _ in range(3):  # a new layout is drawn a refresh later
            self.app.draw()
            await pilot.pause()

    async def pass_time(self, pilot: Pilot[None], seconds: float) -> None:
        self.now_s += seconds
        await self.drawn(pilot)

    async def until(self, pilot: Pilot[None], condition: Callable[[], bool]) -> None:
        for _ in range(400):
            if condition():
                return
            await pilot.pause(0.02)
        pytest.fail("the dashboard did not get there")

    def text(self, pane: str) -> str:
        return self.app.screen_stack[0].query_one(f"#{pane}", Lines).text

    @property
    def dialog(self) -> str:
        """What the dialog on top says."""
        assert isinstance(self.app.screen, Dialog)
        return self.app.screen.query_one("#content", Lines).text


@pytest.fixture(params=[(80, 24), (120, 40)], ids=["80x24", "120x40"])
def size(request: pytest.FixtureRequest) -> tuple[int, int]:
    width, height = request.param
    return (width, height)
