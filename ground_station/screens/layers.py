"""Which layers the map shows, and what its colours mean."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import ClassVar

from textual import events
from textual.binding import BindingType

from ground_station.picture import FleetState
from ground_station.screens.dialog import Dialog
from ground_station.views import palette
from ground_station.views.ink import Line, Look, line_of
from ground_station.views.window import Ground, Layer, MapWindow


class LayersDialog(Dialog):
    """A letter per ground colouring, a digit per layer; every key acts at once."""

    WIDTH = 48
    BINDINGS: ClassVar[list[BindingType]] = [("escape,enter,q,l", "cancel", "close")]

    def __init__(self, look: Look, state: FleetState, window: MapWindow, change: Callable[[MapWindow], None]) -> None:
        super().__init__(look, state)
        self._window, self._change = window, change

    def action_cancel(self) -> None:
        self.dismiss()

    def on_key(self, event: events.Key) -> None:
        layers = list(Layer)
        if event.key.isdigit() and 1 <= int(event.key) <= len(layers):
            self._window = self._window.toggled(layers[int(event.key) - 1])
        elif event.key == "g":
            self._window = self._window.with_next_ground()
        else:
            return
        event.stop()
        self._change(self._window)
        self.redraw()

    def content(self, width: int, height: int) -> Sequence[Line]:
        look = self.look
        strong, quiet = look.ink(palette.ACCENT, bold=True), look.ink(palette.QUIET)
        lines: list[Line] = [line_of(("Map layers", strong))]
        for number, layer in enumerate(Layer, 1):
            mark = "x" if layer in self._window.layers else " "
            lines.append(line_of((f"  {number} ", look.ink(bold=True)), f"[{mark}] {layer.value}"))
        lines += [(), line_of(("Ground colours (g)", strong))]
        for ground in Ground:
            lines.append(line_of(f"   ({'*' if ground is self._window.ground else ' '}) {ground.value}"))
        return [*lines, (), line_of(("digits toggle   g next ground   esc close", quiet))]
