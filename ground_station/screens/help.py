"""Keys and glyphs on one page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from textual.binding import BindingType

from ground_station.picture import FleetState
from ground_station.screens.dialog import Dialog
from ground_station.views import palette
from ground_station.views.ink import Ink, Line, Look, line_of

KEYS = (
    ("h r", "hold: stop and stay; resume the mission"),
    ("b L", "return home, land, disarm; land where they are"),
    ("o p", "send a vehicle to the cursor and hold; visit it and go on"),
    ("d enter", "draw a polygon at the cursor: zone, area or sector"),
    ("a k", "areas and zones: import, lift, share out; speed limit"),
    ("n", "re-plan: what is proposed after a loss or a join"),
    ("t", "troubles: what is wrong, what to do; acknowledge, mute"),
    ("q ^C", "leave, the mission goes on; stop a whole `missions run`"),
    ("^P T", "command palette; theme: night, day, mono"),
)
LOOKING = (
    ("tab", "choose a vehicle: orders, follow, events of it"),
    ("+ - 0", "zoom in, out, whole area; arrows move (shift: far)"),
    ("c f", "cursor with read-out; follow the chosen vehicle"),
    ("g l", "ground colours; layers of the map"),
    ("v", "coverage curve of the team, or one for each vehicle"),
    ("e s", "only graver events; only the chosen vehicle's"),
    ("PgUp PgDn", "scroll the events; End follows again"),
    ("mouse", "click: cursor; wheel: zoom, or scroll the events"),
    ("space", "replay: pause; [ ] seek, . step, < > speed"),
)


class HelpDialog(Dialog):
    """Three pages; space turns them, escape closes."""

    WIDTH = 74
    BINDINGS: ClassVar[list[BindingType]] = [
        ("escape,enter,q,question_mark", "cancel", "close"),
        ("space,right,down", "turn(1)", "next page"),
        ("left,up", "turn(-1)", "page before"),
    ]

    def __init__(self, look: Look, state: FleetState) -> None:
        super().__init__(look, state)
        self._page = 0

    def action_cancel(self) -> None:
        self.dismiss()

    def action_turn(self, pages: int) -> None:
        self._page = (self._page + pages) % 3
        self.redraw()

    def content(self, width: int, height: int) -> Sequence[Line]:
        look = self.look
        strong = look.ink(palette.ACCENT, bold=True)
        foot = line_of(
            (f"page {self._page + 1} of 3   space next page   esc close", look.ink(palette.QUIET)),
        )
        if self._page < 2:
            title, keys = (("Keys: the fleet", KEYS), ("Keys: looking", LOOKING))[self._page]
            rows = [line_of((f"  {key:<10}", look.ink(bold=True)), meaning) for key, meaning in keys]
            return [line_of((title, strong)), *rows, (), foot]
        return [*self._glyphs(strong), foot]

    def _glyphs(self, strong: Ink) -> list[Line]:
        glyph = self.look.glyph
        return [
            line_of(("States", strong)),
            line_of(f"  {glyph('●', '*')} working  {glyph('■', '=')} holding  {glyph('◀', '<')} returning or landing"),
            line_of(
                f"  {glyph('✔', '+')} done  {glyph('▲', '!')} refused, or a pilot took over  {glyph('◌', 'o')} starting"
            ),
            line_of(f"  {glyph('◐', '?')} status overdue  {glyph('✖', 'X')} lost  {glyph('○', '.')} not heard yet"),
            line_of(("Map", strong)),
            line_of(f"  number and arrow: vehicle and heading   {glyph('◇', 'x')} goal   {glyph('⌂', 'H')} home"),
            line_of("  bright line: reserved leg; dotted: way after it; dim: trail"),
            line_of("  dark: unobserved; light edge: frontier; blue to yellow: low to high"),
            line_of("  red hatch: no-fly zone; blue border: the area by your order"),
            line_of(("Roster, the most troubled first", strong)),
            line_of("  batt: charge   age: since the last status   then: share of the"),
            line_of("  area seen first, bytes sent per vehicle second, and why it goes"),
        ]
