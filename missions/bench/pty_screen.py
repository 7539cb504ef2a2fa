"""A dashboard on a pseudo-terminal: what it draws, how soon it answers, and what it costs."""

from __future__ import annotations

import fcntl
import os
import pty
import select
import signal
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Sequence
from dataclasses import dataclass

from missions.supervisor import LAUNCHER

KEY_TIMEOUT_S = 2.0


@dataclass(frozen=True, slots=True)
class Answered:
    """One key's answer, seconds: on the wall, of processor time, and on the wall had a core been free."""

    wall_s: float
    cpu_s: float
    unloaded_s: float


NEVER = Answered(KEY_TIMEOUT_S, KEY_TIMEOUT_S, KEY_TIMEOUT_S)


class Screen:
    """A dashboard in a child process on a pseudo-terminal of its own.

    Parameters
    ----------
    module, arguments
        What Python runs.
    columns, rows
        Size of the terminal.
    """

    def __init__(self, module: str, arguments: Sequence[str], columns: int, rows: int) -> None:
        self._parent, child = pty.openpty()
        size = struct.pack("HHHH", rows, columns, 0, 0)
        fcntl.ioctl(child, termios.TIOCSWINSZ, size)
        environment = {**os.environ, "TERM": "xterm-256color", "COLORTERM": "truecolor", "LANG": "C.UTF-8"}
        launcher = (sys.executable, "-I", "-S", str(LAUNCHER), str(os.getpid()), str(int(signal.SIGKILL)))
        self._process = subprocess.Popen(
            [*launcher, sys.executable, "-m", module, *arguments],
            stdin=child, stdout=child, stderr=child, env=environment, start_new_session=True,
        )  # fmt: skip
        os.close(child)

    def __enter__(self) -> Screen:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.send_signal(signal.SIGTERM)
        try:
            self.read_for(5.0, until_end=True)
            self._process.wait(5.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
        os.close(self._parent)

    def read_for(self, seconds: float, awaited: bytes = b"", until_end: bool = False) -> bytes:
        """Bytes drawn within a time; earlier when `awaited` has come, or the program has ended."""
        end_s = time.monotonic() + seconds
        drawn = b""
        while (left_s := end_s - time.monotonic()) > 0:
            if not select.select([self._parent], [], [], left_s)[0]:
                break
            try:
                part = os.read(self._parent, 65_536)
            except OSError:  # the program has closed its terminal
                break
            drawn += part
            if (awaited and awaited in drawn) or (until_end and not part):
                break
        return drawn

    def type(self, key: bytes) -> None:
        os.write(self._parent, key)

    def press(self, key: bytes, awaited: bytes) -> Answered | None:
        """How long a key takes to the text that it brings; None when it does not come."""
        (cpu_s, queued_s), began_s = self._scheduled_s(), time.monotonic()
        self.type(key)
        drawn = self.read_for(KEY_TIMEOUT_S, awaited)
        passed_s = time.monotonic() - began_s
        cpu_after_s, queued_after_s = self._scheduled_s()
        if awaited not in drawn:
            return None
        return Answered(passed_s, cpu_after_s - cpu_s, max(0.0, passed_s - (queued_after_s - queued_s)))

    def _scheduled_s(self) -> tuple[float, float]:
        """Seconds in which the child's main thread has run, and in which it could have run but had no core."""
        with open(f"/proc/{self._process.pid}/schedstat") as file:
            ran_ns, queued_ns, _ = file.read().split()
        return int(ran_ns) / 1e9, int(queued_ns) / 1e9

    def cpu_s(self) -> float:
        """User and system time of the child so far."""
        with open(f"/proc/{self._process.pid}/stat") as file:
            fields = file.read().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
