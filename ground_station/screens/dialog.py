"""What all dialogs share: a framed box of lines over the dashboard."""

from __future__ import annotations

from collections.abc import Sequence

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.geometry import Size
from textual.screen import ModalScreen
from textual.strip import Strip

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
        self._behind: list[Strip] = []
        self._behind_frame: tuple[int, Size] | None = None

    def compose(self) -> ComposeResult:
        """The box at its right size from the first frame on: a key is answered by one drawing, not by three."""
        width, room = self._room()
        content = list(self.content(width, room))[:room]
        lines = Lines(id="content")
        lines.preset(content, width)
        lines.styles.height = len(content)
        box = Vertical(lines, id="box")
        box.set_class(not self.look.unicode, "ascii")
        box.styles.width = min(self.WIDTH, self.app.size.width)
        yield box

    def render_line(self, y: int) -> Strip:
        """The dashboard behind the box, as it was last drawn: made once per frame, not once per changed pane."""
        board = self.app.screen_stack[0]
        frame = (getattr(board, "frame", 0), self.app.size)
        if frame != self._behind_frame:
            self._behind_frame = frame
            self._behind = board._compositor.render_strips(self.app.size)
        return self._behind[y] if y < len(self._behind) else Strip.blank(self.size.width)

    def on_resize(self) -> None:
        self.query_one("#box").styles.width = min(self.WIDTH, self.app.size.width)
        self.call_after_refresh(self.redraw)

    def show(self, state: FleetState) -> None:
        """Draw with a newer picture."""
        self.state = state
        self.redraw()

    def redraw(self) -> None:
        if not self.query("#content"):
            return
        lines = self.query_one("#content", Lines)
        width, room = self._room()
        content = self.content(width, room)
        height = min(len(content), room)
        if lines.styles.height is None or lines.styles.height.value != height:
            lines.styles.height = height
            self.call_after_refresh(self.redraw)
            return
        lines.show(content)

    def _room(self) -> tuple[int, int]:
        """Columns and lines for the content on this terminal."""
        size = self.app.size
        return max(20, min(self.WIDTH, size.width) - 4), max(4, size.height - 4)

    def content(self, width: int, height: int) -> Sequence[Line]:
        """The dialog's lines; at most `height` of them are seen."""
        raise NotImplementedError
