"""`missions run` with stand-ins for the fleet's programs: what every way of ending leads to; nobody is left behind."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import msgspec
import pytest

from missions.flown import Changes
from missions.summary import Summary
from tests.fakes.flown_runs import REPOSITORY, write_mission
from tests.fakes.hill_missions import copters, hill_mission
from tests.fakes.waiting import until

pytestmark = pytest.mark.processes

PROGRAM = REPOSITORY / "tests" / "fakes" / "stand_in_fleet.py"
DEADLINE_S = 60.0
MISSION = hill_mission(
    name="stand-in",
    team=copters([(50.0, 50.0), (90.0, 50.0)], ("one", "two")),
    area={"cell_m": 20.0, "rectangle_enu_m": [0.0, 0.0, 400.0, 400.0]},
    terrain={"kind": "flat"},
)


class Run:
    """One run in its own process."""

    def __init__(self, folder: Path, mission: Path, faults: dict[str, str]) -> None:
        self.runs_dir = folder / "runs"
        environment = {**os.environ, "PYTHONPATH": str(REPOSITORY)}
        environment |= {f"STAND_IN_{name.upper().replace('-', '_')}": fault for name, fault in faults.items()}
        self.process = subprocess.Popen(
            [sys.executable, str(PROGRAM), "run", str(mission), str(self.runs_dir)],
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def wait(self) -> tuple[int, str, str]:
        out, err = self.process.communicate(timeout=DEADLINE_S)
        return (self.process.returncode, out, err)

    def let_land(self) -> None:
        """End the flight of those that wait."""
        (self.folder() / "land").touch()

    def folder(self) -> Path:
        until(lambda: len(list(self.runs_dir.glob("*"))) == 1)
        return next(self.runs_dir.glob("*"))

    def summary(self) -> Summary:
        return msgspec.json.decode((self.folder() / "summary.json").read_bytes(), type=Summary)

    def fleet_pids(self) -> list[int]:
        """Processes that were given this run's folder."""
        pids = []
        for entry in Path("/proc").glob("[0-9]*/cmdline"):
            try:
                words = entry.read_bytes().split(b"\0")
            except OSError:
                continue
            if (
                any(str(self.runs_dir).encode() in word for word in words)
                and int(entry.parent.name) != self.process.pid
            ):
                pids.append(int(entry.parent.name))
        return pids

    def until_flying(self) -> None:
        """Wait for the first words of every agent."""
        path = self.folder() / "status.jsonl"

        def all_speak() -> bool:
            if not path.exists():
                return False
            lines = path.read_text().splitlines()
            return {json.loads(line)["sender"] for line in lines if line.endswith("}")} == {"one", "two"}

        until(all_speak)


@pytest.fixture
def fly(tmp_path: Path, free_port_base: int) -> Iterator[Callable[..., Run]]:
    mission = write_mission(Changes(port_base=free_port_base).apply(MISSION), tmp_path)
    runs: list[Run] = []

    def start(**faults: str) -> Run:
        runs.append(Run(tmp_path, mission, {name.replace("_", "-"): fault for name, fault in faults.items()}))
        return runs[-1]

    yield start
    for run in runs:
        run.process.kill()
        run.process.wait()
        until(lambda run=run: not run.fleet_pids())  # whatever happened, nobody is left behind


def test_a_whole_run_ends_by_itself_with_a_summary_and_exit_code_0(fly):
    run = fly()
    code, out, err = run.wait()
    assert (code, err) == (0, "")
    assert out.startswith("line log\nstand-in: reached its aim\n")
    summary = run.summary()
    assert summary.verdict is None
    assert summary.observed_fraction == 1.0
    assert summary.min_separation_m == 40.0
    assert [vehicle.home_and_disarmed for vehicle in summary.vehicles] == [True, True]
    assert [vehicle.first_seen_share for vehicle in summary.vehicles] == [0.5, 0.5]
    assert summary.peak_memory_bytes > 0
    assert (run.folder() / "mission.toml").exists()
    report = subprocess.run(
        [sys.executable, "-m", "missions.cli", "report", str(run.folder())],
        cwd=REPOSITORY, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert out.endswith(report.stdout)


def test_a_lost_agent_is_told_and_the_mission_goes_on(fly):
    run = fly(two="die")
    code, out, err = run.wait()
    assert code == 0
    assert "agent two was killed by SIGKILL" in err
    assert "agent two was killed by SIGKILL" in out
    assert [vehicle.agent_lost for vehicle in run.summary().vehicles] == [False, True]


def test_without_its_simulator_the_mission_is_over(fly):
    code, out, _ = fly(sim_bridge="die").wait()
    assert code == 1
    assert "did not reach its aim: sim-bridge was killed by SIGKILL" in out


@pytest.mark.parametrize("name", ["sim-bridge", "two"])
def test_what_a_program_says_when_it_refuses_to_start_is_the_answer(fly, name):
    run = fly(**{name: "refuse"})
    code, out, err = run.wait()
    assert code == 2
    assert f"{name}: cannot do it; do something else" in err
    assert "Traceback" not in err
    assert out == "line log\n"


def test_a_program_that_never_gets_ready_is_named(fly):
    code, _, err = fly(sim_bridge="mute").wait()
    assert code == 2
    assert "sim-bridge was not ready within 5 s" in err


def test_the_line_log_is_started_anew_and_the_mission_does_not_need_it(fly):
    run = fly(one="wait")
    run.until_flying()
    assert run.process.stdout.readline() == "line log\n"
    (pid,) = [pid for pid in run.fleet_pids() if b"line-log" in Path(f"/proc/{pid}/cmdline").read_bytes()]
    os.kill(pid, signal.SIGKILL)
    assert run.process.stdout.readline() == "line log\n"
    run.let_land()
    code, out, err = run.wait()
    assert code == 0
    assert out.startswith("stand-in: reached its aim\n")
    assert "started anew" in err


@pytest.mark.parametrize(("what", "exit_code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_stopped_run_keeps_what_was_done(fly, what, exit_code):
    run = fly(one="hover")
    run.until_flying()
    run.process.send_signal(what)
    code, out, err = run.wait()
    assert (code, err) == (exit_code, "")
    assert "did not reach its aim: stopped by" in out
    assert run.summary().observed_fraction == 1.0  # the agents were given the time to write their maps
    assert run.summary().ending == "stopped"


def test_nobody_outlives_a_killed_run(fly):
    run = fly(one="hover")
    run.until_flying()
    assert len(run.fleet_pids()) == 4
    run.process.kill()
    run.process.wait()
    until(lambda: not run.fleet_pids())
