"""Asks for one line of text: a speed, a file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import ClassVar

from textual import events
from textual.binding import BindingType

from ground_station.picture import FleetState
from ground_station.screens.dialog import Dialog
from ground_station.text import clean
from ground_station.views import palette
from ground_station.views.ink import Line, Look, line_of, wrapped

MAX_LENGTH = 400


class EntryDialog(Dialog):
    """Takes printable keys and pasted text.

    Parameters
    ----------
    question
        What is asked for.
    done
        Called with the line; returns why it will not do, or an empty text after which the dialog closes.
    """

    WIDTH = 70
    BINDINGS: ClassVar[list[BindingType]] = [("escape", "cancel", "cancel"), ("enter", "confirm", "confirm")]

    def __init__(self, look: Look, state: FleetState, question: str, done: Callable[[str], str]) -> None:
        super().__init__(look, state)
        self._question, self._done = question, done
        self._text = self._trouble = ""

    def action_cancel(self) -> None:
        self.dismiss()

    def action_confirm(self) -> None:
        text = self._text.strip()
        trouble = self._done(text)
        if trouble:
            self._trouble = trouble
            self.redraw()

    def on_key(self, event: events.Key) -> None:
        if event.key in ("backspace", "ctrl+h"):
            self._text = self._text[:-1]
        elif event.is_printable and event.character:
            self._text = (self._text + event.character)[:MAX_LENGTH]
        else:
            return
        event.stop()
        self._trouble = ""
        self.redraw()

    def on_paste(self, event: events.Paste) -> None:
        self._text = (self._text + " ".join(event.text.split()))[:MAX_LENGTH]
        self.redraw()

    def content(self, width: int, height: int) -> Sequence[Line]:
        look = self.look
        shown = clean(self._text, MAX_LENGTH)[-(width - 3) :]
        lines = [
            line_of((self._question, look.ink(palette.ACCENT, bold=True))),
            (),
            line_of("> ", shown, (look.glyph("▏", "_"), look.ink(palette.ACCENT))),
            *(line_of((piece, look.ink(palette.BAD))) for piece in wrapped(clean(self._trouble), width) if piece),
            (),
        ]
        return [*lines, line_of(("enter take it   esc cancel", look.ink(palette.QUIET)))]
