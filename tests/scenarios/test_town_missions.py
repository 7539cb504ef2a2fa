"""Teams in small towns, in lock-step: everything observable is observed, nobody touches anything, all come home."""

from __future__ import annotations

import numpy as np
import pytest

from missions.lockstep import LockstepResult, simulate
from tests.fakes.town_missions import town_plan
from vehicle_agent.domain.voxels import VoxelMap
from vehicle_agent.mission.load import MissionPlan


def flown(plan: MissionPlan) -> LockstepResult:
    result = simulate(plan)
    assert all(result.finished)
    assert not any(result.crashed)
    assert result.fence_breaches == 0
    return result


@pytest.mark.parametrize("seed", [2, 5])
def test_a_team_sees_the_town_and_comes_home(seed: int) -> None:
    plan = town_plan(seed=seed)
    result = flown(plan)
    assert result.observed_fraction > 0.995
    assert result.min_separation_m > 1.5
    assert result.reachable.shape == result.team_map.observed.shape
    assert result.observed_fraction_curve[-1] == pytest.approx(result.observed_fraction, abs=0.01)
    reasons = [text for _, _, code, text in result.events if code == "returning"]
    assert len(reasons) == 2
    assert any("everything observable" in reason or "100.0 %" in reason for reason in reasons)
    highest_m = result.positions_enu_m[:, :, 2].max()
    assert highest_m < 14.5
    assert max(result.bytes_sent) < 1_500 * result.elapsed_s


def test_the_same_seed_flies_the_same_way_and_its_files_hold_the_map(tmp_path) -> None:  # type: ignore[no-untyped-def]
    plan = town_plan(vehicles=1, stop={"time_limit_s": 30.0})
    first, second = flown(plan), flown(plan)
    assert np.array_equal(first.positions_enu_m, second.positions_enu_m)
    first.save(tmp_path)
    with np.load(tmp_path / "run.npz") as arrays:
        assert plan.voxel_grid is not None
        kept = VoxelMap.of_arrays(plan.voxel_grid, arrays)
    assert kept == first.team_map
    assert first.observed_fraction == second.observed_fraction < 1.0


def test_messages_that_are_lost_and_late_cost_time_but_no_surface_and_no_room() -> None:
    plan = town_plan(seed=7, radio={"loss": 0.3, "delay_s": 3.0})
    result = flown(plan)
    assert result.observed_fraction > 0.995
    assert result.min_separation_m >= plan.mission.safety.separation_m
