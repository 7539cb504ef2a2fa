"""A program on a terminal of its own, driven by typing lines and waiting for what it shows."""

from __future__ import annotations

import os
import pty
import re
import select
import signal
import subprocess
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path


class Terminal:
    """What a person at the program's terminal does.

    Attributes
    ----------
    shown
        Everything that the program has shown so far.
    """

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._seen = 0
        self.shown = ""

    def type(self, line: str) -> None:
        os.write(self._descriptor, f"{line}\n".encode())

    def expect(self, pattern: str, within_s: float = 30.0) -> str:
        """Wait until a pattern shows up after what was expected last; returns what matched."""
        end_s = time.monotonic() + within_s
        while (match := re.compile(pattern).search(self.shown, self._seen)) is None:
            left_s = end_s - time.monotonic()
            if left_s <= 0 or not self._read(min(left_s, 0.2)):
                raise AssertionError(f"{pattern!r} did not show up in:\n{self.shown[self._seen :][-2000:]}")
        self._seen = match.end()
        return match.group()

    def ask_until(self, line: str, pattern: str, within_s: float = 60.0) -> str:
        """Type a line again and again until a pattern shows up; returns what matched."""
        end_s = time.monotonic() + within_s
        while True:
            self.type(line)
            try:
                return self.expect(pattern, 1.0)
            except AssertionError:
                if time.monotonic() > end_s:
                    raise

    def _read(self, within_s: float) -> bool:
        """Take what is there; False when the program has gone."""
        if select.select([self._descriptor], [], [], within_s)[0]:
            try:
                self.shown += os.read(self._descriptor, 65_536).decode(errors="replace")
            except OSError:
                return False
        return True


@contextmanager
def on_terminal(command: Sequence[str], folder: Path) -> Iterator[Terminal]:
    """Run a program on a terminal, with a folder as its own and its home."""
    ours, theirs = pty.openpty()
    environment = {**os.environ, "HOME": str(folder), "TERM": "dumb"}
    process = subprocess.Popen(
        command, stdin=theirs, stdout=theirs, stderr=theirs, cwd=folder, env=environment, start_new_session=True
    )
    os.close(theirs)
    try:
        yield Terminal(ours)
    finally:
        # It may wait for its output to be read, which nobody does any more.
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        os.close(ours)
