"""The terminal dashboard: a timer folds what arrived into the picture and hands it to the screen on top."""

from __future__ import annotations

import asyncio
import gc
import signal
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import ClassVar

from rich.segment import Segment
from textual import events
from textual.binding import Binding, BindingType
from textual.color import Color
from textual.filter import LineFilter, NoColor
from textual.screen import Screen

from ground_station.link import Link
from ground_station.notice import read_notice
from ground_station.operations import Operations
from ground_station.palette_commands import FleetCommands
from ground_station.picture import Condition
from ground_station.player import Player
from ground_station.screens.dashboard import Dashboard
from ground_station.screens.dialog import Dialog
from ground_station.screens.help import HelpDialog
from ground_station.screens.leave import LeaveDialog
from ground_station.station import Station
from ground_station.text import duration
from ground_station.views import palette
from ground_station.views.header_view import banner_line
from ground_station.views.ink import Line, Look, line_of
from ground_station.views.replay_view import replay_line
from ground_station.views.theme import THEMES, next_theme
from ground_station.widgets.lines import Lines
from vehicle_agent.link.session import LinkError

LISTEN_PERIOD_S = 0.1
DRAW_PERIOD_S = 0.5
FAREWELL_S = 2.0
"""How long the last picture stays when the dashboard ends by itself."""
SEEK_S = 10.0
KEY_GRACE_S = 0.12
"""Drawings wait so long after a key: its answer comes first."""
GARBAGE_THRESHOLDS = (5_000, 20, 100)
"""Pictures are many short-lived tuples: the interpreter's own thresholds would look through them all the time."""


class AsciiOnly(LineFilter):
    """Last guard of `--ascii`: whatever else got through becomes `?`."""

    def apply(self, segments: list[Segment], background: Color) -> list[Segment]:
        return [
            segment
            if segment.text.isascii()
            else Segment(segment.text.encode("ascii", "replace").decode(), segment.style, segment.control)
            for segment in segments
        ]


