"""What every bench does with its cases: works through them with a progress bar, keeps what is done, writes JSON."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import click

from vehicle_agent.mission.load import MissionError

Case = TypeVar("Case")
Result = TypeVar("Result")
Row = dict[str, Any]


def work_through(cases: Sequence[Case], measure: Callable[[Case], Result], label: str) -> tuple[list[Result], bool]:
    """Measure one case after the other; Ctrl-C keeps those that are done.

    Returns
    -------
    The results so far, and whether it was interrupted.
    """
    results: list[Result] = []
    try:
        with click.progressbar(cases, label=label, file=sys.stderr) as bar:
            results.extend(measure(case) for case in bar)
    except KeyboardInterrupt:
        print(f"\nstopped after {len(results)} of {len(cases)}; what is done is kept", file=sys.stderr)
        return results, True
    return results, False


def save_rows(path: Path, bench: str, seed: int, rows: Sequence[Row]) -> None:
    """Write `{"bench", "seed", "rows"}`; MissionError when the file cannot be written."""
    try:
        path.write_text(json.dumps({"bench": bench, "seed": seed, "rows": list(rows)}, indent=1) + "\n")
    except OSError as error:
        raise MissionError(f"{path}: cannot be written ({error.strerror}); choose another file with --json") from None
