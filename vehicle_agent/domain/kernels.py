"""Compiles the kernels that every mission needs once, so that no vehicle waits for a compiler in flight.

The results stay in the cache.
"""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.clearance import clear_legs, ground_heights, leg_clearances
from vehicle_agent.domain.fitted_legs import is_clear, lowest_clear_end, lowest_clear_height
from vehicle_agent.domain.lane_sight import look_around, sight_of
from vehicle_agent.domain.lane_trials import Ways
from vehicle_agent.domain.lane_window import window_around
from vehicle_agent.domain.patch_sums import sum_unseen, take_off
from vehicle_agent.domain.paths import assumed_surface, nearest_known_cell, travel_distances
from vehicle_agent.domain.polynomials import cubic_monomials
from vehicle_agent.domain.segments import come_too_near, least_distance_m, segment_distance_m
from vehicle_agent.domain.shared_lanes import LaneCosts, annealing_of, mend_lanes
from vehicle_agent.domain.shared_tours import mend_tours
from vehicle_agent.domain.stops import choose_stops
from vehicle_agent.domain.sweeps import unseen_beside
from vehicle_agent.domain.visibility import best_view, mark_seen, seen_cells


def warm_up() -> None:
    """Call every kernel with the types it is used with."""
    elevation = np.zeros((4, 4))
    point = np.zeros(3)
    leg_clearances(elevation, 0.0, 0.0, 1.0, point, np.ones((2, 3)))
    segment_distance_m(point, point, point, point)
    least_distance_m(1.0, 1.0)
    ground_heights(elevation, 0.0, 0.0, 1.0, np.ones((2, 3)))
    clear_legs(elevation, 0.0, 0.0, 1.0, point, np.ones((2, 3)), 0.0, 1.0, 1.0, 1.0)
    come_too_near(point, np.ones((2, 3)), np.ones((2, 3)), np.ones((2, 3)), 1.0)
    limits = (elevation, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 1.0, np.ones((2, 1, 3)), 1.0)
    is_clear(point, point, *limits)
    lowest_clear_height(point, point[:2], 1.0, *limits)
    lowest_clear_end(point, np.ones(2), 1.0, *limits)
    cubic_monomials(np.ones((2, 3)))
    seen_cells(elevation, point, 1.0, 2.0)
    mark_seen(elevation, np.ones((2, 3)), 1.0, 2.0)
    best_view(elevation, np.ones((2, 3)), 1.0, 2.0, elevation, np.ones(2))
    assumed_surface(elevation, np.ones((4, 4), dtype=np.bool_), 1.0, 2, 1.5)
    travel_distances(np.ones((4, 4), dtype=np.bool_), 0, 0, 1, 1)
    nearest_known_cell(elevation, 0, 0)
    mend_tours(np.ones((3, 2)), np.ones((1, 2)), 0.0, np.zeros(3), np.full(3, -1), 1, 1, 1)
    known = np.ones((4, 4), dtype=np.bool_)
    unseen_beside(np.ones((4, 4), dtype=np.int64), known, np.ones(2), np.ones((2, 2)), 1.0)
    none = np.zeros(4, dtype=np.int64)
    sum_unseen(np.zeros((1, 3), dtype=np.int64), np.ones((4, 4), dtype=np.int64), known, none, none)
    take_off(np.zeros((1, 3), dtype=np.int64), none, known, none, none)
    whole, no_patch = np.ones((4, 4), dtype=np.int64), np.zeros((1, 3), dtype=np.int64)
    choose_stops(whole, known, none, none, no_patch, np.ones(1, dtype=np.bool_), whole.copy(), 2, 1.0, 1.0, 1.0)
    sight = sight_of(2.0, 1.0, (4, 4))
    look_around(sight, np.ones((1, 2)), 1)
    window_around(elevation + 1.0, np.ones((1, 2)), 1.0)
    ways = Ways(np.ones((2, 4, 2)), np.ones(2, dtype=np.int64), np.ones((2, 2)))
    costs = LaneCosts(1.0, 1.0, 1.0, 1.0, 1.0)
    mend_lanes(ways, annealing_of(ways, 1, 1.0, 0.5), sight, elevation, costs, 1, np.random.default_rng(1))


if __name__ == "__main__":
    warm_up()
