"""What is wrong, what the fleet does about it, and what the operator can do; acknowledge and mute."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import ClassVar

from textual.binding import BindingType

from ground_station.conditions import Trouble
from ground_station.picture import FleetState
from ground_station.screens.dialog import Dialog
from ground_station.text import age
from ground_station.views import palette
from ground_station.views.ink import Line, Look, line_of, wrapped
from vehicle_agent.wire.messages import Severity


class TroublesDialog(Dialog):
    """A list of troubles, and the chosen one explained.

    Parameters
    ----------
    acknowledge, mute
        Called with the chosen trouble; muting a muted one unmutes it.
    """

    WIDTH = 74
    BINDINGS: ClassVar[list[BindingType]] = [
        ("up,k", "choose(-1)", "up"),
        ("down,j", "choose(1)", "down"),
        ("enter,a", "acknowledge", "acknowledge"),
        ("m", "mute", "mute"),
        ("escape,q,t", "cancel", "close"),
    ]

    def __init__(
        self,
        look: Look,
        state: FleetState,
        acknowledge: Callable[[Trouble], None],
        mute: Callable[[Trouble, bool], None],
    ) -> None:
        super().__init__(look, state)
        self._acknowledge, self._mute = acknowledge, mute
        self._at = 0

    @property
    def chosen(self) -> Trouble | None:
        troubles = self.state.troubles
        return troubles[min(self._at, len(troubles) - 1)] if troubles else None

    def action_choose(self, step: int) -> None:
        self._at = min(max(0, self._at + step), max(0, len(self.state.troubles) - 1))
        self.redraw()

    def action_acknowledge(self) -> None:
        if self.chosen is not None:
            self._acknowledge(self.chosen)

    def action_mute(self) -> None:
        if self.chosen is not None:
            self._mute(self.chosen, not self._is_muted(self.chosen))

    def action_cancel(self) -> None:
        self.dismiss()

    def content(self, width: int, height: int) -> Sequence[Line]:
        look, quiet = self.look, self.look.ink(palette.QUIET)
        chosen = self.chosen
        count = len(self.state.troubles)
        head = line_of((f"Troubles: {count}" if count else "Nothing is wrong", look.ink(palette.ACCENT, bold=True)))
        keys = line_of(("enter acknowledge   m mute   up/down choose   esc close", quiet))
        if chosen is None:
            return [head, (), line_of(("esc close", quiet))]
        advice: list[Line] = []
        for label, text in (
            ("it is so:  ", chosen.text),
            ("the fleet: ", chosen.fleet_does),
            ("you can:   ", chosen.operator_can),
        ):
            for at, piece in enumerate(wrapped(text, width - len(label))):
                advice.append(line_of((label if at == 0 else " " * len(label), quiet), piece))
        room = max(1, height - len(advice) - 4)
        first = max(0, min(self._at, count - 1) - room + 1)
        rows = [self._row(one, one is chosen, width) for one in self.state.troubles[first : first + room]]
        return [head, *rows, (), *advice, (), keys]

    def _row(self, trouble: Trouble, chosen: bool, width: int) -> Line:
        look = self.look
        colour = palette.BAD if trouble.severity <= Severity.ERROR else palette.WARN
        seen = trouble.acknowledged or self._is_muted(trouble)
        note = "muted" if self._is_muted(trouble) else "seen" if trouble.acknowledged else ""
        since = age(self.state.now_s - trouble.since_s)
        text = f"{trouble.text[: max(8, width - 46)]} {note}".rstrip()
        return line_of(
            (look.glyph("▸ ", "> ") if chosen else "  ", look.ink(palette.ACCENT, bold=True)),
            (f"{trouble.vehicle[:12]:<13}", look.ink(bold=chosen)),
            (f"{trouble.kind.value:<17}", look.ink(None if seen else colour, bold=chosen)),
            (f"{since:>5} ", look.ink(palette.QUIET)),
            (text, look.ink(dim=seen)),
        )

    def _is_muted(self, trouble: Trouble) -> bool:
        return (trouble.vehicle, trouble.kind) in self.state.muted
