"""A vehicle that makes way flies an admissible leg that brings it out, or stays."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_agent.domain.frames import Point, as_array
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.segments import segment_distance_m
from vehicle_agent.planning.constraints import Constraints, Reservation
from vehicle_agent.planning.way_aside import way_aside

SEPARATION_M = 15.0


def constraints(rough_m: float, rng: np.random.Generator, legs: tuple[Reservation, ...]) -> Constraints:
    grid = Grid(0.0, 0.0, 10.0, 20, 20)
    return Constraints(grid, rng.uniform(0.0, rough_m, grid.shape), 20.0, 60.0, 60.0, SEPARATION_M, legs)


def distance_m(place: Point, leg: Reservation) -> float:
    at = as_array(place)
    return segment_distance_m(at, at, as_array(leg.start_enu_m), as_array(leg.end_enu_m))


@settings(deadline=None)
@given(
    st.integers(0, 2**20),
    st.sampled_from([0.0, 5.0, 30.0]),
    st.floats(0.0, 12.0),
    st.floats(0.0, 2.0 * math.pi),
    st.floats(25.0, 70.0),
)
def test_the_way_aside_is_admissible_and_leads_out(
    seed: int, rough_m: float, beside_m: float, angle: float, up_m: float
) -> None:
    rng = np.random.default_rng(seed)
    column = Reservation((100.0, 100.0, 95.0), (100.0, 100.0, 0.0), 0)
    here = (100.0 + beside_m * math.cos(angle), 100.0 + beside_m * math.sin(angle), up_m)
    limits = constraints(rough_m, rng, (column,))
    end = way_aside(here, (column,), limits)
    if end is None:
        assert rough_m > 0.0
        return
    assert limits.admissible(here, np.array([end])).all()
    assert distance_m(end, column) > distance_m(here, column)
    if rough_m == 0.0:
        assert distance_m(end, column) >= SEPARATION_M - 1e-6


def test_who_is_walled_in_stays() -> None:
    ring = [(100.0 + 30.0 * math.cos(a), 100.0 + 30.0 * math.sin(a)) for a in np.linspace(0.0, 2.0 * math.pi, 12)]
    walls = tuple(Reservation((e, n, 0.0), (e, n, 200.0), 1) for e, n in ring)
    column = Reservation((100.0, 100.0, 95.0), (100.0, 100.0, 0.0), 0)
    here = (108.0, 100.0, 40.0)
    end = way_aside(here, (column,), constraints(0.0, np.random.default_rng(0), (*walls, column)))
    assert end is None or math.dist(end, (100.0, 100.0, 40.0)) < 30.0
