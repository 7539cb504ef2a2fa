"""A team that covers a town with the real programs ends with the coverage of the same mission in lock-step."""

from __future__ import annotations

from pathlib import Path

import pytest

import missions
from tests.fakes.flown_runs import fly
from tests.fakes.town_missions import town_mission
from vehicle_agent.mission.load import load_mission

pytestmark = [pytest.mark.processes, pytest.mark.timeout(400)]


def test_flown_and_simulated_coverage_of_a_town_agree_within_two_percent(tmp_path: Path, free_port_base: int) -> None:
    mission = town_mission(
        area={"cell_m": 1.0, "rectangle_enu_m": [0.0, 0.0, 28.0, 28.0], "fence_margin_m": 1.0, "up_m": [-1.0, 17.0]},
        terrain={
            "kind": "town",
            "block_m": 14.0,
            "street_m": [6.0, 8.0],
            "height_m": [5.0, 8.0],
            "overhang_share": 1.0,
        },
        task={"kind": "cover", "step_m": 30.0, "hold_s": 3.0},
        simulation={"speedup": 8.0, "ready_after_s": 5.0},
    )
    flown = fly(mission, tmp_path, free_port_base)
    assert flown.summary.covered_fraction is not None
    simulated = missions.simulate(load_mission(flown.mission_file)).covered_fraction
    assert flown.summary.covered_fraction == pytest.approx(simulated, abs=0.02)
    assert flown.summary.crashes == 0
    assert flown.summary.min_separation_m is not None
    assert flown.summary.min_separation_m > 0.5 * mission.safety.separation_m
