"""A mission flown by the real programs, from its start to its summary."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import msgspec

from missions.flown import to_toml
from missions.summary import Summary
from vehicle_agent.mission.model import Mission

REPOSITORY = Path(__file__).parents[2]


@dataclass(frozen=True, slots=True)
class FlownRun:
    """What `missions run` left behind.

    Attributes
    ----------
    mission_file
        The mission as it was given.
    folder
        The run's own.
    summary
        Of the run.
    output
        What the program printed.
    """

    mission_file: Path
    folder: Path
    summary: Summary
    output: str


def write_mission(mission: Mission, folder: Path) -> Path:
    """Write a mission file named after the mission."""
    path = folder / f"{mission.name}.toml"
    path.write_text(to_toml(msgspec.to_builtins(mission)))
    return path


def run_command(mission_file: Path, runs_dir: Path, port_base: int) -> list[str]:
    """The command line of `missions run`."""
    return [sys.executable, "-m", "missions.cli", "run", str(mission_file), "--port-base", str(port_base),
            "--runs-dir", str(runs_dir)]  # fmt: skip


def fly(mission: Mission, folder: Path, port_base: int, timeout_s: float = 300.0) -> FlownRun:
    """Run a mission to its end; fails when its program does."""
    mission_file, runs_dir = write_mission(mission, folder), folder / "runs"
    run = subprocess.run(
        [*run_command(mission_file, runs_dir, port_base), "--plain"],
        cwd=REPOSITORY, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=timeout_s, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout + run.stderr
    (summary_file,) = runs_dir.glob("*/summary.json")
    summary = msgspec.json.decode(summary_file.read_bytes(), type=Summary)
    return FlownRun(mission_file, summary_file.parent, summary, run.stdout)
