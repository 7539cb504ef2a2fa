"""A coverage mission with the real programs ends with the coverage of the same mission in lock-step, nobody near."""

from __future__ import annotations

from pathlib import Path

import pytest

import missions
from tests.fakes.flown_runs import fly
from tests.fakes.hill_missions import copters, hill_mission
from vehicle_agent.mission.load import load_mission

pytestmark = [pytest.mark.processes, pytest.mark.timeout(400)]


def test_flown_and_simulated_coverage_agree_within_two_percent(tmp_path: Path, free_port_base: int) -> None:
    mission = hill_mission(
        seed=5,
        team=copters([(60.0, 60.0), (100.0, 60.0), (60.0, 100.0), (100.0, 100.0)], range_m=110.0),
        area={"cell_m": 10.0, "rectangle_enu_m": [0.0, 0.0, 320.0, 320.0], "fence_margin_m": 5.0},
        terrain={"kind": "gaussians", "peaks": 3, "height_m": [10.0, 30.0], "sigma_m": 60.0},
        task={"kind": "cover", "step_m": 40.0, "hold_s": 15.0},
        simulation={"speedup": 5.0, "ready_after_s": 5.0},
        stop={"time_limit_s": 600.0},
    )
    flown = fly(mission, tmp_path, free_port_base)
    assert flown.summary.covered_fraction is not None
    simulated = missions.simulate(load_mission(flown.mission_file)).covered_fraction
    assert flown.summary.covered_fraction == pytest.approx(simulated, abs=0.02)
    assert f"{100 * flown.summary.covered_fraction:.2f} % of the area at once" in flown.output
    assert flown.summary.min_separation_m is not None
    assert flown.summary.min_separation_m >= 0.5 * mission.safety.separation_m
