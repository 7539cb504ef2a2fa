"""Lines of styled text, and the looks (colour or none, Unicode or ASCII) they are made for."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

Rgb = tuple[int, int, int]


@dataclass(frozen=True, slots=True)
class Ink:
    """How a span of text is drawn; None stands for the surrounding colour."""

    fg: Rgb | None = None
    bg: Rgb | None = None
    bold: bool = False
    dim: bool = False
    reverse: bool = False


PLAIN = Ink()
Span = tuple[str, Ink]
Line = tuple[Span, ...]


@dataclass(frozen=True, slots=True)
class Look:
    """What the terminal can show.

    Attributes
    ----------
    unicode
        Block, braille and arrow characters; ASCII only when false.
    colour
        Colours; when false only bold, dim and reverse, and glyphs carry every meaning.
    """

    unicode: bool = True
    colour: bool = True

    def glyph(self, unicode: str, ascii_: str) -> str:
        return unicode if self.unicode else ascii_

    def ink(
        self, fg: Rgb | None = None, bg: Rgb | None = None, bold: bool = False, dim: bool = False
    ) -> Ink:  # fmt: skip
        return Ink(fg, bg, bold, dim) if self.colour else Ink(bold=bold, dim=dim)


def line_of(*spans: Span | str) -> Line:
    return tuple((span, PLAIN) if isinstance(span, str) else span for span in spans)


def width_of(line: Line) -> int:
    return sum(len(text) for text, _ in line)


def fitted(line: Line, width: int) -> Line:
    """The line cut or filled with blanks to exactly `width` columns."""
    left = width
    spans: list[Span] = []
    for text, ink in line:
        if left <= 0:
            break
        spans.append((text[:left], ink))
        left -= len(text)
    if left > 0:
        spans.append((" " * left, PLAIN))
    return tuple(spans)


def filled(lines: Iterable[Line], width: int, height: int) -> list[Line]:
    """Exactly `height` lines of exactly `width` columns."""
    kept = [fitted(line, width) for line in lines][:height]
    return kept + [fitted((), width)] * (height - len(kept))


def text_of(line: Line) -> str:
    return "".join(text for text, _ in line)


def wrapped(text: str, width: int, first_indent: int = 0) -> list[str]:
    """Words of a text in lines of at most `width` columns, the first shorter by `first_indent`."""
    lines = [""]
    for word in text.split():
        for piece in [word[at : at + width] for at in range(0, len(word), width)]:
            room = width - first_indent if len(lines) == 1 else width
            joined = f"{lines[-1]} {piece}" if lines[-1] else piece
            if len(joined) <= room:
                lines[-1] = joined
            else:
                lines.append(piece)
    return lines
