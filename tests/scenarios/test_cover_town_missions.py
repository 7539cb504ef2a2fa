"""Teams that cover towns, in lock-step: as many faces in sight as an optimiser finds that knows the town."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from missions.lockstep import LockstepResult, simulate
from tests.fakes.town_missions import town_plan
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.ray_fan import down_looking_fan
from vehicle_agent.domain.voxel_faces import best_faces, count_faces, open_faces, seen_faces
from vehicle_agent.domain.voxel_paths import with_clearance

VEHICLES, RANGE_VOXELS, CEILING = 3, 10.0, 14


def fly(seed: int, tables: dict[str, dict[str, float]] | None = None, **task: Any) -> LockstepResult:
    cover = {"kind": "cover", "step_m": 30.0, "hold_s": 10.0, **task}
    result = simulate(town_plan(VEHICLES, seed=seed, task=cover, **(tables or {})))
    assert all(result.finished)
    assert not any(result.crashed)
    assert result.fence_breaches == 0
    assert result.min_separation_m > 1.5
    return result


def informed_optimum(solid: BoolArray, rng: np.random.Generator, starts: int = 2) -> float:
    """Share of the faces that a team sees whose places somebody chooses who knows the town."""
    fan, flyable = down_looking_fan(RANGE_VOXELS), with_clearance(~solid)
    flyable[:, :, CEILING + 1 :] = False
    spots, worth = np.argwhere(flyable), np.ones(solid.shape[:2], dtype=np.int64)
    best = 0
    for _ in range(starts):
        team = spots[rng.choice(len(spots), VEHICLES)]
        for _ in range(4):
            for index in range(VEHICLES):
                taken = seen_faces(solid, fan, np.delete(team, index, axis=0))
                around = np.abs(spots - team[index]).max(axis=1) <= 3
                tried = [team[index][None], rng.permutation(spots[around])[:24], spots[rng.choice(len(spots), 24)]]
                places = np.ascontiguousarray(np.concatenate(tried))
                chosen, _, _ = best_faces(solid, fan.steps, fan.firsts, places, worth, taken, np.zeros(len(places)))
                team[index] = places[chosen]
        best = max(best, count_faces(seen_faces(solid, fan, team)))
    return best / count_faces(open_faces(solid))


@pytest.mark.parametrize(("seed", "explore_first"), [(2, False), (5, True)])
def test_a_team_finds_places_nearly_as_good_as_an_informed_optimisers(seed: int, explore_first: bool) -> None:
    result = fly(seed, explore_first=explore_first)
    assert result.true_solid is not None
    assert result.covered_fraction >= 0.85 * informed_optimum(result.true_solid, np.random.default_rng(seed))
    assert result.summary()["covered_fraction"] == result.covered_fraction
    if explore_first:
        assert result.observed_fraction > 0.98
    left_s = [time_s for time_s, _, code, _ in result.events if code == "returning"]
    assert len(left_s) == VEHICLES
    assert max(left_s) - min(left_s) < 30.0
    for place in result.worked_at_enu_m.values():
        assert 0.5 < place[2] < 14.5


def test_a_team_covers_a_town_though_messages_are_lost_and_late() -> None:
    result = fly(5, {"radio": {"loss": 0.2, "delay_s": 0.3}})
    assert result.covered_fraction > 0.15


def test_faithful_cao_flies_between_houses_until_its_time_is_over() -> None:
    result = fly(2, {"stop": {"time_limit_s": 90.0}}, planner="cao", step_m=5.0)
    assert any("time limit" in text for _, _, code, text in result.events if code == "returning")
    assert result.covered_fraction > 0.1
