"""The main screen: header, map, coverage curve, roster, event log, keys."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar

from textual import events
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.screen import Screen

from ground_station.picture import FleetState
from ground_station.team_map import contribution_curves
from ground_station.views import palette
from ground_station.views.cursor_view import cursor_lines
from ground_station.views.curve_view import Curves, curve_lines
from ground_station.views.event_view import EVERYTHING, EventFilter, event_lines
from ground_station.views.event_window import EventWindow
from ground_station.views.header_view import banner_line, header_line
from ground_station.views.ink import Line, Look, line_of
from ground_station.views.key_view import key_line
from ground_station.views.layout import MIN_HEIGHT, MIN_WIDTH, Layout, arrange
from ground_station.views.map_view import caption, map_lines, map_raster, rows_per_character
from ground_station.views.raster import Raster
from ground_station.views.roster_view import roster_lines
from ground_station.views.window import EastNorth, MapWindow
from ground_station.widgets.lines import Lines

FOLLOW_ZOOM = 4
FAR = 8
"""Characters that the cursor moves with shift."""


class Dashboard(Screen[None]):
    """Draws the state it is shown, as the operator wants to look at it; knows nothing else of the fleet.

    Attributes
    ----------
    window
        How the map is looked at.
    selected
        Name of the vehicle that was chosen; empty for none.
    events
        How the event log is looked at.
    frame
        Counts the drawings.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("plus,equals_sign", "zoom(1)", "zoom in"),
        Binding("minus", "zoom(-1)", "zoom out"),
        Binding("0", "zoom(-99)", "whole area"),
        Binding("left", "move(-1, 0)", show=False),
        Binding("right", "move(1, 0)", show=False),
        Binding("up", "move(0, 1)", show=False),
        Binding("down", "move(0, -1)", show=False),
        Binding("shift+left", f"move(-{FAR}, 0)", show=False),
        Binding("shift+right", f"move({FAR}, 0)", show=False),
        Binding("shift+up", f"move(0, {FAR})", show=False),
        Binding("shift+down", f"move(0, -{FAR})", show=False),
        Binding("c", "cursor", "cursor"),
        Binding("f", "follow", "follow the chosen vehicle"),
        Binding("g", "ground", "other ground colours"),
        Binding("v", "contributions", "curves by vehicle"),
        Binding("tab", "select(1)", "choose the next vehicle", priority=True),
        Binding("shift+tab", "select(-1)", "choose the vehicle before", priority=True),
        Binding("e", "severity", "only graver events"),
        Binding("s", "only_selected", "only the chosen vehicle's events"),
        Binding("pageup", "scroll_events(5)", show=False),
        Binding("pagedown", "scroll_events(-5)", show=False),
        Binding("home", "scroll_events(1000000)", show=False),
        Binding("end", "scroll_events(-1000000)", show=False),
        Binding("escape", "let_go", show=False),
    ]

    def __init__(self, look: Look, remark: Callable[[], Line | None] = lambda: None) -> None:
        super().__init__()
        self.window = MapWindow()
        self.selected = ""
        self.events = EventWindow()
        self.frame = 0
        self._look = look
        self._remark = remark
        self._state: FleetState | None = None
        self._notice = ""
        self._raster: Raster | None = None
        self._by_vehicle = False
        self._curves: tuple[tuple[int, int, int], Curves] | None = None

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
        self.redraw()

    def look_differently(self, window: MapWindow) -> None:
        """Take another look at the map."""
        self.window = window
        self.redraw()

    @property
    def too_small(self) -> bool:
        return self.has_class("too-small")

    # -- keys and mouse -------------------------------------------------------------------------------------------

    def action_zoom(self, steps: int) -> None:
        if self._state is not None:
            window = self.window
            if window.zoom == 0 and window.cursor_en_m is None:
                window = replace(window, centre_en_m=self._selected_place())
            self.look_differently(window.zoomed(steps, self._state.plan.grid))

    def action_move(self, east: int, north: int) -> None:
        if self._state is None or self._raster is None:
            return
        view, grid = self._raster.view, self._state.plan.grid
        if self.window.cursor_en_m is None:
            self.look_differently(self.window.panned(_sign(east), _sign(north), view, grid))
        else:
            rows = rows_per_character(self._look)
            self.look_differently(self.window.with_cursor_moved(east, north, view, grid, rows))

    def action_cursor(self) -> None:
        if self._state is None or self._raster is None:
            return
        if self.window.cursor_en_m is not None:
            self.look_differently(replace(self.window, cursor_en_m=None))
            return
        start = replace(self.window, cursor_en_m=self._selected_place())
        self.look_differently(
            start.with_cursor_moved(0, 0, self._raster.view, self._state.plan.grid, rows_per_character(self._look))
        )

    def action_follow(self) -> None:
        window = self.window
        if window.follow or not self.selected:
            self.look_differently(replace(window, follow=""))
            return
        centre = self._selected_place()
        self.look_differently(
            replace(window, follow=self.selected, zoom=max(FOLLOW_ZOOM, window.zoom), centre_en_m=centre)
        )

    def action_ground(self) -> None:
        self.look_differently(self.window.with_next_ground())

    def action_contributions(self) -> None:
        self._by_vehicle = not self._by_vehicle
        self.redraw()

    def action_select(self, step: int) -> None:
        if self._state is None:
            return
        names = ["", *self._state.plan.vehicle_names]
        at = names.index(self.selected) if self.selected in names else 0
        self.selected = names[(at + step) % len(names)]
        if self.events.shown.vehicle:
            self.events = replace(self.events, shown=replace(self.events.shown, vehicle=self.selected))
        self.redraw()

    def action_severity(self) -> None:
        self._show_events(self.events.shown.with_next_severity())

    def action_only_selected(self) -> None:
        shown = self.events.shown
        self._show_events(replace(shown, vehicle="" if shown.vehicle else self.selected))

    def action_let_go(self) -> None:
        """Give up, one after the other: the polygon being drawn, the cursor, the filter, the choice."""
        if self.window.drawn_en_m:
            self.look_differently(replace(self.window, drawn_en_m=()))
        elif self.window.cursor_en_m is not None:
            self.look_differently(replace(self.window, cursor_en_m=None))
        elif self.events.shown != EVERYTHING:
            self._show_events(EVERYTHING)
        else:
            self.selected = ""
            self.redraw()

    def action_scroll_events(self, entries: int) -> None:
        """Go back (positive) or forward in the event log; at its end it follows new events again."""
        if self._state is not None:
            self.events = self.events.scrolled(self._state, entries)
            self.redraw()

    def on_click(self, event: events.Click) -> None:
        place = self._place_under(event)
        if place is not None:
            self.look_differently(replace(self.window, cursor_en_m=place))

    def on_mouse_scroll_up(self, event: events.MouseScrollUp) -> None:
        self._wheel(event, 1)

    def on_mouse_scroll_down(self, event: events.MouseScrollDown) -> None:
        self._wheel(event, -1)

    def on_resize(self, event: events.Resize) -> None:
        self.set_class(event.size.width < MIN_WIDTH or event.size.height < MIN_HEIGHT, "too-small")
        self.call_after_refresh(self.redraw)

    def _wheel(self, event: events.MouseEvent, steps: int) -> None:
        place = self._place_under(event)
        if place is not None and self._state is not None:
            window = replace(self.window, centre_en_m=self.window.centre_en_m or place)
            self.look_differently(window.zoomed(steps, self._state.plan.grid))
        elif place is None:
            self.action_scroll_events(3 * steps)

    def _place_under(self, event: events.MouseEvent) -> EastNorth | None:
        """The place of the mission's plane under the mouse; None off the map."""
        ground = self._lines("map")
        offset = event.get_content_offset(ground)
        if offset is None or self._raster is None or not ground.region.contains(event.screen_x, event.screen_y):
            return None
        view, rows = self._raster.view, rows_per_character(self._look)
        return (
            view.west_m + (offset.x + 0.5) * view.pixel_width_m,
            view.north_m - (offset.y * rows + 0.5 * rows) * view.pixel_height_m,
        )

    def _selected_place(self) -> EastNorth | None:
        vehicles = self._state.vehicles if self._state is not None else ()
        position = next((one.position_enu_m for one in vehicles if one.name == self.selected), None)
        return None if position is None else position[:2]

    def _show_events(self, shown: EventFilter) -> None:
        self.events = self.events.showing(shown)
        self.redraw()

    # -- drawing --------------------------------------------------------------------------------------------------

    def redraw(self) -> None:
        state = self._state
        if state is None or not self.is_mounted or not self.query("#keys"):
            return
        width, height = self.app.size
        if self.too_small:
            text = f"{width}x{height}: enlarge to {MIN_WIDTH}x{MIN_HEIGHT}"
            self._lines("too-small").show([line_of((text, self._look.ink(palette.WARN, bold=True)))])
            return
        if self._place(arrange(state.plan.grid, len(state.vehicles), width, height)):
            self.call_after_refresh(self.redraw)
            return
        self.frame += 1
        look = self._look
        self._lines("header").show([header_line(state, width, look)])
        self._lines("banner").show([self._remark() or banner_line(state, self._notice, look)])
        self._lines("keys").show([key_line(look, width, bool(self.window.drawn_en_m), self.window.cursor_en_m)])
        self._draw_map(state)
        self._draw_curve(state)
        roster = self._lines("roster")
        roster.show(roster_lines(state, roster.size.width, roster.size.height, look, self.selected))
        log = self._lines("events")
        window = self.events
        log.show(event_lines(state, log.size.width, log.size.height, look, window.back(state), window.shown))

    def _draw_map(self, state: FleetState) -> None:
        ground, look = self._lines("map"), self._look
        width, height = ground.size
        if self.window.follow and self._raster is not None:
            self.window = self.window.following(state, self._raster.view)
        self._raster = map_raster(state, width, height, look, self._raster, self.window)
        ground.show(map_lines(state, self._raster, look, self.window))
        self._lines("caption").show([caption(self._raster, width, look, state.started_ms)])

    def _draw_curve(self, state: FleetState) -> None:
        pane, look = self._lines("curve"), self._look
        width, height = pane.size
        if self.window.cursor_en_m is not None:
            pane.show(cursor_lines(state, self.window.cursor_en_m, width, height, look))
            return
        columns = 2 * (width - 5)
        if not self._by_vehicle or columns < 2:
            pane.show(curve_lines(state, width, height, look))
            return
        wanted = (state.team_map.version, state.newest_ms // 1_000, columns)
        if self._curves is None or self._curves[0] != wanted:
            curves = contribution_curves(state.team_map, state.started_ms, state.newest_ms, columns)
            self._curves = (wanted, curves)
        pane.show(curve_lines(state, width, height, look, self._curves[1]))

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


def _sign(number: int) -> int:
    return (number > 0) - (number < 0)
