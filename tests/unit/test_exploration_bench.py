"""Exploration in steps: the default planner sees all hills and keeps its height over the true ground."""

from __future__ import annotations

import numpy as np
import pytest

from missions.bench.exploration import Job, run_job
from missions.bench.exploration_run import TeamParams


@pytest.mark.parametrize("environment", range(2))
def test_the_default_planner_explores_hills_without_touching_them(environment: int) -> None:
    team = TeamParams()
    _, run = run_job(Job("tours", environment, 5, 8, team, None))
    assert run.finished
    assert run.steps < 150
    flown_m = np.linalg.norm(np.diff(run.positions_enu_m, axis=0), axis=2)
    assert flown_m.max() <= team.step_m + 1e-6
    assert run.lowest_m > team.min_above_m - 0.5
