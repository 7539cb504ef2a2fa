"""Memory of processes as Linux counts it: proportional set size, so that shared pages count once over all."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


def proportional_set_bytes(pids: Iterable[int]) -> int:
    """Sum of the proportional set sizes (Pss of /proc/<pid>/smaps_rollup) of processes; those gone count as zero."""
    return sum(_one(pid) for pid in pids)


def _one(pid: int) -> int:
    try:
        text = Path(f"/proc/{pid}/smaps_rollup").read_text(encoding="ascii")
    except OSError:  # it has just ended, or the system is not Linux
        return 0
    for line in text.splitlines():
        if line.startswith("Pss:"):
            return int(line.split()[1]) * 1024
    return 0
