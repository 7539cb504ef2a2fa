"""Patches of a town: which voxel belongs where, what is left in each, and how far they are from each other to fly."""

from __future__ import annotations

import numpy as np
import pytest

from vehicle_agent.domain.voxels import FREE, OCCUPIED, UNKNOWN
from vehicle_agent.planning.voxel_patches import FrontierWork, VoxelPatches, ways_between
from vehicle_agent.planning.voxel_picture import VoxelPicture

SHAPE, CEILING = (40, 26, 20), 17


def walled() -> VoxelPicture:
    """Known air over ground, and a wall across it from south to north, 14 high."""
    states = np.full(SHAPE, FREE, dtype=np.uint8)
    states[:, :, 0] = OCCUPIED
    states[18:23, :, 1:15] = OCCUPIED
    return VoxelPicture.of(states, CEILING)


def test_patches_are_boxes_in_columns() -> None:
    division = VoxelPatches(SHAPE, 12, 9)
    assert division.counts == (4, 3, 3)
    voxels = np.array([(0, 0, 0), (11, 11, 8), (12, 0, 0), (0, 12, 9), (39, 25, 19)])
    assert division.patch_of(voxels).tolist() == [0, 0, 9, 4, 35]
    assert division.column_of(voxels).tolist() == [0, 0, 3, 1, 11]
    assert division.columns()[division.patch_of(voxels)].tolist() == division.column_of(voxels).tolist()
    middles = division.column_middles(5)
    assert division.column_of(middles).tolist() == list(range(12))
    assert (middles < SHAPE).all()


def test_known_voxels_are_summed_by_column_and_around_it() -> None:
    states = np.full(SHAPE, UNKNOWN, dtype=np.uint8)
    states[0:2, 0:3, :] = FREE
    division = VoxelPatches(SHAPE, 6, 9)
    known = division.known_per_column(VoxelPicture.of(states, CEILING))
    assert known[0] == known.sum() == 6 * (CEILING + 1)
    around = division.sums_around(known).reshape(division.counts[:2])
    assert (around[:3, :3] == known[0]).all()
    assert around.sum() == 9 * known[0]


def test_frontier_work_lies_where_the_frontier_is() -> None:
    states = np.full(SHAPE, FREE, dtype=np.uint8)
    states[:, :, 0] = OCCUPIED
    states[30:34, 14:18, 0] = UNKNOWN
    division = VoxelPatches(SHAPE, 12, 9)
    work = FrontierWork.of(VoxelPicture.of(states, CEILING), division)
    patch = int(division.patch_of(np.array([(31, 15, 0)]))[0])
    assert set(work.patches.tolist()) == {patch}
    assert len(work.voxels) == 16
    assert work.expected[patch] == pytest.approx(work.expected.sum()) == pytest.approx(16.0)
    assert np.abs(work.centres[patch] - (31.5, 15.5, 0)).max() <= 0.5


def test_ways_lead_over_walls() -> None:
    places = np.array([(6, 12, 4), (34, 12, 4), (6, 20, 4), (6, 12, 16)])
    ways = ways_between(walled(), places)
    straight = np.linalg.norm(places[:, None] - places[None], axis=2)
    assert np.array_equal(ways, ways.T)
    assert (ways >= straight).all()
    assert (np.diag(ways) == 0.0).all()
    assert ways[0, 1] > 1.15 * straight[0, 1]
    assert ways[0, 2] < 1.3 * straight[0, 2]
    assert ways[0, 3] < 1.3 * straight[0, 3]


def test_places_that_no_air_is_known_of_are_reached_from_above() -> None:
    states = np.full(SHAPE, UNKNOWN, dtype=np.uint8)
    states[2:12, 2:12, 10:] = FREE
    places = np.array([(7, 7, 14), (30, 20, 2), (30, 20, 17), (7, 7, 2)])
    ways = ways_between(VoxelPicture.of(states, CEILING), places)
    assert np.isfinite(ways).all()
    assert ways[1, 2] == pytest.approx(15.0, abs=5.0)
    assert ways[0, 3] == pytest.approx(12.0, abs=5.0)
