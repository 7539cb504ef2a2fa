"""Whole missions in lock-step: they reach their aim, keep their distances and end with everybody down."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

import missions
from missions.lockstep import LockstepResult
from tests.fakes.hill_missions import hill_plan
from vehicle_agent.mission.tasks import PlannerName

MIN_SEPARATION_M = 5.0
THIN_RADIO = {"loss": 0.3, "delay_s": 0.1, "range_m": 250.0, "rate_bytes_s": 4_000.0}


def assert_safe(result: LockstepResult) -> None:
    assert result.fence_breaches == 0
    assert result.min_separation_m >= MIN_SEPARATION_M
    assert not any(result.crashed)
    assert all(result.finished)
    assert result.messages_dropped == [0] * len(result.finished)


@pytest.mark.parametrize("radio", [{}, THIN_RADIO], ids=["clear", "thin"])
@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_a_team_sees_its_area_and_comes_home(seed: int, radio: dict[str, float]) -> None:
    result = missions.simulate(hill_plan(seed, radio=radio))
    assert_safe(result)
    assert result.observed_fraction >= 0.99
    assert all(np.diff(result.observed_fraction_curve) >= 0.0)
    assert result.observed_fraction_curve[-1] <= result.observed_fraction
    homes = np.array([v.start_enu_m[:2] for v in result.plan.mission.vehicles])
    assert np.linalg.norm(result.positions_enu_m[-1, :, :2] - homes, axis=1).max() < 5.0
    worst = max(vehicle["bytes_per_s"] for vehicle in result.summary()["vehicles"].values())
    assert worst < 2_000.0


@pytest.mark.parametrize("planner", get_args(PlannerName))
def test_every_planner_ends_safely(planner: str) -> None:
    limited = {"observed_fraction": 0.99, "time_limit_s": 240.0}
    result = missions.simulate(hill_plan(5, planner=planner, stop=limited, radio=THIN_RADIO))
    assert_safe(result)
    assert result.observed_fraction > 0.5
    assert result.plan.mission.task.planner == planner


def test_every_agent_knows_what_the_team_has_seen() -> None:
    """On a radio without loss every map is nearly the team's: deltas are at most a period behind."""
    result = missions.simulate(hill_plan(2))
    told = [text for _, _, code, text in result.events if code == "returning"]
    assert len(told) == 3
    shares = [result.team_map.first_observer_share(index) for index in range(3)]
    assert min(shares) > 0.0
    assert sum(shares) == pytest.approx(int(result.team_map.observed.sum()))


def test_the_map_is_true() -> None:
    result = missions.simulate(hill_plan(3))
    seen = result.team_map.observed
    error_m = np.abs(result.team_map.elevation_m - result.true_elevation_m)[seen]
    assert error_m.max() <= 0.05 + 1e-9


def test_starts_beside_the_fence_and_a_slanted_area_are_left_and_found_again() -> None:
    """Homes where no cell beside is allowed: take-off and return work without a map of that place."""
    slanted = {
        "cell_m": 20.0,
        "polygon_enu_m": [[0.0, 0.0], [600.0, 80.0], [520.0, 600.0], [60.0, 420.0]],
        "fence_margin_m": 4.0,
    }
    team = [
        {
            "name": name,
            "start_enu_m": start,
            "speed_m_s": 12.0,
            "sensor": {"kind": "range", "range_m": 120.0},
            "min_above_terrain_m": 30.0,
            "max_above_terrain_m": 90.0,
        }
        for name, start in (("ada", [9.0, 8.0]), ("bob", [300.0, 45.0]))
    ]
    result = missions.simulate(hill_plan(1, area=slanted, team=team))
    assert_safe(result)
    assert result.observed_fraction >= 0.95


def test_a_lone_vehicle_does_it_alone() -> None:
    result = missions.simulate(hill_plan(1, vehicles=1, stop={"observed_fraction": 0.99, "time_limit_s": 1_500.0}))
    assert all(result.finished)
    assert result.observed_fraction >= 0.99
    assert result.summary()["min_separation_m"] is None


