"""The line that tells where a replay stands and which keys move it."""

from __future__ import annotations

from ground_station.player import Player
from ground_station.text import duration
from ground_station.views import palette
from ground_station.views.ink import Line, Look, line_of


def replay_line(player: Player, look: Look) -> Line:
    """`REPLAY > x4 0:03:12 / 0:09:55  space pause  [ ] 10 s  . step  < > speed`, and what is wrong with the file."""
    going = player.playing and not player.at_end
    sign = look.glyph("▶", ">") if going else look.glyph("■", "=") if player.at_end else look.glyph("‖", "|")
    place = f"{duration(player.position_s)} / {duration(player.recording.length_s)}"
    head = (f" REPLAY {sign} {look.glyph('×', 'x')}{player.speed:g} {place} ", look.ink(palette.ACCENT, bold=True))  # noqa: RUF001
    if not player.recording.complete:
        return line_of(head, (" cut off or damaged: this is all there is", look.ink(palette.WARN, bold=True)))
    keys = " space pause  [ ] 10 s  . step  < > speed"
    return line_of(head, (keys, look.ink(palette.QUIET)))
