"""Leads a vehicle to a goal through what is known, one straight leg at a time."""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.domain.clearance import leg_clearances
from vehicle_agent.domain.frames import FloatArray, Point, as_array
from vehicle_agent.domain.paths import nearest_known_cell, trace_way, travel_distances
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.planning.constraints import Constraints

Cell = tuple[int, int]
EastNorth = tuple[float, float]

NOWHERE = (-1, -1)
BESIDE_CELLS = 3
WIDER = 12
"""Ways are looked for so many cells around what is needed at least."""
WHOLE_STEP = 0.95
"""A leg is flown on while so much of a step is left of it: short steps waste time."""
LOOK_AHEAD = 3.0
"""A way is cut short towards its farthest point in sight within so many legs, so that legs keep their full length."""


def next_leg(
    position_enu_m: Point, goal_en_m: tuple[float, float], constraints: Constraints, legs: int = 1
) -> Point | None:
    """End of the next admissible leg towards a goal, or of so many in a line; None when there is none now.

    Straight on where the whole line lies over known ground, else along the shortest way through known cells, cut
    short where the next straight leg would leave them. Where terrain stands in the way, a climb on the spot.
    """
    for target in _targets(position_enu_m, goal_en_m, constraints, legs):
        end = constraints.fit(position_enu_m, target, legs)
        if end is not None:
            return end
    return constraints.climb(position_enu_m, legs)


def way_length_m(position_enu_m: Point, goal_en_m: tuple[float, float]) -> float:
    """Straight horizontal distance to a goal, metres: the measure by which frontiers are compared."""
    return math.hypot(goal_en_m[0] - position_enu_m[0], goal_en_m[1] - position_enu_m[1])


def along(start_enu_m: Point, end_enu_m: Point, reach_m: float) -> Point:
    """The end of a leg, or the place on it that is so far over ground."""
    away_m = math.hypot(end_enu_m[0] - start_enu_m[0], end_enu_m[1] - start_enu_m[1])
    if away_m <= reach_m:
        return end_enu_m
    part = reach_m / away_m
    return (
        start_enu_m[0] + part * (end_enu_m[0] - start_enu_m[0]),
        start_enu_m[1] + part * (end_enu_m[1] - start_enu_m[1]),
        start_enu_m[2] + part * (end_enu_m[2] - start_enu_m[2]),
    )


def beyond(place_en_m: EastNorth, following_en_m: EastNorth, length_m: float) -> EastNorth:
    """A place on the way from one to the next, so that a leg does not end at the first."""
    part = min(1.0, (length_m + 0.01) / max(math.dist(place_en_m, following_en_m), 1e-9))
    return (
        place_en_m[0] + part * (following_en_m[0] - place_en_m[0]),
        place_en_m[1] + part * (following_en_m[1] - place_en_m[1]),
    )


def next_step(position_enu_m: Point, leg_end_enu_m: Point, constraints: Constraints) -> Point | None:
    """The next step of a leg decided on before; None at its end, where a step would be short, and where it is taken."""
    if math.dist(position_enu_m, leg_end_enu_m) < WHOLE_STEP * constraints.reach_m:
        return None
    step = along(position_enu_m, leg_end_enu_m, constraints.reach_m)
    return step if constraints.allows(position_enu_m, step) else None


def _targets(
    position_enu_m: Point, goal_en_m: tuple[float, float], constraints: Constraints, legs: int
) -> list[tuple[float, float]]:
    grid, surface_m = constraints.grid, constraints.surface_m
    inside = grid.cell_of(*position_enu_m[:2])
    start = nearest_known_cell(surface_m, *inside)
    if start == NOWHERE:
        return []
    if start != inside:  # where it should not be: leave by the shortest way
        return [grid.centre_of(*start)]
    if _line_is_known(position_enu_m, goal_en_m, constraints):
        return [goal_en_m]
    cells, length = _shortest_way(surface_m, start, grid.cell_of(*goal_en_m))
    way = [grid.centre_of(*cell) for cell in cells]
    ahead = [point for point in way if math.dist(point, position_enu_m[:2]) > 0.5 * grid.cell_m]
    look_m = LOOK_AHEAD * legs * constraints.reach_m
    within = [point for point in ahead if math.dist(point, position_enu_m[:2]) <= look_m]
    seen = [point for point in within if _line_is_known(position_enu_m, point, constraints)]
    if seen or not ahead:
        return seen[:-4:-1]
    return _ways_round(position_enu_m, cells[-1], length, constraints)


def _shortest_way(surface_m: FloatArray, start: Cell, goal: Cell) -> tuple[list[Cell], float]:
    """Shortest way through known cells to the one nearest to a goal among those that can be reached, and its length.

    It is looked for in a square around the start: a way no longer than half the square's width cannot be shorter
    outside. So the work follows the length of the way, and only a long detour makes it grow with the map.
    """
    nearest = nearest_known_cell(surface_m, *goal)
    reach = WIDER + max(abs(nearest[0] - start[0]), abs(nearest[1] - start[1]))
    while True:
        passable, corner = _passable_around(surface_m, start, reach)
        here = (start[0] - corner[0], start[1] - corner[1])
        there = (nearest[0] - corner[0], nearest[1] - corner[1])
        distances, parents = travel_distances(passable, *here, *there)
        whole = passable.shape == surface_m.shape
        if whole and math.isinf(distances[there]):
            finite = np.where(np.isfinite(distances), 0.0, math.nan)
            there = nearest_known_cell(finite, *goal)
        if whole or distances[there] <= reach:
            way = [(column + corner[0], row + corner[1]) for column, row in trace_way(parents, *there)]
            return way, float(distances[there])
        reach *= 2


def _passable_around(surface_m: FloatArray, middle: Cell, reach: int) -> tuple[BoolArray, Cell]:
    """Which cells of a square are known, and the column and row of its south-western one."""
    left, low = max(0, middle[0] - reach), max(0, middle[1] - reach)
    passable: BoolArray = ~np.isnan(surface_m[left : middle[0] + reach + 1, low : middle[1] + reach + 1])
    return passable, (left, low)


def _ways_round(
    position_enu_m: Point, goal: Cell, length: float, constraints: Constraints
) -> list[tuple[float, float]]:
    """Places beside a vehicle that stands too near to a corner for the shortest way, best first.

    Between a cell that may be overflown and one that may not, a few centimetres decide what a leg touches.
    """
    grid = constraints.grid
    passable, corner = _passable_around(constraints.surface_m, goal, math.ceil(length) + WIDER)
    distances, _ = travel_distances(passable, goal[0] - corner[0], goal[1] - corner[1], *NOWHERE)
    column, row = grid.cell_of(*position_enu_m[:2])
    left, low = max(corner[0], column - BESIDE_CELLS), max(corner[1], row - BESIDE_CELLS)
    window = distances[
        left - corner[0] : column + BESIDE_CELLS + 1 - corner[0], low - corner[1] : row + BESIDE_CELLS + 1 - corner[1]
    ]
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