def test_crossing_vehicles_in_a_narrow_area_keep_their_distance() -> None:
    """Teams from both ends of a corridor have to pass each other on their way home."""
    corridor = {"cell_m": 10.0, "rectangle_enu_m": [0.0, 0.0, 900.0, 120.0], "fence_margin_m": 5.0}
    team = [
        {
            "name": f"copter-{number}",
            "start_enu_m": [start, 60.0],
            "speed_m_s": 15.0,
            "sensor": {"kind": "range", "range_m": 80.0},
            "min_above_terrain_m": 20.0,
            "max_above_terrain_m": 60.0,
        }
        for number, start in enumerate((40.0, 80.0, 820.0, 860.0))
    ]
    for seed in (1, 2):
        result = missions.simulate(
            hill_plan(seed, area=corridor, team=team, terrain={"kind": "flat"}, radio=THIN_RADIO)
        )
        assert_safe(result)


@pytest.fixture(scope="module")
def ridge() -> LockstepResult:
    return missions.simulate(missions.load_mission("ridge"))


def test_ridge_reaches_its_bar(ridge: LockstepResult) -> None:
    assert_safe(ridge)
    assert ridge.observed_fraction >= 0.99
    assert ridge.elapsed_s < ridge.plan.mission.stop.time_limit_s
    assert max(v["bytes_per_s"] for v in ridge.summary()["vehicles"].values()) <= 2_000.0


def test_ridge_keeps_clear_of_the_ground(ridge: LockstepResult) -> None:
    grid = ridge.plan.grid
    flying = ridge.positions_enu_m.reshape(-1, 3)
    cells = np.array([grid.cell_of(east, north) for east, north, _ in flying])
    height_m = flying[:, 2] - ridge.true_elevation_m[cells[:, 0], cells[:, 1]]
    homes = np.array([v.start_enu_m[:2] for v in ridge.plan.mission.vehicles])
    away = np.linalg.norm(flying[:, None, :2] - homes[None], axis=2).min(axis=1) > 60.0
    assert height_m[away].min() > 0.5 * ridge.plan.mission.vehicles[0].min_above_terrain_m


def test_an_area_that_nobody_can_see_whole_ends_with_all_that_can_be_seen_and_a_word_about_the_rest() -> None:
    team = [
        {
            "name": f"copter-{number}",
            "start_enu_m": [120.0 + 40.0 * number, 120.0],
            "speed_m_s": 12.0,
            "sensor": {"kind": "range", "range_m": 80.0},
            "min_above_terrain_m": 30.0,
            "max_above_terrain_m": 60.0,
        }
        for number in range(2)
    ]
    result = missions.simulate(
        hill_plan(
            team=team,
            area={"cell_m": 10.0, "rectangle_enu_m": [0.0, 0.0, 300.0, 300.0], "fence_margin_m": 70.0},
            terrain={"kind": "flat"},
            stop={"observed_fraction": 1.0, "time_limit_s": 600.0},
        )
    )
    assert all(result.finished)
    hidden = result.plan.area_cells & ~result.reachable
    assert hidden.any()  # the corners lie beyond what can be seen from inside the fence's margin
    assert "cells of the area lie where this team cannot look" in result.not_seen
    reasons = [text for _, _, code, text in result.events if code == "returning"]
    assert reasons
    assert all("everything observable is observed" in reason and "cells stay unseen" in reason for reason in reasons)
    assert result.elapsed_s < 500.0


@pytest.mark.parametrize("delay_s", [0.0, 1.0, 3.0])
@pytest.mark.parametrize("seed", [1, 4, 7])
def test_late_and_lost_words_bring_nobody_nearer_than_the_separation(seed: int, delay_s: float) -> None:
    limited = {"observed_fraction": 0.99, "time_limit_s": 150.0}
    late = {"loss": 0.3, "delay_s": delay_s}
    result = missions.simulate(hill_plan(seed, planner="claims", stop=limited, radio=late))
    assert_safe(result)
    assert result.min_separation_m >= result.plan.mission.safety.separation_m
