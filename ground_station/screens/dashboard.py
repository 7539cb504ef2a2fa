"""The main screen: header, map, coverage curve, roster, event log, keys."""

from __future__ import annotations

from textual import events
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.screen import Screen

from ground_station.picture import FleetState
from ground_station.views import palette
from ground_station.views.curve_view import curve_lines
from ground_station.views.event_view import event_lines
from ground_station.views.header_view import banner_line, header_line
from ground_station.views.ink import Line, Look, line_of
from ground_station.views.layout import MIN_HEIGHT, MIN_WIDTH, Layout, arrange
from ground_station.views.map_view import caption, map_lines, map_raster
from ground_station.views.raster import Raster
from ground_station.views.roster_view import roster_lines
from ground_station.widgets.lines import Lines

KEYS = (("h", "hold"), ("r", "resume"), ("b", "return home"), ("q", "quit"), ("?", "help"))


class Dashboard(Screen[None]):
    """Draws the state it is shown; asks for nothing and knows nothing else."""

    def __init__(self, look: Look) -> None:
        super().__init__()
        self._look = look
        self._state: FleetState | None = None
        self._notice = ""
        self._scrolled_to: int | None = None
        self._raster: Raster | None = None

    def compose(self) -> ComposeResult:
        yield Lines(id="too-small")
        yield Lines(id="header")
        yield Lines(id="banner")
        with Horizontal(id="body"):
            with Vertical(id="left"):
                yield Lines(id="map")
                yield Lines(id="caption")
                yield Lines(id="curve")
            with Vertical(id="right"):
                yield Lines(id="roster")
                yield Lines(id="events")
        yield Lines(id="keys")

    def show(self, state: FleetState, notice: str) -> None:
        """Draw a picture; `notice` comes from whoever started the dashboard."""
        self._state, self._notice = state, notice
        self._draw()

    def scroll_events(self, entries: int) -> None:
        """Go back (positive) or forward in the event log; at its end it follows new events again."""
        state = self._state
        if state is None or not state.log:
            return
        now = state.log_total if self._scrolled_to is None else self._scrolled_to
        oldest = state.log_total - len(state.log) + 1
        target = max(oldest, now - entries)
        self._scrolled_to = None if target >= state.log_total else target
        self._draw()

    def on_resize(self, event: events.Resize) -> None:
        self.set_class(event.size.width < MIN_WIDTH or event.size.height < MIN_HEIGHT, "too-small")
        self.call_after_refresh(self._draw)

    def _draw(self) -> None:
        state = self._state
        if state is None or not self.is_mounted:
            return
        width, height = self.app.size
        if self.has_class("too-small"):
            text = f"{width}x{height}: enlarge to {MIN_WIDTH}x{MIN_HEIGHT}"
            self._lines("too-small").show([line_of((text, self._look.ink(palette.WARN, bold=True)))])
            return
        if self._place(arrange(state.plan.grid, len(state.vehicles), width, height)):
            self.call_after_refresh(self._draw)
            return
        look = self._look
        back = 0 if self._scrolled_to is None else max(0, state.log_total - self._scrolled_to)
        self._lines("header").show([header_line(state, width, look)])
        self._lines("banner").show([banner_line(state, self._notice, look)])
        self._lines("keys").show([_key_line(look, width)])
        ground = self._lines("map")
        self._raster = map_raster(state, ground.size.width, ground.size.height, look, self._raster)
        ground.show(map_lines(state, self._raster, look))
        self._lines("caption").show([caption(self._raster, ground.size.width, look)])
        for name, view in (("curve", curve_lines), ("roster", roster_lines)):
            lines = self._lines(name)
            lines.show(view(state, lines.size.width, lines.size.height, look))
        log = self._lines("events")
        log.show(event_lines(state, log.size.width, log.size.height, look, back))

    def _place(self, layout: Layout) -> bool:
        """Give the panes their sizes; true when that changes anything, so that drawing has to wait for the layout."""
        wanted = {
            "left": (layout.left_width, None),
            "curve": (None, layout.curve_height),
            "roster": (None, layout.roster_height),
        }
        changed = False
        for name, (width, height) in wanted.items():
            pane = self.query_one(f"#{name}")
            if width is not None and (pane.styles.width is None or pane.styles.width.value != width):
                pane.styles.width = width
                changed = True
            if height is not None and (pane.styles.height is None or pane.styles.height.value != height):
                pane.styles.height = height
                changed = True
        return changed

    def _lines(self, name: str) -> Lines:
        return self.query_one(f"#{name}", Lines)


def _key_line(look: Look, width: int) -> Line:
    spans = []
    for key, meaning in KEYS:
        spans += [
            (f" {key} ", look.ink(palette.ACCENT, palette.BAR, bold=True)),
            (f"{meaning} ", look.ink(bg=palette.BAR)),
        ]
    used = sum(len(text) for text, _ in spans)
    return (*spans, (" " * max(0, width - used), look.ink(bg=palette.BAR)))
