"""Asks before the dashboard is left."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from textual.binding import BindingType

from ground_station.picture import FleetState, Phase
from ground_station.screens.dialog import Dialog
from ground_station.views import palette
from ground_station.views.ink import Line, Look, line_of, wrapped

OPERATOR_INTERRUPT = 130
"""Exit code that tells whoever started the dashboard that the operator wants everything to stop."""


class LeaveDialog(Dialog):
    """Leaving takes nothing from the mission, stopping ends it: the dialog says which."""

    WIDTH = 56
    BINDINGS: ClassVar[list[BindingType]] = [
        ("enter,y,q", "leave", "leave"),
        ("escape,n", "cancel", "stay"),
    ]

    def __init__(self, look: Look, state: FleetState, stops_mission: bool = False) -> None:
        super().__init__(look, state)
        self._stops_mission = stops_mission

    def action_leave(self) -> None:
        self.app.exit(return_code=OPERATOR_INTERRUPT if self._stops_mission else 0)

    def action_cancel(self) -> None:
        self.dismiss()

    def content(self, width: int, height: int) -> Sequence[Line]:
        ended = self.state.phase is Phase.DONE
        question = "Stop the whole mission?" if self._stops_mission else "Leave the ground station?"
        text = (
            "All programs of this run end. Simulated vehicles vanish where they are; a real vehicle without its agent "
            "is brought home by its autopilot's failsafe. To bring all home first: esc, then b."
            if self._stops_mission
            else "The mission has ended."
            if ended
            else "The mission goes on without the dashboard: the vehicles fly by themselves. "
            "A dashboard that is started again rebuilds the whole picture."
        )
        return [
            line_of((question, self.look.ink(palette.ACCENT, bold=True))),
            (),
            *(line_of(piece) for piece in wrapped(text, width)),
            (),
            line_of(
                (
                    ("enter stop everything" if self._stops_mission else "enter leave") + "   esc stay",
                    self.look.ink(palette.QUIET),
                )
            ),
        ]
