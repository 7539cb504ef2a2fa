"""Asks before an order is sent, lists whom it is for, then shows what became of it per vehicle."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import ClassVar

from textual.binding import BindingType

from ground_station.failsafe_ways import straight_home_through
from ground_station.payload import NOTHING, Payload, described
from ground_station.picture import CommandTrack, FleetState, VehiclePicture
from ground_station.screens.dialog import Dialog
from ground_station.views import palette
from ground_station.views.ink import Line, Look, line_of, wrapped
from vehicle_agent.wire.messages import Verb

Send = Callable[[Verb, Sequence[str], Payload], int | None]


class CommandDialog(Dialog):
    """All vehicles (or the chosen one) are targets at first; up and down choose one, `a` all of them again."""

    WIDTH = 66
    BINDINGS: ClassVar[list[BindingType]] = [
        ("up,k", "choose(-1)", "one vehicle up"),
        ("down,j", "choose(1)", "one vehicle down"),
        ("a", "all", "all vehicles"),
        ("enter,y", "confirm", "send"),
        ("escape,n,q", "cancel", "cancel"),
    ]

    def __init__(
        self, look: Look, state: FleetState, verb: Verb, send: Send, payload: Payload = NOTHING, chosen: str = ""
    ) -> None:
        super().__init__(look, state)
        self.verb = verb
        self.payload = payload
        self._send = send
        names = state.plan.vehicle_names
        self._chosen: int | None = names.index(chosen) if chosen in names else None
        self._command_id: int | None = None
        self._unsent = False

    @property
    def targets(self) -> tuple[str, ...]:
        names = tuple(vehicle.name for vehicle in self.state.vehicles)
        return names if self._chosen is None else (names[self._chosen],)

    @property
    def track(self) -> CommandTrack | None:
        """The command once it is sent."""
        return next((one for one in self.state.commands if one.command.command_id == self._command_id), None)

    def action_choose(self, step: int) -> None:
        if self._command_id is None:
            count = len(self.state.vehicles)
            start = (-1 if step > 0 else count) if self._chosen is None else self._chosen
            self._chosen = min(max(start + step, 0), count - 1)
            self.redraw()

    def action_all(self) -> None:
        if self._command_id is None:
            self._chosen = None
            self.redraw()

    def action_confirm(self) -> None:
        if self._command_id is not None:
            self.dismiss()
            return
        self._command_id = self._send(self.verb, self.targets, self.payload)
        self._unsent = self._command_id is None
        self.redraw()

    def action_cancel(self) -> None:
        self.dismiss()

    def content(self, width: int, height: int) -> Sequence[Line]:
        quiet = self.look.ink(palette.QUIET)
        word, meaning = described(self.verb, self.payload)
        targets = self.targets
        whom = targets[0] if len(targets) == 1 else f"all {len(targets)} vehicles"
        track = self.track
        mark = "" if track else "?"
        lines = [
            line_of((f"{word}: {whom}{mark}", self.look.ink(palette.ACCENT, bold=True)), (f"  {meaning}", quiet)),
            (),
        ]
        if track is None and self.verb is Verb.NO_FLY:
            lines += self._failsafe_note(width)
        if self._unsent:
            lines.append(line_of(("not sent: there is no link to the fleet", self.look.ink(palette.BAD, bold=True))))
        rows = [
            self._row(vehicle, track) for vehicle in self.state.vehicles if track is None or vehicle.name in targets
        ]
        room = max(1, height - len(lines) - 2)
        if len(rows) > room:
            first = min(max(0, (self._chosen or 0) - room // 2), len(rows) - room)
            rows = rows[first : first + room]
        keys = "enter send   up/down one vehicle   a all   esc cancel" if track is None else "enter or esc close"
        return [*lines, *rows, (), line_of((keys, quiet))]

    def _failsafe_note(self, width: int) -> list[Line]:
        """Agents keep out of a zone; an autopilot that has lost its agent knows nothing of it."""
        names = straight_home_through(self.state, self.payload.polygon_cm)
        if not names:
            return []
        text = f"should an agent die, its autopilot flies straight home through it: {', '.join(names)}"
        return [*(line_of((piece, self.look.ink(palette.WARN))) for piece in wrapped(text, width)), ()]

    def _row(self, vehicle: VehiclePicture, track: CommandTrack | None) -> Line:
        chosen = vehicle.name in self.targets
        unicode_mark, ascii_mark, colour = palette.state_mark(vehicle)
        name = vehicle.name if len(vehicle.name) <= 12 else vehicle.name[:11] + self.look.glyph("…", ".")
        pointer = self.look.glyph("▸ ", "> ") if chosen else "  "
        mode = vehicle.status.mode if vehicle.status else ""
        spans = [
            (pointer, self.look.ink(palette.ACCENT, bold=True)),
            (f"{name:<13}", self.look.ink(palette.vehicle_colour(vehicle.index), bold=chosen, dim=not chosen)),
            (f"{self.look.glyph(unicode_mark, ascii_mark)} ", self.look.ink(colour)),
        ]
        if track is None:
            return line_of(*spans, (f"{palette.state_word(vehicle):<11}{mode}", self.look.ink(dim=not chosen)))
        result = track.result_of(vehicle.name, self.state.now_s)
        ink = {"a": self.look.ink(palette.GOOD), "s": self.look.ink(palette.QUIET)}.get(
            result[0], self.look.ink(palette.BAD, bold=True)
        )
        return line_of(*spans, (f"{palette.state_word(vehicle):<11}", self.look.ink()), (result, ink))
