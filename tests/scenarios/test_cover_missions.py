"""Coverage missions in lock-step: the team finds places, holds them, replaces who is lost, and comes home together."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import missions
from missions.bench.coverage_run import CoverageTeam
from missions.bench.informed import AscentParams, informed_optimum
from missions.lockstep import LockstepResult
from tests.fakes.hill_missions import copters, hill_plan
from vehicle_agent.behaviour.outfit import first_place

STOP = {"observed_fraction": 0.95, "time_limit_s": 900.0}
RADIO = {"loss": 0.1, "delay_s": 0.05}
TEAM = CoverageTeam(range_m=120.0, step_m=40.0, min_above_m=30.0, ceiling_m=400.0, separation_m=20.0)


def fly(seed: int, **task: Any) -> LockstepResult:
    cover = {"kind": "cover", "step_m": 40.0, "hold_s": 15.0, **task}
    return missions.simulate(hill_plan(seed, vehicles=4, task=cover, stop=STOP, radio=RADIO))


def assert_safe(result: LockstepResult) -> None:
    assert result.fence_breaches == 0
    assert result.min_separation_m >= 5.0
    assert not any(result.crashed)
    assert all(result.finished)


@pytest.mark.parametrize("seed", [5, 7])
def test_a_team_that_works_over_its_homes_comes_down_without_meeting(seed: int) -> None:
    homes = [(100.0 + 25.0 * (number % 3), 100.0 + 25.0 * (number // 3)) for number in range(5)]
    team = copters(homes, range_m=100.0, min_above_terrain_m=15.0, max_above_terrain_m=70.0)
    result = missions.simulate(
        hill_plan(
            seed,
            team=team,
            area={"cell_m": 10.0, "rectangle_enu_m": [0.0, 0.0, 250.0, 250.0], "fence_margin_m": 5.0},
            task={"kind": "cover", "step_m": 40.0, "hold_s": 5.0},
            stop={"observed_fraction": 0.95, "time_limit_s": 120.0},
            radio={"loss": 0.1, "delay_s": 0.1},
        )
    )
    assert_safe(result)
    assert result.min_separation_m >= 0.95 * result.plan.mission.safety.separation_m


@pytest.mark.parametrize("seed", [1, 2])
def test_a_team_finds_places_as_good_as_an_informed_optimisers_and_ends_together(seed: int) -> None:
    result = fly(seed)
    assert_safe(result)
    search = AscentParams(starts=4, kept=1, scales_m=(3.0, 8.0, 20.0, 40.0))
    best, _ = informed_optimum(result.plan.grid, result.true_elevation_m, TEAM, 4, np.random.default_rng(seed), search)
    assert result.covered_fraction >= 0.93 * best
    left_s = [time_s for time_s, _, code, _ in result.events if code == "returning"]
    assert len(left_s) == 4
    assert max(left_s) - min(left_s) < 30.0
    assert result.summary()["covered_fraction"] == result.covered_fraction


def test_a_team_explores_first_and_then_covers_what_it_found() -> None:
    result = fly(3, explore_first=True)
    assert_safe(result)
    assert result.observed_fraction >= 0.95
    assert result.covered_fraction >= 0.3


def test_a_team_that_knows_a_few_points_spreads_before_it_covers() -> None:
    known = [[100.0, 120.0, 10.0], [480.0, 90.0, 20.0], [300.0, 320.0, 40.0], [120.0, 500.0, 15.0], [520.0, 480.0, 5.0]]
    result = fly(2, known_points_enu_m=known)
    assert_safe(result)
    assert result.covered_fraction >= 0.3
    for index in range(4):
        place = first_place(result.plan, index)
        assert place is not None
        assert np.linalg.norm(result.positions_enu_m[:, index, :2] - place[:2], axis=1).min() < 10.0


def test_faithful_cao_flies_until_its_time_is_over() -> None:
    cover = {"kind": "cover", "planner": "cao", "step_m": 20.0}
    stop = {"observed_fraction": 0.5, "time_limit_s": 120.0}
    result = missions.simulate(hill_plan(1, vehicles=3, task=cover, stop=stop))
    assert_safe(result)
    assert any("time limit" in text for _, _, code, text in result.events if code == "returning")
    assert result.covered_fraction > 0.1
