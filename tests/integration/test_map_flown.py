"""A mapping mission with the real programs: soundings over MAVLink, packets over Zenoh, a depth map as in lock-step."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest

import missions
from missions.summary import Summary
from vehicle_agent.mission.load import load_mission

pytestmark = [pytest.mark.processes, pytest.mark.timeout(400)]

REPOSITORY = Path(__file__).parents[2]
VEHICLE = """
[[vehicles]]
name = "{name}"
type = "underwater-vehicle"
start_enu_m = [{east}, 5.0]
speed_m_s = 1.5
climb_m_s = 0.5
depth_m = {depth}
sensor = {{ kind = "single-beam", range_m = 40.0, noise_fraction = 0.01, period_s = 1.0 }}
min_above_terrain_m = 1.0
max_above_terrain_m = 40.0
"""
MISSION = (
    """
format = 1
name = "pond"
seed = 3
[datum]
latitude_deg = 41.0
longitude_deg = -8.0
[area]
cell_m = 2.5
rectangle_enu_m = [0.0, 0.0, 40.0, 40.0]
fence_margin_m = 1.0
[terrain]
kind = "gaussians"
peaks = 4
height_m = [1.0, 3.0]
sigma_m = 7.0
[task]
kind = "map"
step_m = 20.0
accurate_sd_m = 0.2
[radio]
packet_bytes = 200
packet_period_s = 10.0
[safety]
separation_m = 1.0
teammate_silence_s = 90.0
[simulation]
speedup = 8.0
ready_after_s = 4.0
water_level_m = 12.0
gps_noise_m = 0.3
[stop]
time_limit_s = 200.0
"""
    + VEHICLE.format(name="alba", east=10.0, depth=2.0)
    + VEHICLE.format(name="brisa", east=30.0, depth=3.5)
)


def test_flown_and_simulated_depth_maps_are_equally_good(tmp_path: Path, free_port_base: int) -> None:
    """Within 0.3 m of error, of about 3 m of relief: times and so ways differ a little."""
    mission = tmp_path / "pond.toml"
    mission.write_text(MISSION)
    run = subprocess.run(
        [sys.executable, "-m", "missions.cli", "run", str(mission), "--plain", "--port-base", str(free_port_base),
         "--runs-dir", str(tmp_path / "runs")],
        cwd=REPOSITORY, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=300.0, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout + run.stderr
    (summary_file,) = (tmp_path / "runs").glob("*/summary.json")
    summary = msgspec.json.decode(summary_file.read_bytes(), type=Summary)
    simulated = missions.simulate(load_mission(mission))
    drawn = simulated.depth_map
    assert drawn is not None
    assert drawn.rms_error_m is not None
    assert summary.map_error_m is not None
    assert summary.map_error_m == pytest.approx(drawn.rms_error_m, abs=0.3)
    assert summary.observed_fraction == pytest.approx(simulated.observed_fraction, abs=0.15)
    with np.load(summary_file.parent / "depth_map.npz") as arrays:
        assert np.isfinite(arrays["elevation_amsl_m"]).all()
        assert (arrays["sd_m"] > 0).all()
    assert "coverage=" in run.stdout
    assert "depth map" in run.stdout
