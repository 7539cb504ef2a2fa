"""The voxel map: rays, evidence, bounds; and the ways and views that planning takes from it."""

from __future__ import annotations

import numpy as np
import pytest

from vehicle_agent.domain.ray_fan import down_looking_fan, rays_until
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.domain.voxel_paths import UNREACHED, trace_voxels, voxel_distances, with_clearance
from vehicle_agent.domain.voxels import FREE, OCCUPIED, UNKNOWN, VoxelMap

GRID = VoxelGrid(-10.0, -10.0, 0.0, 1.0, 20, 20, 10)


def sampled_voxels(sensor: np.ndarray, end: np.ndarray) -> set[tuple[int, int, int]]:
    """Voxels on a segment by brute force: those that many thousand points on it fall into."""
    points = sensor + np.linspace(0.0, 1.0, 20_001)[:, None] * (end - sensor)
    return {(int(u), int(v), int(w)) for u, v, w in np.floor(points - GRID.corner_enu_m)}


def test_a_ray_crosses_the_voxels_that_its_points_lie_in() -> None:
    rng = np.random.default_rng(1)
    for _ in range(60):
        sensor, end = rng.uniform((-9.9, -9.9, 0.1), (9.9, 9.9, 9.9), (2, 3))
        voxels = VoxelMap(GRID)
        voxels.insert(0, tuple(sensor), end[None], 35.0, 0)
        states = voxels.states()
        expected = sampled_voxels(sensor, end)
        last = GRID.voxel_of(tuple(end))
        crossed = {tuple(map(int, place)) for place in np.argwhere(states == FREE)}
        assert states[last] == OCCUPIED
        assert expected - {last} <= crossed
        # Corners that a ray cuts by less than a sample's distance may be crossed besides.
        assert len(crossed - expected) <= 2


def test_a_ray_longer_than_the_range_hits_nothing() -> None:
    voxels = VoxelMap(GRID)
    voxels.insert(0, (-9.5, 0.5, 5.5), np.array([[9.5, 0.5, 5.5]]), 5.0, 0)
    line = voxels.states()[:, 10, 5]
    assert line.tolist() == [FREE] * 5 + [UNKNOWN] * 15
    assert len(voxels.surface()[0]) == 0


def test_a_ray_without_return_frees_its_last_voxel() -> None:
    voxels = VoxelMap(GRID)
    ends = np.array([[-5.5, 0.5, 5.5]])
    voxels.insert(0, (-9.5, 0.5, 5.5), ends, 50.0, 0, np.zeros(1, dtype=np.bool_))
    assert voxels.states()[:6, 10, 5].tolist() == [FREE] * 5 + [UNKNOWN]


def test_a_hit_outweighs_rays_beside_it_in_one_scan_and_scans_outvote_it() -> None:
    voxels = VoxelMap(GRID)
    far, near = [5.5, 0.5, 5.5], [0.5, 0.5, 5.5]
    voxels.insert(0, (-9.5, 0.5, 5.5), np.array([far, near, far]), 50.0, 0)
    assert voxels.states()[10, 10, 5] == OCCUPIED
    for _ in range(3):
        voxels.insert(0, (-9.5, 0.5, 5.5), np.array([far]), 50.0, 1)
    assert voxels.states()[10, 10, 5] == FREE
    assert voxels.log_odds()[10, 10, 5] == pytest.approx(0.85 - 3 * 0.4)


def test_rays_beyond_the_grid_are_cut_at_it() -> None:
    voxels = VoxelMap(GRID)
    voxels.insert(0, (9.5, 9.5, 9.5), np.array([[30.0, 9.5, 9.5], [9.5, 9.5, 40.0], [9.5, 9.5, -30.0]]), 60.0, 0)
    assert (voxels.states() == FREE).sum() == 10
    voxels.insert(0, (100.0, 100.0, 100.0), np.array([[101.0, 100.0, 100.0]]), 60.0, 0)
    assert (voxels.states() == FREE).sum() == 10


def test_a_full_map_refuses_and_counts() -> None:
    voxels = VoxelMap(GRID, max_blocks=1)
    voxels.insert(0, (-9.5, -9.5, 0.5), np.array([[9.5, -9.5, 0.5]]), 60.0, 0)
    assert voxels.blocks == 1
    assert (voxels.states() != UNKNOWN).sum() == 8
    assert voxels.refused_voxels == 12


def test_wrong_scans_are_refused() -> None:
    voxels = VoxelMap(GRID)
    end = np.zeros((1, 3))
    with pytest.raises(ValueError, match="contributor 64"):
        voxels.insert(64, (0.0, 0.0, 0.0), end, 5.0, 0)
    with pytest.raises(ValueError, match="finite"):
        voxels.insert(0, (0.0, float("nan"), 0.0), end, 5.0, 0)
    for range_m in (0.0, -1.0, 1e6, float("nan")):
        with pytest.raises(ValueError, match="range"):
            voxels.insert(0, (0.0, 0.0, 0.0), end, range_m, 0)


def test_ways_keep_clear_of_what_is_not_free() -> None:
    free = np.ones((12, 12, 12), dtype=np.bool_)
    free[6, :, :] = False
    free[6, 3:6, 3:6] = True  # a window that leaves one clear voxel
    passable = with_clearance(free)
    start, goal = (2 * 12 + 4) * 12 + 4, (9 * 12 + 9) * 12 + 9
    _, parents = voxel_distances(passable, start, np.empty(0, dtype=np.bool_), 0)
    way = trace_voxels(parents, goal)
    assert way[0] == start
    assert way[-1] == goal
    assert passable.ravel()[way].all()
    assert (6 * 12 + 4) * 12 + 4 in way.tolist()
    free[6, 4, 4] = False
    closed, _ = voxel_distances(with_clearance(free), start, np.empty(0, dtype=np.bool_), 0)
    assert closed[goal] == UNREACHED


def test_the_fan_looks_down_and_level_and_stops_at_walls() -> None:
    fan = down_looking_fan(6.0)
    solid = np.zeros((15, 15, 15), dtype=np.bool_)
    solid[10, :, :] = True
    solid[:, :, 13] = True
    last, met, counts = rays_until(solid, fan.steps, fan.firsts, 7, 7, 8)
    hit = fan.steps[last[met & counts]] + np.array([7, 7, 8])
    assert set(hit[:, 0].tolist()) == {10}
    assert hit[:, 2].max() == 8
    assert counts.all()


def test_a_scan_of_the_fan_frees_only_air_and_hits_only_solid() -> None:
    rng = np.random.default_rng(5)
    solid = rng.random(GRID.shape) < 0.05
    solid[:, :, 0] = True
    fan = down_looking_fan(8.0)
    voxels = VoxelMap(GRID)
    for place in ((4, 4, 7), (15, 9, 8), (10, 16, 3)):
        solid[place] = False
    for place in ((4, 4, 7), (15, 9, 8), (10, 16, 3)):
        last, met, counts = rays_until(solid, fan.steps, fan.firsts, *place)
        centre = GRID.centre_of(place)
        voxels.insert(0, centre, fan.ends(np.array(centre), last, 1.0)[counts], 9.0, 0, met[counts])
    states = voxels.states()
    assert (states == OCCUPIED).sum() > 100
    assert not (solid & (states == FREE)).any()
    assert not (~solid & (states == OCCUPIED)).any()
