"""Leads a vehicle to a goal through what is known, one straight leg at a time."""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.paths import as_array, leg_clearances, trace_way, travel_distances
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.planning.constraints import Constraints

BESIDE_CELLS = 3
LOOK_AHEAD = 3.0
"""A way is cut short towards its farthest point in sight within so many legs, so that legs keep their full length."""


def next_leg(position_enu_m: Point, goal_en_m: tuple[float, float], constraints: Constraints) -> Point | None:
    """End of the next admissible leg towards a goal; None when there is none now.

    Straight on where the whole line lies over known ground, else along the shortest way through known cells, cut
    short where the next straight leg would leave them. Where terrain stands in the way, a climb on the spot.
    """
    for target in _targets(position_enu_m, goal_en_m, constraints):
        end = constraints.fit(position_enu_m, target)
        if end is not None:
            return end
    return constraints.climb(position_enu_m)


def way_length_m(position_enu_m: Point, goal_en_m: tuple[float, float]) -> float:
    """Straight horizontal distance to a goal, metres: the measure by which frontiers are compared."""
    return math.hypot(goal_en_m[0] - position_enu_m[0], goal_en_m[1] - position_enu_m[1])


def _targets(
    position_enu_m: Point, goal_en_m: tuple[float, float], constraints: Constraints
) -> list[tuple[float, float]]:
    grid = constraints.grid
    passable = ~np.isnan(constraints.surface_m)
    start = _nearest_passable(passable, *grid.cell_of(*position_enu_m[:2]))
    if start is None:
        return []
    if start != grid.cell_of(*position_enu_m[:2]):  # where it should not be: leave by the shortest way
        return [grid.centre_of(*start)]
    if _line_is_known(position_enu_m, goal_en_m, constraints):
        return [goal_en_m]
    distances, parents = travel_distances(passable, *start)
    goal = _nearest_passable(np.isfinite(distances), *grid.cell_of(*goal_en_m))
    if goal is None:
        return []
    way = [grid.centre_of(*cell) for cell in trace_way(parents, *goal)]
    ahead = [point for point in way if math.dist(point, position_enu_m[:2]) > 0.5 * grid.cell_m]
    within = [point for point in ahead if math.dist(point, position_enu_m[:2]) <= LOOK_AHEAD * constraints.reach_m]
    seen = [point for point in within if _line_is_known(position_enu_m, point, constraints)]
    if seen or not ahead:
        return seen[:-4:-1]
    return _ways_round(position_enu_m, goal, passable, constraints)


def _ways_round(
    position_enu_m: Point, goal: tuple[int, int], passable: BoolArray, constraints: Constraints
) -> list[tuple[float, float]]:
    """Places beside a vehicle that stands too near to a corner for the shortest way, best first.

    Between a cell that may be overflown and one that may not, a few centimetres decide what a leg touches.
    """
    grid = constraints.grid
    distances, _ = travel_distances(passable, *goal)
    column, row = grid.cell_of(*position_enu_m[:2])
    left, low = max(0, column - BESIDE_CELLS), max(0, row - BESIDE_CELLS)
    window = distances[left : column + BESIDE_CELLS + 1, low : row + BESIDE_CELLS + 1]
    costs = []
    for c, r in np.argwhere(np.isfinite(window)).tolist():
        place = grid.centre_of(left + c, low + r)
        away = math.dist(place, position_enu_m[:2]) / grid.cell_m
        if away > 0.5 and _line_is_known(position_enu_m, place, constraints):
            costs.append((away + float(window[c, r]), place))
    return [place for _, place in sorted(costs)[:3]]


def _line_is_known(position_enu_m: Point, goal_en_m: tuple[float, float], constraints: Constraints) -> bool:
    grid = constraints.grid
    start = as_array(position_enu_m)
    clearance: FloatArray = leg_clearances(
        constraints.surface_m,
        grid.west_m,
        grid.south_m,
        grid.cell_m,
        start,
        np.array([[goal_en_m[0], goal_en_m[1], start[2]]]),
    )
    return not math.isnan(clearance[0])


def _nearest_passable(passable: BoolArray, column: int, row: int) -> tuple[int, int] | None:
    """The passable cell nearest to a cell, itself included; None when nothing is passable."""
    if passable[column, row]:
        return (column, row)
    found = np.argwhere(passable)
    if len(found) == 0:
        return None
    best = found[np.argmin((found[:, 0] - column) ** 2 + (found[:, 1] - row) ** 2)]
    return (int(best[0]), int(best[1]))
