"""A mapping mission with the real programs: soundings over MAVLink, packets over Zenoh, a depth map as in lock-step."""

from __future__ import annotations

import re
from pathlib import Path

import msgspec
import numpy as np
import pytest

import missions
from tests.fakes.flown_runs import fly
from tests.fakes.map_missions import map_mission
from vehicle_agent.mission.load import load_mission
from vehicle_agent.mission.model import RadioTable, StopTable

pytestmark = [pytest.mark.processes, pytest.mark.timeout(400)]


def test_flown_and_simulated_depth_maps_are_equally_good(tmp_path: Path, free_port_base: int) -> None:
    """Within 0.3 m of error, of about 3 m of relief, through an acoustic modem that loses much and is late."""
    simulation = msgspec.structs.replace(map_mission().simulation, speedup=8.0)
    mission = map_mission(
        radio=RadioTable(packet_bytes=200, packet_period_s=10.0, loss=0.3, delay_s=2.0),
        simulation=simulation,
        stop=StopTable(time_limit_s=200.0),
    )
    flown = fly(mission, tmp_path, free_port_base)
    simulated = missions.simulate(load_mission(flown.mission_file))
    drawn = simulated.depth_map
    assert drawn is not None
    assert drawn.rms_error_m is not None
    assert flown.summary.map_error_m is not None
    assert flown.summary.map_error_m == pytest.approx(drawn.rms_error_m, abs=0.3)
    assert flown.summary.observed_fraction == pytest.approx(simulated.observed_fraction, abs=0.15)
    with np.load(flown.folder / "depth_map.npz") as arrays:
        assert np.isfinite(arrays["elevation_amsl_m"]).all()
        assert (arrays["sd_m"] > 0).all()
    for name in ("alba", "brisa"):
        log = (flown.folder / name / "agent.log").read_text()
        assert re.search(r"radio: \d+ messages of teammates lost as the mission states, [1-9]\d* heard", log)
    assert "coverage=" in flown.output
    assert "depth map" in flown.output
