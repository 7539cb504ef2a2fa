"""The bottom line: which keys do something now."""

from __future__ import annotations

from ground_station.views import palette
from ground_station.views.ink import Line, Look, Span

KEYS = (("h", "hold"), ("r", "resume"), ("b", "home"), ("t", "troubles"), ("c", "cursor"), ("tab", "choose"))
CURSOR_KEYS = (("arrows", "move"), ("o", "send there"), ("p", "visit"), ("d", "draw from here"), ("c", "no cursor"))
DRAWING_KEYS = (("arrows", "move"), ("d", "next corner"), ("enter", "finish"), ("esc", "give up"))
ALWAYS = (("q", "quit"), ("?", "help"))


def key_line(look: Look, width: int, drawing: bool, cursor: object | None) -> Line:
    """As many keys as fit, quitting and help always."""
    chosen = DRAWING_KEYS if drawing else CURSOR_KEYS if cursor is not None else KEYS
    last = _spans(ALWAYS, look)
    room = width - sum(len(text) for text, _ in last)
    spans: list[Span] = []
    for key in chosen:
        fresh = _spans((key,), look)
        if sum(len(text) for text, _ in (*spans, *fresh)) > room:
            break
        spans += fresh
    spans += last
    used = sum(len(text) for text, _ in spans)
    return (*spans, (" " * max(0, width - used), look.ink(bg=palette.BAR)))


def _spans(keys: tuple[tuple[str, str], ...], look: Look) -> list[Span]:
    spans: list[Span] = []
    for key, meaning in keys:
        spans += [
            (f" {key} ", look.ink(palette.ACCENT, palette.BAR, bold=True)),
            (f"{meaning} ", look.ink(bg=palette.BAR)),
        ]
    return spans
