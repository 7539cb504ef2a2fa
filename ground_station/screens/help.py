"""Keys and glyphs on one page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from textual.binding import BindingType

from ground_station.screens.dialog import Dialog
from ground_station.views import palette
from ground_station.views.ink import Line, line_of

KEYS = (
    ("h", "hold: stop and stay (asks first, lists the vehicles)"),
    ("r", "resume the mission after a hold"),
    ("b or x", "bring back: return home, land, disarm"),
    ("PgUp PgDn", "scroll the event log; End follows again"),
    ("q", "leave; the mission goes on without the dashboard"),
    ("?", "this page"),
)


class HelpDialog(Dialog):
    """Any of its keys closes it."""

    WIDTH = 70
    BINDINGS: ClassVar[list[BindingType]] = [("escape,enter,q,question_mark,space", "cancel", "close")]

    def action_cancel(self) -> None:
        self.dismiss()

    def content(self, width: int, height: int) -> Sequence[Line]:
        look = self.look
        strong = look.ink(palette.ACCENT, bold=True)
        lines: list[Line] = [line_of(("Keys", strong))]
        lines += [line_of((f"  {key:<10}", look.ink(bold=True)), meaning) for key, meaning in KEYS]
        lines += [line_of(("States", strong))]
        glyph = look.glyph
        lines += [
            line_of(f"  {glyph('●', '*')} working  {glyph('■', '=')} holding  {glyph('◀', '<')} returning or landing"),
            line_of(
                f"  {glyph('✔', '+')} done  {glyph('▲', '!')} refused, or a pilot took over  {glyph('◌', 'o')} starting"
            ),
            line_of(f"  {glyph('◐', '?')} status overdue  {glyph('✖', 'X')} lost  {glyph('○', '.')} not heard yet"),
            line_of(("Map", strong)),
            line_of(f"  number and arrow: vehicle and heading   {glyph('◇', 'x')} goal   {glyph('⌂', 'H')} home"),
            line_of("  bright line: reserved leg; dotted: way after it; dim: trail"),
            line_of("  dark: unobserved; light edge: frontier; blue to yellow: low to high"),
            line_of(("Roster", strong)),
            line_of("  batt: charge   age: since the last status   then: share of the"),
            line_of("  area seen first, bytes sent per vehicle second, and why it goes"),
            line_of(("esc close", look.ink(palette.QUIET))),
        ]
        return lines
