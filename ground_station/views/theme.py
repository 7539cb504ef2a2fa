"""Themes: the same picture for a dark room, for daylight, and without colours."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ground_station.views.ink import Rgb


@dataclass(frozen=True, slots=True)
class Theme:
    """How every colour of the picture is turned into one on the screen.

    Attributes
    ----------
    name
        For the command line and the palette.
    background, text
        Of everything that has no colour of its own.
    turn
        Applied to every other colour.
    """

    name: str
    background: Rgb
    text: Rgb
    turn: Callable[[Rgb], Rgb]


def same(colour: Rgb) -> Rgb:
    return colour


def inverted(colour: Rgb) -> Rgb:
    """Light for dark with the hue kept: what stands out on black stands out on white."""
    top, bottom = max(colour), min(colour)
    red, green, blue = (255 - top - bottom + part for part in colour)
    return (red, green, blue)


def grey(colour: Rgb) -> Rgb:
    level = round(0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2])
    return (level, level, level)


THEMES: dict[str, Theme] = {
    theme.name: theme
    for theme in (
        Theme("night", (0x0B, 0x0D, 0x10), (0xD8, 0xDC, 0xE2), same),
        Theme("day", (0xFA, 0xFA, 0xF6), (0x1C, 0x20, 0x26), inverted),
        Theme("mono", (0x0B, 0x0D, 0x10), (0xD8, 0xDC, 0xE2), grey),
    )
}
"""All are safe for any colour vision: night and day rest on cividis and on Okabe and Ito's set."""


def next_theme(name: str) -> str:
    names = list(THEMES)
    return names[(names.index(name) + 1) % len(names)]
