"""Visible cells on random terrain against a reference that samples every ray densely."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.sensing import visible_surface

CELL_M = 10.0
SAMPLES = 400


@st.composite
def scenes(draw: st.DrawFn) -> tuple[Grid, np.ndarray, tuple[float, float, float], float]:
    columns, rows = draw(st.integers(2, 9)), draw(st.integers(2, 9))
    grid = Grid(draw(st.sampled_from([0.0, -35.0])), draw(st.sampled_from([0.0, 12.5])), CELL_M, columns, rows)
    seed = draw(st.integers(0, 2**16))
    elevation = np.random.default_rng(seed).uniform(0.0, draw(st.sampled_from([1.0, 20.0, 80.0])), grid.shape)
    u, v = draw(st.floats(-2.0, columns + 1.0)), draw(st.floats(-2.0, rows + 1.0))
    if draw(st.booleans()):
        u, v = round(2.0 * u) / 2.0, round(2.0 * v) / 2.0  # on centres and edges
    position = (grid.west_m + (u + 0.5) * CELL_M, grid.south_m + (v + 0.5) * CELL_M, draw(st.floats(-20.0, 120.0)))
    return grid, elevation, position, draw(st.floats(1.0, 150.0))


def ray_heights(elevation: np.ndarray, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest of the four cells around each point of a ray; beyond the grid the border goes on."""
    columns, rows = elevation.shape
    corners = [
        elevation[np.clip(around_u, 0, columns - 1), np.clip(around_v, 0, rows - 1)]
        for around_u in (np.floor(u).astype(int), np.ceil(u).astype(int))
        for around_v in (np.floor(v).astype(int), np.ceil(v).astype(int))
    ]
    return np.min(corners, axis=0), np.max(corners, axis=0)


@given(scenes())
@settings(max_examples=150, deadline=None)
def test_what_is_seen_lies_between_two_dense_references(
    scene: tuple[Grid, np.ndarray, tuple[float, float, float], float],
) -> None:
    """A ray above the highest cells around it all along must see; one below the lowest on a grid line must not."""
    grid, elevation, position, range_m = scene
    seen = np.zeros(grid.cells, dtype=bool)
    indices = visible_surface(grid, elevation, position, range_m)
    assert np.all(np.diff(indices) > 0)
    seen[indices] = True
    u0, v0 = (position[0] - grid.west_m) / CELL_M - 0.5, (position[1] - grid.south_m) / CELL_M - 0.5
    t = np.linspace(0.0, 1.0, SAMPLES + 1)
    for flat in range(grid.cells):
        column, row = divmod(flat, grid.rows)
        target = (*grid.centre_of(column, row), elevation[column, row])
        away_m = math.dist(target, position)
        if away_m > range_m + 1e-6:
            assert not seen[flat]
            continue
        if away_m > range_m - 1e-6:
            continue
        u, v = u0 + t * (column - u0), v0 + t * (row - v0)
        heights = position[2] + t * (target[2] - position[2])
        _, highest = ray_heights(elevation, u, v)
        beside_target = np.maximum(abs(u - column), abs(v - row)) < 1.0  # where the target itself stands highest
        if np.all((heights > highest) | beside_target):
            assert seen[flat]
        lines = crossings(u0, v0, column, row)
        inside = (lines[:, 0] >= 0) & (lines[:, 0] <= grid.columns - 1)
        inside &= (lines[:, 1] >= 0) & (lines[:, 1] <= grid.rows - 1)
        lines = lines[inside]
        at_lines = position[2] + lines[:, 2] * (target[2] - position[2])
        lowest, _ = ray_heights(elevation, lines[:, 0], lines[:, 1])
        if np.any(at_lines < lowest - 1e-6):
            assert not seen[flat]


def crossings(u0: float, v0: float, u1: float, v1: float) -> np.ndarray:
    """(N, 3): u, v and part of the way where a ray crosses grid lines on its longer axis, both ends left out."""
    along_u = abs(u1 - u0) >= abs(v1 - v0)
    start, end = (u0, u1) if along_u else (v0, v1)
    low, high = min(start, end), max(start, end)
    lines = np.arange(math.floor(low) + 1, math.ceil(high))
    if start == end or len(lines) == 0:
        return np.empty((0, 3))
    part = (lines - start) / (end - start)
    part = part[(part > 1e-9) & (part < 1.0 - 1e-9)]
    return np.column_stack((u0 + part * (u1 - u0), v0 + part * (v1 - v0), part))


@given(scenes(), st.floats(1.0, 1.5))
@settings(max_examples=60, deadline=None)
def test_a_longer_range_sees_no_less(
    scene: tuple[Grid, np.ndarray, tuple[float, float, float], float], factor: float
) -> None:
    grid, elevation, position, range_m = scene
    near = set(visible_surface(grid, elevation, position, range_m).tolist())
    assert near <= set(visible_surface(grid, elevation, position, factor * range_m).tolist())


@given(scenes())
@settings(max_examples=60, deadline=None)
def test_moving_terrain_and_viewer_together_changes_nothing(
    scene: tuple[Grid, np.ndarray, tuple[float, float, float], float],
) -> None:
    grid, elevation, position, range_m = scene
    moved = Grid(grid.west_m + 1024.0, grid.south_m - 2048.0, CELL_M, grid.columns, grid.rows)
    there = (position[0] + 1024.0, position[1] - 2048.0, position[2])
    here_seen = visible_surface(grid, elevation, position, range_m)
    there_seen = visible_surface(moved, elevation, there, range_m)
    assert len(np.setxor1d(here_seen, there_seen)) <= 1  # a cell at the very range may round either way
