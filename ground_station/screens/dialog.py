"""What all dialogs share: a framed box of lines over the dashboard."""

from __future__ import annotations

from collections.abc import Sequence

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.screen import ModalScreen

from ground_station.picture import FleetState
from ground_station.views.ink import Line, Look
from ground_station.widgets.lines import Lines


class Dialog(ModalScreen[None]):
    """A box whose lines `content` makes anew for every state; it is as high as they need."""

    WIDTH = 60

    def __init__(self, look: Look, state: FleetState) -> None:
        super().__init__()
        self.look = look
        self.state = state

    def compose(self) -> ComposeResult:
        with Vertical(id="box"):
            yield Lines(id="content")

    def on_mount(self) -> None:
        box = self.query_one("#box")
        box.set_class(not self.look.unicode, "ascii")
        box.styles.width = min(self.WIDTH, self.app.size.width)
        self.show(self.state)

    def on_resize(self) -> None:
        self.query_one("#box").styles.width = min(self.WIDTH, self.app.size.width)
        self.call_after_refresh(self.redraw)

    def show(self, state: FleetState) -> None:
        """Draw with a newer picture."""
        self.state = state
        self.redraw()

    def redraw(self) -> None:
        lines = self.query_one("#content", Lines)
        room = max(4, self.app.size.height - 4)
        content = self.content(max(20, min(self.WIDTH, self.app.size.width) - 4), room)
        height = min(len(content), room)
        if lines.styles.height is None or lines.styles.height.value != height:
            lines.styles.height = height
            self.call_after_refresh(self.redraw)
            return
        lines.show(content)

    def content(self, width: int, height: int) -> Sequence[Line]:
        """The dialog's lines; at most `height` of them are seen."""
        raise NotImplementedError
