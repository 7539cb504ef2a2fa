"""Asks before the dashboard is left."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from textual.binding import BindingType

from ground_station.picture import Phase
from ground_station.screens.dialog import Dialog
from ground_station.views import palette
from ground_station.views.ink import Line, line_of, wrapped


class LeaveDialog(Dialog):
    """Leaving takes nothing from the mission: the dialog says so."""

    WIDTH = 56
    BINDINGS: ClassVar[list[BindingType]] = [
        ("enter,y,q", "leave", "leave"),
        ("escape,n", "cancel", "stay"),
    ]

    def action_leave(self) -> None:
        self.app.exit()

    def action_cancel(self) -> None:
        self.dismiss()

    def content(self, width: int, height: int) -> Sequence[Line]:
        ended = self.state.phase is Phase.DONE
        text = (
            "The mission has ended."
            if ended
            else "The mission goes on without the dashboard: the vehicles fly by themselves. "
            "A dashboard that is started again rebuilds the whole picture."
        )
        return [
            line_of(("Leave the ground station?", self.look.ink(palette.ACCENT, bold=True))),
            (),
            *(line_of(piece) for piece in wrapped(text, width)),
            (),
            line_of(("enter leave   esc stay", self.look.ink(palette.QUIET))),
        ]
