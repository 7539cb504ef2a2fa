"""A mission in a town with the real programs sees what the same mission in lock-step sees, and touches nothing."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import msgspec
import pytest

import missions
from missions.flown import to_toml
from missions.summary import Summary
from tests.fakes.town_missions import town_content
from vehicle_agent.mission.load import load_mission
from vehicle_agent.mission.model import Mission

pytestmark = [pytest.mark.processes, pytest.mark.timeout(600)]

REPOSITORY = Path(__file__).parents[2]


def test_flown_and_simulated_towns_agree_within_two_percent(tmp_path: Path, free_port_base: int) -> None:
    mission = tmp_path / "hamlet.toml"
    content = town_content(simulation={"speedup": 4.0, "ready_after_s": 5.0})
    mission.write_text(to_toml(msgspec.to_builtins(msgspec.convert(content, Mission))))
    run = subprocess.run(
        [sys.executable, "-m", "missions.cli", "run", str(mission), "--plain", "--port-base", str(free_port_base),
         "--runs-dir", str(tmp_path / "runs")],
        cwd=REPOSITORY, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=500.0, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout + run.stderr
    (summary_file,) = (tmp_path / "runs").glob("*/summary.json")
    flown = msgspec.json.decode(summary_file.read_bytes(), type=Summary)
    simulated = missions.simulate(load_mission(mission))
    assert flown.truth_known
    assert flown.observed_fraction == pytest.approx(simulated.observed_fraction, abs=0.02)
    assert flown.crashes == 0
    assert not any(simulated.crashed)
    assert flown.min_separation_m is not None
    assert flown.min_separation_m > 1.0
