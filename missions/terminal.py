"""Gives the terminal back as it was, also after a full-screen program was killed on it."""

from __future__ import annotations

import os
import sys
import termios
from dataclasses import dataclass
from typing import Any

LEAVE_FULL_SCREEN = (
    "\x1b[?1000l\x1b[?1002l\x1b[?1003l\x1b[?1006l\x1b[?1015l"  # mouse reports off
    "\x1b[?2004l\x1b[?1004l\x1b[<u"  # bracketed paste, focus reports and the keyboard protocol off
    "\x1b[?1049l\x1b[?7h\x1b[?25h\x1b[0m"  # main screen, wrapping, cursor, plain colours
)


@dataclass(frozen=True, slots=True)
class Terminal:
    """The terminal of standard input, output and error, with its settings at the time of `grab`."""

    settings: list[Any]

    @classmethod
    def grab(cls) -> Terminal | None:
        """Remember the terminal's settings; None when standard input, output or error is no terminal."""
        if not all(stream.isatty() for stream in (sys.stdin, sys.stdout, sys.stderr)):
            return None
        try:
            return cls(termios.tcgetattr(sys.stdin.fileno()))
        except termios.error:
            return None

    def restore(self) -> None:
        """Leave full-screen mode, drop unread keys and set the remembered settings.

        Only after a program was killed in full-screen mode: leaving it twice moves the cursor back to where it was.
        """
        try:
            termios.tcsetattr(sys.stdin.fileno(), termios.TCSAFLUSH, self.settings)
            os.write(sys.stdout.fileno(), LEAVE_FULL_SCREEN.encode())
        except (termios.error, OSError):
            return  # the terminal is gone