class GroundStationApp(Operations):
    """Everything that has to do with the fleet is in `Station`; this draws it and asks before it acts.

    Parameters
    ----------
    station
        Not yet attached to a link; or the player of a recording.
    connect
        Opens the link; called on a thread after the first frame, may raise LinkError.
    clock
        Monotonic wall seconds.
    notice_file
        One line shown while no vehicle is live; read anew at every drawing.
    exit_when_done
        Leave by itself once every vehicle has finished or is lost for good.
    stops_mission
        Ctrl-C asks to stop the whole run, by exit code 130, instead of only leaving.
    draw_period_s
        Wall time between two drawings.
    theme_name
        One of `views.theme.THEMES`.

    Attributes
    ----------
    refusal
        Why the link could not be opened, one sentence; empty otherwise.
    theme_name
        What is worn now.
    """

    CSS_PATH = "dashboard.tcss"
    TITLE = "ground station"
    COMMANDS: ClassVar = {FleetCommands}
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("h", "ask('HOLD')", "hold"),
        Binding("r", "ask('RESUME')", "resume"),
        Binding("b,x", "ask('RETURN')", "return home"),
        Binding("L", "ask('LAND')", "land here"),
        Binding("o", "ask_there('GO_TO')", "send to the cursor"),
        Binding("p", "ask_there('VISIT')", "visit the cursor"),
        Binding("d", "draw", "draw a polygon"),
        Binding("enter", "finish_drawing", "finish the polygon"),
        Binding("a", "polygons", "areas and zones"),
        Binding("k", "speed", "speed limit"),
        Binding("n", "proposal", "re-plan"),
        Binding("t", "troubles", "troubles"),
        Binding("l", "layers", "map layers"),
        Binding("T", "theme", "theme"),
        Binding("space", "replay('toggle')", show=False),
        Binding("left_square_bracket", "replay('back')", show=False),
        Binding("right_square_bracket", "replay('on')", show=False),
        Binding("full_stop", "replay('step')", show=False),
        Binding("less_than_sign", "replay('slower')", show=False),
        Binding("greater_than_sign", "replay('faster')", show=False),
        Binding("q", "leave", "quit"),
        Binding("ctrl+c", "interrupt", "stop", show=False, priority=True),
        Binding("ctrl+q", "leave", "quit", show=False, priority=True),
        Binding("question_mark", "help", "help"),
    ]

    def __init__(
        self,
        station: Station | Player,
        connect: Callable[[], Link] | None,
        look: Look,
        *,
        clock: Callable[[], float] = time.monotonic,
        notice_file: Path | None = None,
        exit_when_done: bool = False,
        stops_mission: bool = False,
        draw_period_s: float = DRAW_PERIOD_S,
        theme_name: str = "night",
    ) -> None:
        super().__init__()
        self.station = station
        self.refusal = ""
        self._connect = connect
        self._look = look
        self._clock = clock
        self._notice_file = notice_file
        self._exit_when_done = exit_when_done
        self._stops_mission = stops_mission
        self._draw_period_s = draw_period_s
        self.theme_name = theme_name
        self._done_at_s: float | None = None
        self._lost = 0
        self._proposed: object | None = None
        self._pressed_s = self._drawn_s = float("-inf")
        self._dashboard = Dashboard(look, self._remark)
        self._own_filters: list[LineFilter] = []
        if not look.colour:
            self._own_filters.append(NoColor())
        if not look.unicode:
            self._own_filters.append(AsciiOnly())

    def now_s(self) -> float:
        return self._clock()

    def get_line_filters(self) -> Sequence[LineFilter]:
        return [*super().get_line_filters(), *self._own_filters]

    def get_default_screen(self) -> Screen[None]:
        return self._dashboard

    async def on_mount(self) -> None:
        loop = asyncio.get_running_loop()
        for number in (signal.SIGTERM, signal.SIGHUP):
            loop.add_signal_handler(number, self.exit)
        self._wear(self.theme_name)
        self.set_interval(LISTEN_PERIOD_S, self._listen)
        self.call_after_refresh(self.draw)
        self.call_after_refresh(self._open_link)

    def _open_link(self) -> None:
        if isinstance(self.station, Station) and self._connect is not None:
            self.run_worker(self._attach_link(self.station, self._connect), exit_on_error=True)

    async def _attach_link(self, station: Station, connect: Callable[[], Link]) -> None:
        try:
            link = await asyncio.to_thread(connect)
        except LinkError as error:
            self.refusal = str(error)
            self.exit()
            return
        station.attach(link)

    def _listen(self) -> None:
        """Take in what arrived; a loss, a find or a proposal is drawn at once, all else when a drawing is due."""
        if not self.screen_stack:  # the dashboard is being taken down
            return
        state = self.station.step(self._clock())
        urgent = (state.count(Condition.LOST), self.station.proposal)
        if urgent != (self._lost, self._proposed):
            self._lost, self._proposed = urgent
            self.draw()
        elif self._is_drawing_due():
            self.draw()
        if self._exit_when_done and state.finished:
            self._done_at_s = self._done_at_s or state.now_s
            if state.now_s - self._done_at_s >= FAREWELL_S:
                self.exit()

    async def on_event(self, event: events.Event) -> None:
        if isinstance(event, events.Key):
            self._pressed_s = asyncio.get_running_loop().time()
        await super().on_event(event)

    def _is_drawing_due(self) -> bool:
        """Once per period, but not while a key is being answered; a key that is held down puts it off a little."""
        now_s = asyncio.get_running_loop().time()
        passed_s = now_s - self._drawn_s + 0.5 * LISTEN_PERIOD_S
        answering = now_s - self._pressed_s < KEY_GRACE_S and passed_s < 1.5 * self._draw_period_s
        return passed_s >= self._draw_period_s and not answering

    def draw(self) -> None:
        """Hand the newest picture to the screens that show it."""
        self._drawn_s = asyncio.get_running_loop().time()
        state = self.station.state
        self._dashboard.show(state, read_notice(self._notice_file))
        if isinstance(self.screen, Dialog):
            self.screen.show(state)

    def _remark(self) -> Line | None:
        """What takes the banner's place: where a replay stands, or that something is proposed."""
        if isinstance(self.station, Player):
            return replay_line(self.station, self._look)
        proposal = self.station.proposal
        if proposal is None:
            return None
        lost = self.station.state.count(Condition.LOST) > 0
        alarm = banner_line(self.station.state, "", self._look)[0] if lost else (" ", self._look.ink())
        after = "" if proposal.after is None else f", {duration(proposal.after.remaining_s)} to go"
        ink = self._look.ink(palette.WARN, bold=True)
        return line_of(alarm, (f" RE-PLAN: {proposal.cause}{after} ", ink), " n: look and decide")

    def action_leave(self) -> None:
        if isinstance(self.screen, LeaveDialog):
            self.exit()
        elif self.screen is self._dashboard:
            self.push_screen(LeaveDialog(self._look, self.station.state))
        else:
            self.screen.dismiss()

    def action_interrupt(self) -> None:
        """Ctrl-C: ask to stop the whole run where this dashboard is part of one; pressed again, it is meant."""
        if not self._stops_mission:
            self.action_leave()
        elif isinstance(self.screen, LeaveDialog):
            self.screen.action_leave()
        else:
            self.push_screen(LeaveDialog(self._look, self.station.state, stops_mission=True))

    def action_help(self) -> None:
        if self.screen is self._dashboard:
            self.push_screen(HelpDialog(self._look, self.station.state))

    def action_theme(self) -> None:
        self._wear(next_theme(self.theme_name))

    def action_replay(self, what: str) -> None:
        player = self.station
        if not isinstance(player, Player) or self.screen is not self._dashboard:
            return
        match what:
            case "toggle":
                player.toggle()
            case "back":
                player.seek(player.position_s - SEEK_S * max(1.0, player.speed))
            case "on":
                player.seek(player.position_s + SEEK_S * max(1.0, player.speed))
            case "step":
                player.step_forward()
            case "slower" | "faster":
                player.faster(1 if what == "faster" else -1)
        self.draw()

    def _wear(self, name: str) -> None:
        """Put a theme on everything that is drawn."""
        self.theme_name = name
        theme = THEMES[name]
        for screen in self.screen_stack:
            screen.styles.background = Color(*theme.background)
            screen.styles.color = Color(*theme.text)
            for pane in screen.query(Lines):
                pane.refresh()


def run_on_terminal(app: GroundStationApp) -> None:
    """Run a dashboard as a program of its own.

    What is loaded by now lives as long as the program: the collector need not look at it again, which would stop the
    dashboard for a tenth of a second now and then.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(*GARBAGE_THRESHOLDS)
    app.run()
