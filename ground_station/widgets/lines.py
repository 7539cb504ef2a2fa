"""One widget for every part of the dashboard: it shows lines and repaints only what differs from before."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

from rich.color import Color
from rich.segment import Segment
from rich.style import Style
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

from ground_station.views.ink import Ink, Line, Rgb, fitted
from ground_station.views.theme import THEMES


class Lines(Widget):
    """Shows exactly the lines it was last given, cut or filled to its size, in the app's theme."""

    can_focus = False
    ALLOW_SELECT = False

    def __init__(self, id: str | None = None, classes: str | None = None) -> None:  # noqa: A002 (Textual's own name)
        super().__init__(id=id, classes=classes)
        self._lines: list[Line] = []

    def preset(self, lines: Sequence[Line], width: int) -> None:
        """Take lines before there is a size, so that the first frame shows them."""
        self._lines = [fitted(line, width) for line in lines]

    def show(self, lines: Sequence[Line]) -> None:
        """Draw these lines; what is equal to before is not sent to the terminal again."""
        width, height = self.size
        new = [fitted(line, width) for line in list(lines)[:height]]
        old = self._lines
        self._lines = new
        if len(old) != len(new):
            self.refresh()
            return
        # Textual sends a line from the widget's left edge to the region's right one, so one region a line is cheapest.
        changed = [
            Region(0, y, last_difference(before, after), 1)
            for y, (before, after) in enumerate(zip(old, new, strict=True))
            if before != after
        ]
        if changed:
            self.refresh(*changed)

    @property
    def theme_name(self) -> str:
        """The app says which of `THEMES` it wears."""
        return str(getattr(self.app, "theme_name", "night"))

    def render_line(self, y: int) -> Strip:
        ground = self.rich_style
        if y >= len(self._lines):
            return Strip.blank(self.size.width, ground)
        theme = THEMES[self.theme_name]
        segments = [Segment(text, ground + _style(ink, theme.turn)) for text, ink in self._lines[y]]
        return Strip(segments).adjust_cell_length(self.size.width, ground)

    @property
    def text(self) -> str:
        """What is shown, without styles."""
        return "\n".join("".join(text for text, _ in line).rstrip() for line in self._lines)


@lru_cache(maxsize=4096)
def _style(ink: Ink, turn: Callable[[Rgb], Rgb]) -> Style:
    return Style(
        color=None if ink.fg is None else Color.from_rgb(*turn(ink.fg)),
        bgcolor=None if ink.bg is None else Color.from_rgb(*turn(ink.bg)),
        bold=ink.bold or None,
        dim=ink.dim or None,
        reverse=ink.reverse or None,
    )


def last_difference(before: Line, after: Line) -> int:
    """One past the last column in which two lines differ; 0 when they look the same."""
    old, new = _cells(before), _cells(after)
    if len(old) != len(new):
        return max(len(old), len(new))
    return next((x + 1 for x in range(len(new) - 1, -1, -1) if old[x] != new[x]), 0)


def _cells(line: Line) -> list[tuple[str, Ink]]:
    return [(character, ink) for text, ink in line for character in text]
