"""A mission in a town with the real programs sees what the same mission in lock-step sees, and touches nothing."""

from __future__ import annotations

from pathlib import Path

import pytest

import missions
from tests.fakes.flown_runs import fly
from tests.fakes.town_missions import town_mission
from vehicle_agent.mission.load import load_mission

pytestmark = [pytest.mark.processes, pytest.mark.timeout(600)]


def test_flown_and_simulated_towns_agree_within_two_percent(tmp_path: Path, free_port_base: int) -> None:
    mission = town_mission(simulation={"speedup": 4.0, "ready_after_s": 5.0})
    flown = fly(mission, tmp_path, free_port_base, timeout_s=500.0)
    simulated = missions.simulate(load_mission(flown.mission_file))
    assert flown.summary.truth_known
    assert flown.summary.observed_fraction == pytest.approx(simulated.observed_fraction, abs=0.02)
    assert flown.summary.crashes == 0
    assert not any(simulated.crashed)
    assert flown.summary.min_separation_m is not None
    assert flown.summary.min_separation_m > 1.0
