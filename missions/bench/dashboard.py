"""What the dashboard costs: bytes to the terminal, share of a core, answer to a key, memory over a long mission."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from missions.bench.pty_screen import NEVER, Screen
from missions.bench.talking_dashboard import talk_for_hours

KIB = 1_000.0
STARTED = b"coverage"
ROSTER_HEAD = b"vehicle     state"
KEYS = (
    (b"v", b"first", b"v", b"coverage"),
    (b"?", b"page", b"q", ROSTER_HEAD),
    (b"t", b"rouble", b"q", ROSTER_HEAD),
    (b"l", b"layers", b"q", ROSTER_HEAD),
)
"""A key, a word that it brings on the screen, the key that takes it away again, and what is drawn anew then."""


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


def measure(case: Case, seconds: float, keys: int) -> Figures:
    """Let a dashboard run: first in peace, then with keys."""
    figures = Figures(case.vehicles, case.columns, case.rows, seconds)
    arguments = [str(case.vehicles)]
    with Screen("missions.bench.talking_dashboard", arguments, case.columns, case.rows) as screen:
        screen.read_for(30.0, STARTED)
        screen.read_for(5.0)
        cpu_s, began_s = screen.cpu_s(), time.monotonic()
        drawn = screen.read_for(seconds)
        passed_s = time.monotonic() - began_s
        figures.kb_per_s = round(len(drawn) / KIB / passed_s, 2)
        figures.core_share = round((screen.cpu_s() - cpu_s) / passed_s, 4)
        answers = []
        for number in range(keys):
            key, awaited, back, beneath = KEYS[number % len(KEYS)]
            answers.append(screen.press(key, awaited) or NEVER)
            screen.read_for(0.2)
            screen.press(back, beneath)
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
