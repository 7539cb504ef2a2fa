"""Teams in small towns: everything observable is observed, through air, apart from each other, the same every time."""

from __future__ import annotations

import numpy as np
import pytest

from missions.bench.urban import Case, Outcome, row, table
from missions.bench.urban_run import UrbanExploration, UrbanParams, UrbanRun
from sim_bridge.observable import observable_of
from sim_bridge.town import draw_town
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.ray_fan import down_looking_fan, rays_until
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.mission.terrain import TownTerrain

GRID = VoxelGrid(0.0, 0.0, -1.0, 1.0, 44, 44, 17)
TOWN = TownTerrain(block_m=22.0, street_m=(7.0, 9.0), height_m=(7.0, 11.0), overhang_share=1.0, passage_share=1.0)
PARAMS = UrbanParams(range_m=10.0, ceiling_m=13.5, limit_s=600)
CEILING = 14


def town(seed: int) -> BoolArray:
    return draw_town(GRID, TOWN, np.random.default_rng(seed))


def explore(solid: BoolArray, vehicles: int) -> UrbanRun:
    fan = down_looking_fan(PARAMS.range_m)
    starts = [(4 + 4 * place, 4, CEILING) for place in range(vehicles)]
    truth = observable_of(solid, CEILING, starts[0], fan)
    return UrbanExploration(GRID, solid, truth, starts, fan, PARAMS).run()


@pytest.mark.parametrize("seed", [1, 2])
def test_a_team_sees_all_that_can_be_seen(seed: int) -> None:
    solid = town(seed)
    run = explore(solid, 2)
    assert run.finished_s is not None
    assert run.observed_share[-1] == 1.0
    assert run.observed_share == sorted(run.observed_share)
    assert run.closest_m >= PARAMS.separation_m
    voxels = np.floor(run.positions_enu_m - GRID.corner_enu_m).astype(int).reshape(-1, 3)
    for voxel in voxels:
        around = tuple(slice(place - 1, place + 2) for place in voxel)
        assert not solid[around].any()
    ways_m = np.linalg.norm(np.diff(run.positions_enu_m, axis=0), axis=2)
    assert ways_m.max() <= PARAMS.speed_m_s + np.sqrt(3.0)


def test_the_same_town_is_explored_the_same_way() -> None:
    first, second = explore(town(3), 2), explore(town(3), 2)
    assert np.array_equal(first.positions_enu_m, second.positions_enu_m)
    assert np.array_equal(town(3), town(3))
    assert not np.array_equal(town(3), town(4))


def test_observable_is_what_scans_from_everywhere_see() -> None:
    grid = VoxelGrid(0.0, 0.0, 0.0, 1.0, 16, 16, 10)
    solid = np.zeros(grid.shape, dtype=np.bool_)
    solid[:, :, 0] = True
    solid[6:9, 5:10, 1:5] = True
    solid[9:12, 5:10, 4] = True  # an overhang; what is above it hides part of the ground
    fan = down_looking_fan(6.0)
    truth = observable_of(solid, 7, (2, 2, 7), fan)
    seen = np.zeros(grid.shape, dtype=np.bool_)
    for place in np.argwhere(truth.reachable):
        last, met, counts = rays_until(solid, fan.steps, fan.firsts, *(int(index) for index in place))
        seen[tuple((fan.steps[last[met & counts]] + place).T)] = True
    assert np.array_equal(seen, truth.surface)
    assert not truth.surface[6:9, 5:10, 1:4][1, 1:4].any()  # inside the house


def outcome(vehicles: int, end_s: int, idle_s: int) -> Outcome:
    shares = [0.0] * (end_s - 20) + [0.995] * 20 + [1.0]
    return Outcome(Case(1, 0, vehicles), UrbanRun(shares, np.zeros((1, 1, 3)), end_s, 3.0, 0, idle_s, 3), 10)


def test_the_table_tells_where_a_team_s_time_went() -> None:
    fewer, more = outcome(2, 200, 0), outcome(4, 125, 50)
    assert row(more)["seen_99_s"] == 105
    assert row(more)["idle_share"] == pytest.approx(0.1)
    told = table([fewer, more], (2, 4))
    assert "without a goal 10.0 % of their time, held up 0.6 %; 99 % seen after 105.0 s, the rest took 20.0 s" in told
    assert "4 need 37.5 % less time than 2: parallel efficiency 80.0 %, with 100 % it would be 50.0 % less" in told
