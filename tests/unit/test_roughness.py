"""Where ground is rough, told by how far soundings lie from what others predict and by how much their map bends."""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.relief import Relief
from vehicle_agent.planning.mapping.roughness import bends_of, roughness_at_nodes


def test_a_slope_bends_nowhere() -> None:
    east, north = np.meshgrid(np.arange(30.0), np.arange(20.0), indexing="ij")
    assert np.array_equal(bends_of(np.zeros((30, 20)), (2.0, 3.0)), np.ones((30, 20)))
    hill = np.where(east > 15.0, np.sin(0.8 * east) * np.cos(north), 0.0)
    assert np.allclose(bends_of(hill + 3.0 * east - 2.0 * north, (2.0, 3.0)), bends_of(hill, (2.0, 3.0)))


def test_ground_bends_most_where_its_waves_are() -> None:
    east, north = np.meshgrid(np.arange(0.0, 60.0, 1.5), np.arange(0.0, 60.0, 2.0), indexing="ij")
    waves = np.where(north > 30.0, np.sin(0.4 * east) + np.sin(0.35 * north), 0.0)
    bends = bends_of(waves, (1.5, 2.0))
    assert bends.shape == waves.shape
    assert bends[:, 24:].min() > 3.0 * bends[:, :6].max()
    assert np.allclose(bends_of(5.0 * waves, (1.5, 2.0)), bends)


def test_small_grids_bend_too() -> None:
    assert np.isfinite(bends_of(np.array([[0.0, 1.0], [2.0, -1.0]]), (2.5, 2.5))).all()


def test_roughness_tells_the_rough_half_from_a_few_lines() -> None:
    axis = np.arange(1.25, 60.0, 2.5)
    nodes = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
    rng = np.random.default_rng(2)
    lines = np.stack(np.meshgrid([10.0, 30.0, 50.0], np.arange(1.0, 60.0, 2.0), indexing="ij"), axis=-1).reshape(-1, 2)
    heights = -10.0 + np.where(lines[:, 1] > 30.0, 1.5, 0.05) * rng.standard_normal(len(lines))
    relief = Relief(lines, heights, np.full(len(lines), 0.03))
    rough = roughness_at_nodes(relief, nodes, (len(axis), len(axis)), (2.5, 2.5))
    assert rough.shape == (len(nodes),)
    there, elsewhere = rough[nodes[:, 1] > 36.0], rough[nodes[:, 1] < 22.0]
    assert there.min() > elsewhere.max()
    assert np.median(there) > 3.0 * np.median(elsewhere)
