"""A coverage mission with the real programs ends with the coverage of the same mission in lock-step."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import msgspec
import pytest

import missions
from missions.summary import Summary
from vehicle_agent.mission.load import load_mission

pytestmark = [pytest.mark.processes, pytest.mark.timeout(400)]

REPOSITORY = Path(__file__).parents[2]
VEHICLE = """
[[vehicles]]
name = "{name}"
start_enu_m = {start}
speed_m_s = 12.0
sensor = {{ kind = "range", range_m = 110.0 }}
min_above_terrain_m = 30.0
max_above_terrain_m = 90.0
"""
MISSION = """
format = 1
name = "dale"
seed = 5
[datum]
latitude_deg = 47.0
longitude_deg = 8.0
[area]
cell_m = 10.0
rectangle_enu_m = [0.0, 0.0, 320.0, 320.0]
fence_margin_m = 5.0
[terrain]
kind = "gaussians"
peaks = 3
height_m = [10.0, 30.0]
sigma_m = 60.0
[task]
kind = "cover"
step_m = 40.0
hold_s = 15.0
[simulation]
speedup = 5.0
ready_after_s = 5.0
[stop]
time_limit_s = 600.0
""" + "".join(
    VEHICLE.format(name=name, start=start)
    for name, start in (
        ("ada", [60.0, 60.0]),
        ("bea", [100.0, 60.0]),
        ("cleo", [60.0, 100.0]),
        ("dora", [100.0, 100.0]),
    )
)


def test_flown_and_simulated_coverage_agree_within_two_percent(tmp_path: Path, free_port_base: int) -> None:
    mission = tmp_path / "dale.toml"
    mission.write_text(MISSION)
    run = subprocess.run(
        [sys.executable, "-m", "missions.cli", "run", str(mission), "--plain", "--port-base", str(free_port_base),
         "--runs-dir", str(tmp_path / "runs")],
        cwd=REPOSITORY, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=300.0, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout + run.stderr
    (summary_file,) = (tmp_path / "runs").glob("*/summary.json")
    flown = msgspec.json.decode(summary_file.read_bytes(), type=Summary).covered_fraction
    assert flown is not None
    simulated = missions.simulate(load_mission(mission)).covered_fraction
    assert flown == pytest.approx(simulated, abs=0.02)
    assert f"{100 * flown:.2f} % of the area at once" in run.stdout
