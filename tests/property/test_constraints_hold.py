"""On random ground among random teammates, what is called admissible keeps every constraint."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import map_coordinates

from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.grid import Grid
from vehicle_agent.planning.constraints import Constraints, Reservation
from vehicle_agent.planning.travel import next_leg

CELL_M = 10.0
SAMPLES = 120


@st.composite
def flights(draw: st.DrawFn) -> tuple[Constraints, Point, np.random.Generator]:
    rng = np.random.default_rng(draw(st.integers(0, 2**20)))
    grid = Grid(-40.0, 15.0, CELL_M, 16, 12)
    surface = rng.uniform(0.0, draw(st.sampled_from([0.0, 10.0, 40.0])), grid.shape)
    surface[rng.random(grid.shape) < draw(st.sampled_from([0.0, 0.05, 0.2]))] = math.nan
    low = np.array([grid.west_m, grid.south_m, 0.0])
    high = np.array([grid.east_m, grid.north_m, 120.0])
    legs = [Reservation(*(point(rng, low, high) for _ in "se"), owner_index=n) for n in range(draw(st.integers(0, 3)))]
    minimum = draw(st.sampled_from([5.0, 20.0]))
    constraints = Constraints(grid, surface, minimum, minimum + 40.0, 50.0, 15.0, tuple(legs))
    return constraints, point(rng, low, high), rng


def point(rng: np.random.Generator, low: np.ndarray, high: np.ndarray) -> Point:
    east, north, up = rng.uniform(low, high).tolist()
    return (east, north, up)


def heights_along(constraints: Constraints, start: Point, end: Point) -> np.ndarray:
    """Height above the bilinear surface at points of a leg; NaN where a cell beside is unknown or there is none."""
    parts = np.linspace(0.0, 1.0, SAMPLES)[:, None]
    points = np.array(start) + parts * (np.array(end) - np.array(start))
    grid = constraints.grid
    where = (points[:, :2] - (grid.west_m, grid.south_m)) / grid.cell_m - 0.5
    heights = map_coordinates(constraints.surface_m, where.T, order=1, mode="constant", cval=np.nan)
    return points[:, 2] - heights


def assert_keeps(constraints: Constraints, start: Point, end: Point) -> None:
    heights = heights_along(constraints, start, end)
    here = constraints.height_above_ground_m(start)
    floor_m = constraints.min_above_m if math.isnan(here) else min(constraints.min_above_m, here)
    known = np.flatnonzero(~np.isnan(heights))
    if not math.isnan(here):
        # map_coordinates knows no ground exactly on a border of the unknown
        assert len(known) >= SAMPLES - 2 or np.isnan(constraints.surface_m).any()
    assert np.all(heights[known] >= floor_m - 0.06)
    at_end = constraints.height_above_ground_m(end)
    assert constraints.min_above_m - 0.06 <= at_end <= constraints.max_above_m + 0.06
    assert math.dist(start, end) <= 1.5 * constraints.reach_m + 1e-3
    parts = np.linspace(0.0, 1.0, SAMPLES)[:, None]
    mine = np.array(start) + parts * (np.array(end) - np.array(start))
    for leg in constraints.reservations:
        theirs = np.array(leg.start_enu_m) + parts * (np.array(leg.end_enu_m) - np.array(leg.start_enu_m))
        apart = np.linalg.norm(mine[:, None] - theirs[None], axis=2)
        assert apart.min() >= min(constraints.separation_m, float(apart[0].min())) - 1.0
        from_owner = np.linalg.norm(mine - np.array(leg.start_enu_m), axis=1)
        assert from_owner.min() >= min(constraints.separation_m, float(from_owner[0])) - 0.06


@given(flights())
@settings(max_examples=120, deadline=None)
def test_admissible_ends_keep_every_constraint(flight: tuple[Constraints, Point, np.random.Generator]) -> None:
    constraints, start, rng = flight
    directions = rng.standard_normal((40, 3))
    ends = np.array(start) + rng.uniform(1.0, 90.0, (40, 1)) * directions / np.linalg.norm(directions, axis=1)[:, None]
    admissible = constraints.admissible(start, ends)
    for end in ends[admissible]:
        assert_keeps(constraints, start, (float(end[0]), float(end[1]), float(end[2])))
    assert [constraints.allows(start, (float(e), float(n), float(u))) for e, n, u in ends] == admissible.tolist()


@given(flights())
@settings(max_examples=120, deadline=None)
def test_fitted_legs_and_climbs_keep_every_constraint(flight: tuple[Constraints, Point, np.random.Generator]) -> None:
    constraints, start, rng = flight
    grid = constraints.grid
    goal = (float(rng.uniform(grid.west_m, grid.east_m)), float(rng.uniform(grid.south_m, grid.north_m)))
    for end in (constraints.fit(start, goal), constraints.climb(start), next_leg(start, goal, constraints)):
        if end is not None:
            assert_keeps(constraints, start, end)
            assert constraints.admissible(start, np.array([end])).all()


@given(flights())
@settings(max_examples=60, deadline=None)
def test_known_ground_is_not_left_for_unknown(flight: tuple[Constraints, Point, np.random.Generator]) -> None:
    """On an admissible leg nothing unknown follows something known."""
    constraints, start, rng = flight
    ends = np.array(start) + rng.uniform(-60.0, 60.0, (60, 3))
    grid = constraints.grid
    for end in ends[constraints.admissible(start, ends)]:
        parts = np.linspace(0.0, 1.0, 500)[:, None]
        where = (np.array(start) + parts * (end - np.array(start)))[:, :2] - (grid.west_m, grid.south_m)
        u, v = where.T / grid.cell_m - 0.5
        inner = (u > 0) & (v > 0) & (u < grid.columns - 1) & (v < grid.rows - 1)
        inner &= (abs(u - np.round(u)) > 1e-3) & (abs(v - np.round(v)) > 1e-3)
        u, v = np.clip(u, 0, grid.columns - 1.001), np.clip(v, 0, grid.rows - 1.001)
        corners = [
            constraints.surface_m[np.floor(u).astype(int) + i, np.floor(v).astype(int) + j]
            for i in (0, 1)
            for j in (0, 1)
        ]
        unknown = np.isnan(np.sum(corners, axis=0))[inner]
        assert np.all(np.diff(unknown.astype(int)) <= 0)
