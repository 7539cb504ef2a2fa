"""Asks which of a few things is meant; one key each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import ClassVar

from textual import events
from textual.binding import BindingType

from ground_station.picture import FleetState
from ground_station.screens.dialog import Dialog
from ground_station.views import palette
from ground_station.views.ink import Line, Look, line_of

Option = tuple[str, str, Callable[[], None]]
"""Key, what it does, and the doing."""


class ChoiceDialog(Dialog):
    """The dialog closes before what was chosen is done."""

    WIDTH = 64
    BINDINGS: ClassVar[list[BindingType]] = [("escape,q", "cancel", "cancel")]

    def __init__(self, look: Look, state: FleetState, question: str, options: Sequence[Option]) -> None:
        super().__init__(look, state)
        self._question, self._options = question, options

    def action_cancel(self) -> None:
        self.dismiss()

    def on_key(self, event: events.Key) -> None:
        chosen = next((act for key, _, act in self._options if key == event.key), None)
        if chosen is not None:
            event.stop()
            self.dismiss()
            self.app.call_later(chosen)

    def content(self, width: int, height: int) -> Sequence[Line]:
        look = self.look
        rows = [line_of((f"  {key:<7}", look.ink(bold=True)), text) for key, text, _ in self._options]
        question = line_of((self._question, look.ink(palette.ACCENT, bold=True)))
        return [question, (), *rows, (), line_of(("esc cancel", look.ink(palette.QUIET)))]
