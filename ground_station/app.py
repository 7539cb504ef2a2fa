"""The terminal dashboard: a timer folds what arrived into the picture and hands it to the screen on top."""

from __future__ import annotations

import asyncio
import signal
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import ClassVar

from rich.segment import Segment
from textual.app import App
from textual.binding import Binding, BindingType
from textual.color import Color
from textual.filter import LineFilter, NoColor
from textual.screen import Screen

from ground_station.link import Link
from ground_station.notice import read_notice
from ground_station.picture import Condition
from ground_station.screens.command import CommandDialog
from ground_station.screens.dashboard import Dashboard
from ground_station.screens.dialog import Dialog
from ground_station.screens.help import HelpDialog
from ground_station.screens.leave import LeaveDialog
from ground_station.station import Station
from ground_station.views.ink import Look
from vehicle_agent.link.session import LinkError
from vehicle_agent.wire.messages import Verb

LISTEN_PERIOD_S = 0.1
DRAW_PERIOD_S = 0.5
FAREWELL_S = 2.0
"""How long the last picture stays when the dashboard ends by itself."""


class AsciiOnly(LineFilter):
    """Last guard of `--ascii`: whatever else got through becomes `?`."""

    def apply(self, segments: list[Segment], background: Color) -> list[Segment]:
        return [
            segment
            if segment.text.isascii()
            else Segment(segment.text.encode("ascii", "replace").decode(), segment.style, segment.control)
            for segment in segments
        ]


class GroundStationApp(App[None]):
    """Everything that has to do with the fleet is in `Station`; this draws it and asks before it acts.

    Parameters
    ----------
    station
        Not yet attached to a link.
    connect
        Opens the link; called on a thread after the first frame, may raise LinkError.
    clock
        Monotonic wall seconds.
    notice_file
        One line shown while no vehicle is live; read anew at every drawing.
    exit_when_done
        Leave by itself once every vehicle has finished or is lost for good.

    Attributes
    ----------
    refusal
        Why the link could not be opened, one sentence; empty otherwise.
    """

    CSS_PATH = "dashboard.tcss"
    TITLE = "ground station"
    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("h", "ask('HOLD')", "hold"),
        Binding("r", "ask('RESUME')", "resume"),
        Binding("b,x", "ask('RETURN')", "return home"),
        Binding("q", "leave", "quit"),
        Binding("ctrl+c,ctrl+q", "leave", "quit", show=False, priority=True),
        Binding("question_mark", "help", "help"),
        Binding("pageup", "scroll_events(5)", show=False),
        Binding("pagedown", "scroll_events(-5)", show=False),
        Binding("home", "scroll_events(1000000)", show=False),
        Binding("end", "scroll_events(-1000000)", show=False),
    ]

    def __init__(
        self,
        station: Station,
        connect: Callable[[], Link],
        look: Look,
        *,
        clock: Callable[[], float] = time.monotonic,
        notice_file: Path | None = None,
        exit_when_done: bool = False,
    ) -> None:
        super().__init__()
        self.station = station
        self.refusal = ""
        self._connect = connect
        self._look = look
        self._clock = clock
        self._notice_file = notice_file
        self._exit_when_done = exit_when_done
        self._done_at_s: float | None = None
        self._lost = 0
        self._dashboard = Dashboard(look)
        self._own_filters: list[LineFilter] = []
        if not look.colour:
            self._own_filters.append(NoColor())
        if not look.unicode:
            self._own_filters.append(AsciiOnly())

    def get_line_filters(self) -> Sequence[LineFilter]:
        return [*super().get_line_filters(), *self._own_filters]

    def get_default_screen(self) -> Screen[None]:
        return self._dashboard

    async def on_mount(self) -> None:
        loop = asyncio.get_running_loop()
        for number in (signal.SIGTERM, signal.SIGHUP):
            loop.add_signal_handler(number, self.exit)
        self.set_interval(LISTEN_PERIOD_S, self._listen)
        self.set_interval(DRAW_PERIOD_S, self.draw)
        self.call_after_refresh(self.draw)
        self.call_after_refresh(self._open_link)

    def _open_link(self) -> None:
        self.run_worker(self._attach_link(), exit_on_error=True)

    async def _attach_link(self) -> None:
        try:
            link = await asyncio.to_thread(self._connect)
        except LinkError as error:
            self.refusal = str(error)
            self.exit()
            return
        self.station.attach(link)

    def _listen(self) -> None:
        """Take in what arrived; a vehicle lost or found is drawn at once, all else waits for the next drawing."""
        state = self.station.step(self._clock())
        lost = state.count(Condition.LOST)
        if lost != self._lost:
            self._lost = lost
            self.draw()
        if self._exit_when_done and state.finished:
            self._done_at_s = self._done_at_s or state.now_s
            if state.now_s - self._done_at_s >= FAREWELL_S:
                self.exit()

    def draw(self) -> None:
        """Hand the newest picture to the screens that show it."""
        state = self.station.state
        self._dashboard.show(state, read_notice(self._notice_file))
        if isinstance(self.screen, Dialog):
            self.screen.show(state)

    def action_ask(self, verb: str) -> None:
        if self.screen is self._dashboard and not self._dashboard.has_class("too-small"):
            self.push_screen(CommandDialog(self._look, self.station.state, Verb[verb], self._send))

    def action_leave(self) -> None:
        if isinstance(self.screen, LeaveDialog):
            self.exit()
        elif not isinstance(self.screen, Dialog):
            self.push_screen(LeaveDialog(self._look, self.station.state))
        else:
            self.screen.dismiss()

    def action_help(self) -> None:
        if self.screen is self._dashboard:
            self.push_screen(HelpDialog(self._look, self.station.state))

    def action_scroll_events(self, entries: int) -> None:
        self._dashboard.scroll_events(entries)

    def _send(self, verb: Verb, targets: Sequence[str]) -> int | None:
        number = self.station.command(verb, targets, self._clock())
        self.draw()
        return number
