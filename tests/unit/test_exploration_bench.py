"""Exploration in steps: planners that share the ground out see all hills and keep their height over the true ground."""

from __future__ import annotations

import numpy as np
import pytest

from missions.bench.exploration import Job, run_job
from missions.bench.exploration_run import TeamParams
from vehicle_agent.mission.tasks import PlannerName


@pytest.mark.parametrize(("planner", "environment"), [("tours", 0), ("tours", 1), ("lanes", 0)])
def test_hills_are_explored_without_touching_them(planner: PlannerName, environment: int) -> None:
    team = TeamParams()
    _, run = run_job(Job(planner, environment, 5, 8, team, None))
    assert run.finished
    assert run.steps < 150
    flown_m = np.linalg.norm(np.diff(run.positions_enu_m, axis=0), axis=2)
    assert flown_m.max() <= team.step_m + 1e-6
    assert run.lowest_m > team.min_above_m - 0.5
