"""Text from the wire, made safe and of known width before it can reach a terminal."""

from __future__ import annotations

import unicodedata

REPLACEMENT = "?"


def clean(text: str, limit: int = 160) -> str:
    """Return printable one-column characters only, at most `limit`; what was cut off is shown by a last `…`.

    Control, format, private, surrogate and unassigned characters (escape sequences, bidirectional overrides) and
    wide characters become `?`; combining marks are left out; any white space becomes one blank.
    """
    if text.isascii() and text.isprintable():
        safe = text
    else:
        safe = "".join(_safe(character) for character in text[: 4 * limit])
    return safe if len(safe) <= limit else safe[: limit - 1] + "…"


def _safe(character: str) -> str:
    if character.isspace():
        return " "
    category = unicodedata.category(character)
    if category[0] == "M":
        return ""
    if category[0] in "CZ" or unicodedata.east_asian_width(character) in "WF":
        return REPLACEMENT
    return character


def duration(seconds: float) -> str:
    """Hours, minutes and seconds, e.g. `0:02:05`."""
    whole = max(0, int(seconds))
    return f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d}"


def age(seconds: float) -> str:
    """An age in at most four columns: `0.4s`, `12s`, `4m`, `3h`."""
    if seconds < 9.95:
        return f"{max(0.0, seconds):.1f}s"
    if seconds < 99.5:
        return f"{seconds:.0f}s"
    return f"{seconds / 60:.0f}m" if seconds < 5_970 else f"{seconds / 3600:.0f}h"


def data_rate(bytes_per_s: float) -> str:
    """A data rate in a few columns: `840B/s`, `1.4kB/s`."""
    if bytes_per_s < 999.5:
        return f"{bytes_per_s:.0f}B/s"
    return f"{bytes_per_s / 1_000:.1f}kB/s" if bytes_per_s < 99_950 else f"{bytes_per_s / 1_000:.0f}kB/s"
