"""Shows what the re-planning policy would send, and what it expects of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import ClassVar

from textual.binding import BindingType

from ground_station.payload import described
from ground_station.picture import FleetState
from ground_station.prediction import Prediction
from ground_station.replan import Proposal
from ground_station.screens.dialog import Dialog
from ground_station.text import duration
from ground_station.views import palette
from ground_station.views.ink import Line, Look, line_of


class ProposalDialog(Dialog):
    """Enter sends every step once; n leaves it to the agents; escape decides later."""

    WIDTH = 72
    BINDINGS: ClassVar[list[BindingType]] = [
        ("enter,y", "accept", "send"),
        ("n", "decline", "leave it to the agents"),
        ("escape,q", "cancel", "later"),
    ]

    def __init__(
        self,
        look: Look,
        state: FleetState,
        proposal: Proposal,
        accept: Callable[[], None],
        decline: Callable[[], None],
    ) -> None:
        super().__init__(look, state)
        self._proposal, self._accept, self._decline = proposal, accept, decline
        self._first_number: int | None = None

    def action_accept(self) -> None:
        if self._first_number is not None:
            self.dismiss()
            return
        sent = [track.command.command_id for track in self.state.commands]
        self._first_number = max(sent, default=-1) + 1
        self._accept()
        self.redraw()

    def action_decline(self) -> None:
        if self._first_number is None:
            self._decline()
        self.dismiss()

    def action_cancel(self) -> None:
        self.dismiss()

    def content(self, width: int, height: int) -> Sequence[Line]:
        look, quiet, proposal = self.look, self.look.ink(palette.QUIET), self._proposal
        lines = [
            line_of((f"Re-plan: {proposal.cause}", look.ink(palette.ACCENT, bold=True))),
            line_of(("time to go  ", quiet), f"{_words(proposal.before)} before, {_words(proposal.after)} now"),
            (),
        ]
        if self._first_number is not None:
            return [*lines, *self._results(height - len(lines) - 2), (), line_of(("enter or esc close", quiet))]
        room = max(1, height - len(lines) - 2)
        for step in proposal.steps[:room]:
            word, _ = described(step.verb, step.payload)
            lines.append(line_of((f"{word:<22.22}", look.ink(bold=True)), f"to {', '.join(step.targets)}"))
        return [*lines, (), line_of(("enter send   n leave it to the agents   esc later", quiet))]

    def _results(self, room: int) -> list[Line]:
        """What became of each step at each vehicle."""
        look = self.look
        rows: list[Line] = []
        for track in self.state.commands:
            if self._first_number is not None and track.command.command_id >= self._first_number:
                for name in track.command.targets:
                    result = track.result_of(name, self.state.now_s)
                    good = result.startswith("accepted")
                    ink = look.ink(palette.GOOD if good else palette.QUIET if result == "sent" else palette.BAD)
                    rows.append(line_of(f"{track.command.verb.name.lower():<10}{name:<14}", (result, ink)))
        return rows[: max(1, room)] or [line_of("nothing was sent")]


def _words(prediction: Prediction | None) -> str:
    if prediction is None:
        return "unknown"
    return duration(prediction.remaining_s) + (" (time limit)" if prediction.cut_short else "")
