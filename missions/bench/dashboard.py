"""What the dashboard costs: bytes to the terminal, share of a core, answer to a key, memory over a long mission."""

from __future__ import annotations

import fcntl
import json
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
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from missions.bench.talking_fleet import talk_for_hours

KIB = 1_000.0
KEY_TIMEOUT_S = 2.0
STARTED = b"coverage"
KEYS = ((b"v", b"first", b"v"), (b"?", b"page", b"q"), (b"t", b"rouble", b"q"), (b"l", b"layers", b"q"))
"""A key, a word that it brings on the screen, and the key that takes it away again."""


@dataclass(frozen=True, slots=True)
class Case:
    """One terminal with one fleet, and what it may cost.

    Attributes
    ----------
    most_kb_s
        Thousand bytes per second to the terminal.
    most_core
        Share of a core, user and system time.
    """

    vehicles: int
    columns: int
    rows: int
    most_kb_s: float
    most_core: float


CASES = (Case(8, 80, 24, 20.0, 0.06), Case(50, 200, 50, 60.0, 0.25))
MOST_KEY_MS = 100.0
MOST_GROWTH = 0.05
"""Of resident memory from the second hour to the eighth."""


@dataclass(slots=True)
class Figures:
    """What was measured in one case."""

    vehicles: int
    columns: int
    rows: int
    seconds: float
    kb_per_s: float = 0.0
    core_share: float = 0.0
    key_p95_ms: float = 0.0
    key_max_ms: float = 0.0
    key_p95_unloaded_ms: float = 0.0
    """As `key_p95_ms`, without the time in which the dashboard waited for a core that others used."""
    key_p95_cpu_ms: float = 0.0
    keys: int = 0
    failed: list[str] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Answered:
    """One key's answer, seconds: on the wall, of processor time, and on the wall had a core been free."""

    wall_s: float
    cpu_s: float
    unloaded_s: float


NEVER = Answered(KEY_TIMEOUT_S, KEY_TIMEOUT_S, KEY_TIMEOUT_S)


class Screen:
    """The dashboard in a child process on a pseudo-terminal of its own."""

    def __init__(self, case: Case) -> None:
        self._parent, child = pty.openpty()
        size = struct.pack("HHHH", case.rows, case.columns, 0, 0)
        fcntl.ioctl(child, termios.TIOCSWINSZ, size)
        environment = {**os.environ, "TERM": "xterm-256color", "COLORTERM": "truecolor", "LANG": "C.UTF-8"}
        self._process = subprocess.Popen(
            [sys.executable, "-m", "missions.bench.talking_fleet", str(case.vehicles)],
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


def measure(case: Case, seconds: float, keys: int) -> Figures:
    """Let a dashboard run: first in peace, then with keys."""
    figures = Figures(case.vehicles, case.columns, case.rows, seconds)
    with Screen(case) as screen:
        screen.read_for(30.0, STARTED)
        screen.read_for(5.0)
        cpu_s, began_s = screen.cpu_s(), time.monotonic()
        drawn = screen.read_for(seconds)
        passed_s = time.monotonic() - began_s
        figures.kb_per_s = round(len(drawn) / KIB / passed_s, 2)
        figures.core_share = round((screen.cpu_s() - cpu_s) / passed_s, 4)
        answers = []
        for number in range(keys):
            key, awaited, back = KEYS[number % len(KEYS)]
            answers.append(screen.press(key, awaited) or NEVER)
            screen.read_for(0.2)
            screen.type(back)
            screen.read_for(0.4)
    figures.keys = len(answers)
    figures.key_p95_ms = _p95_ms([one.wall_s for one in answers])
    figures.key_p95_cpu_ms = _p95_ms([one.cpu_s for one in answers])
    figures.key_p95_unloaded_ms = _p95_ms([one.unloaded_s for one in answers])
    figures.key_max_ms = round(1e3 * max(one.wall_s for one in answers), 1)
    for name, value, bar in (
        ("kB/s to the terminal", figures.kb_per_s, case.most_kb_s),
        ("share of a core", figures.core_share, case.most_core),
        ("key p95, ms", figures.key_p95_ms, MOST_KEY_MS),
    ):
        if value > bar:
            figures.failed.append(f"{name}: {value:g} > {bar:g}")
    return figures


def _p95_ms(seconds: Sequence[float]) -> float:
    return round(1e3 * float(np.percentile(seconds, 95)), 1)


def bench(seconds: float, keys: int, hours: int) -> dict[str, object]:
    """All cases, and memory over a long mission; `failed` names the bars that were missed."""
    cases = [measure(case, seconds, keys) for case in CASES]
    failed = [f"{one.vehicles} vehicles: {text}" for one in cases for text in one.failed]
    sizes = talk_for_hours(50, hours) if hours else []
    growth = sizes[-1] / sizes[1] - 1.0 if len(sizes) > 2 else 0.0
    if growth > MOST_GROWTH:
        failed.append(f"memory grew by {100 * growth:.1f} % from the second hour on")
    return {
        "cases": [asdict(one) for one in cases],
        "cores": os.cpu_count(),
        "load_average": round(os.getloadavg()[0], 1),
        "memory_mb_by_hour": [round(size / 1e6, 1) for size in sizes],
        "memory_growth": round(growth, 4),
        "failed": failed,
    }


def table(result: dict[str, object]) -> str:
    """The figures as lines for people."""
    heads = "".join(f" {head:>9}" for head in ("terminal", "kB/s", "core", "key p95", "key max", "unloaded", "cpu"))
    lines = [f"{'vehicles':>8}{heads}"]
    cases = result["cases"]
    assert isinstance(cases, list)
    for one in cases:
        size = f"{one['columns']}x{one['rows']}"
        times = ("key_p95_ms", "key_max_ms", "key_p95_unloaded_ms", "key_p95_cpu_ms")
        lines.append(
            f"{one['vehicles']:>8} {size:>9} {one['kb_per_s']:>9.1f} {100 * one['core_share']:>8.1f}%"
            + "".join(f" {one[name]:>7.0f}ms" for name in times)
        )
    lines.append(f"memory by hour, MB: {result['memory_mb_by_hour']}")
    load = f"load average {result['load_average']} on {result['cores']} cores"
    lines.append(f"{load}: what others' load takes from the answers is left out of 'unloaded'")
    failed = result["failed"]
    assert isinstance(failed, list)
    return "\n".join([*lines, *(f"missed: {text}" for text in failed)])


def bench_dashboard(seconds: float, keys: int, hours: int, json_file: Path | None) -> int:
    """Measure, print, keep; 0 when every bar is held, else 1."""
    result = bench(seconds, keys, hours)
    print(table(result))
    if json_file is not None:
        json_file.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    return int(bool(result["failed"]))
