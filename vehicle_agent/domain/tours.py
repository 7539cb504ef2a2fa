"""Shares places out among vehicles as open or closed tours whose longest is short (min-max vehicle routing).

Cheapest insertion for whoever is least busy, then relocation, exchange and reversal while they help. No randomness:
everybody who knows the same places and vehicles finds the same tours, so that a team needs nobody in the middle.
"""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray

NORM = 6.0
"""Tours are weighed by the sum of their lengths to this power: near the maximum, but the shorter ones count too."""


@compiled
def _distance(points: FloatArray, first: int, second: int) -> float:
    return math.hypot(points[first, 0] - points[second, 0], points[first, 1] - points[second, 1])


@compiled
def _insertion(
    points: FloatArray,
    ends: FloatArray,
    tour: IndexArray,
    length: int,
    vehicle: int,
    place: int,
    position: int,
    way_back: float,
) -> float:
    """How much longer a tour becomes with `place` before its `position`-th stop, service left out."""
    before = vehicle if position == 0 else tour[position - 1]
    added = _distance(points, before, place)
    if position < length:
        return added + _distance(points, place, tour[position]) - _distance(points, before, tour[position])
    if way_back > 0.0:
        old = math.hypot(points[before, 0] - ends[vehicle, 0], points[before, 1] - ends[vehicle, 1])
        new = math.hypot(points[place, 0] - ends[vehicle, 0], points[place, 1] - ends[vehicle, 1])
        added += way_back * (new - old)
    return added


@compiled
def _removal(
    points: FloatArray, ends: FloatArray, tour: IndexArray, length: int, vehicle: int, position: int, way_back: float
) -> float:
    """How much shorter a tour becomes without its `position`-th stop, service left out."""
    before = vehicle if position == 0 else tour[position - 1]
    place = tour[position]
    saved = _distance(points, before, place)
    if position + 1 < length:
        return saved + _distance(points, place, tour[position + 1]) - _distance(points, before, tour[position + 1])
    if way_back > 0.0:
        old = math.hypot(points[place, 0] - ends[vehicle, 0], points[place, 1] - ends[vehicle, 1])
        new = math.hypot(points[before, 0] - ends[vehicle, 0], points[before, 1] - ends[vehicle, 1])
        saved += way_back * (old - new)
    return saved


@compiled
def _reverse_where_shorter(
    points: FloatArray, ends: FloatArray, tour: IndexArray, length: int, vehicle: int, way_back: float
) -> float:
    """Reverse stretches of one tour while that shortens it; returns the length saved."""
    saved = 0.0
    improved = True
    while improved:
        improved = False
        for first in range(length - 1):
            before = vehicle if first == 0 else tour[first - 1]
            for last in range(first + 1, length):
                gain = _distance(points, before, tour[first]) - _distance(points, before, tour[last])
                if last + 1 < length:
                    gain += _distance(points, tour[last], tour[last + 1]) - _distance(
                        points, tour[first], tour[last + 1]
                    )
                elif way_back > 0.0:
                    a, b = tour[last], tour[first]
                    gain += way_back * (
                        math.hypot(points[a, 0] - ends[vehicle, 0], points[a, 1] - ends[vehicle, 1])
                        - math.hypot(points[b, 0] - ends[vehicle, 0], points[b, 1] - ends[vehicle, 1])
                    )
                if gain > 1e-6:
                    tour[first : last + 1] = tour[first : last + 1][::-1].copy()
                    saved += gain
                    improved = True
    return saved


@compiled
def share_out(
    starts: FloatArray, ends: FloatArray, places: FloatArray, service: FloatArray, way_back: float, passes: int
) -> tuple[IndexArray, IndexArray]:
    """Tours of several vehicles over places.

    Parameters
    ----------
    starts : (N, 2) float64, where the vehicles are, metres.
    ends : (N, 2) float64, where they go at last.
    places : (P, 2) float64, metres.
    service : (P,) float64, extra way that each place costs.
    way_back : weight in [0, 1] of the way from a tour's last place to its vehicle's end.
    passes : most rounds of improvement.

    Returns
    -------
    tours : (N, P) int64, places by vehicle in order; only the first `lengths[n]` of a row count.
    lengths : (N,) int64.
    """
    vehicles, count = len(starts), len(places)
    points = np.concatenate((starts, places))
    tours = np.zeros((vehicles, max(count, 1)), dtype=np.int64)
    lengths = np.zeros(vehicles, dtype=np.int64)
    costs = np.zeros(vehicles)
    for vehicle in range(vehicles):
        costs[vehicle] = way_back * math.hypot(
            starts[vehicle, 0] - ends[vehicle, 0], starts[vehicle, 1] - ends[vehicle, 1]
        )
    free = np.ones(count, dtype=np.bool_)
    for _ in range(count):
        vehicle = int(np.argmin(costs))
        best, best_place, best_position = math.inf, -1, 0
        for place in range(count):
            if free[place]:
                for position in range(lengths[vehicle] + 1):
                    added = _insertion(
                        points, ends, tours[vehicle], lengths[vehicle], vehicle, vehicles + place, position, way_back
                    )
                    if added < best:
                        best, best_place, best_position = added, place, position
        length = lengths[vehicle]
        tours[vehicle, best_position + 1 : length + 1] = tours[vehicle, best_position:length].copy()
        tours[vehicle, best_position] = vehicles + best_place
        lengths[vehicle] = length + 1
        costs[vehicle] += best + service[best_place]
        free[best_place] = False
    for _ in range(passes):
        improved = False
        for vehicle in range(vehicles):
            saved = _reverse_where_shorter(points, ends, tours[vehicle], lengths[vehicle], vehicle, way_back)
            costs[vehicle] -= saved
            improved = improved or saved > 1e-6
        improved = _relocate(points, ends, tours, lengths, costs, service, vehicles, way_back) or improved
        improved = _exchange(points, ends, tours, lengths, costs, service, vehicles, way_back) or improved
        if not improved:
            break
    return tours - vehicles, lengths


@compiled
def _relocate(
    points: FloatArray, ends: FloatArray, tours: IndexArray, lengths: IndexArray, costs: FloatArray,
    service: FloatArray, vehicles: int, way_back: float,
) -> bool:  # fmt: skip
    """Move single places to better positions, in their own tour or another's; True when one moved."""
    moved = False
    for giver in range(vehicles):
        position = 0
        while position < lengths[giver]:
            place = tours[giver, position]
            saved = _removal(points, ends, tours[giver], lengths[giver], giver, position, way_back)
            work = service[place - vehicles]
            best, best_taker, best_position = -1e-6, -1, 0
            given = costs[giver] - saved - work
            tours[giver, position : lengths[giver] - 1] = tours[giver, position + 1 : lengths[giver]].copy()
            lengths[giver] -= 1
            for taker in range(vehicles):
                for target in range(lengths[taker] + 1):
                    added = _insertion(points, ends, tours[taker], lengths[taker], taker, place, target, way_back)
                    if taker == giver:
                        change = (given + added + work) ** NORM - costs[giver] ** NORM
                    else:
                        change = (
                            given**NORM + (costs[taker] + added + work) ** NORM
                            - costs[giver] ** NORM - costs[taker] ** NORM
                        )  # fmt: skip
                    if change < best * max(1.0, costs[giver] ** NORM):
                        best = change / max(1.0, costs[giver] ** NORM)
                        best_taker, best_position = taker, target
            if best_taker < 0:
                best_taker, best_position = giver, position
            else:
                moved = True
                added = _insertion(
                    points, ends, tours[best_taker], lengths[best_taker], best_taker, place, best_position, way_back
                )
                costs[giver] = given
                costs[best_taker] += added + work
            length = lengths[best_taker]
            tours[best_taker, best_position + 1 : length + 1] = tours[best_taker, best_position:length].copy()
            tours[best_taker, best_position] = place
            lengths[best_taker] = length + 1
            position += 1
    return moved


@compiled
def _exchange(
    points: FloatArray, ends: FloatArray, tours: IndexArray, lengths: IndexArray, costs: FloatArray,
    service: FloatArray, vehicles: int, way_back: float,
) -> bool:  # fmt: skip
    """Exchange single places between two tours where that helps; True when one was."""
    moved = False
    for one in range(vehicles):
        for other in range(one + 1, vehicles):
            for i in range(lengths[one]):
                for j in range(lengths[other]):
                    a, b = tours[one, i], tours[other, j]
                    saved_one = _removal(points, ends, tours[one], lengths[one], one, i, way_back)
                    saved_other = _removal(points, ends, tours[other], lengths[other], other, j, way_back)
                    tours[one, i], tours[other, j] = b, a
                    new_one = costs[one] - saved_one - service[a - vehicles] + service[b - vehicles]
                    new_one += _removal(points, ends, tours[one], lengths[one], one, i, way_back)
                    new_other = costs[other] - saved_other - service[b - vehicles] + service[a - vehicles]
                    new_other += _removal(points, ends, tours[other], lengths[other], other, j, way_back)
                    before = costs[one] ** NORM + costs[other] ** NORM
                    if new_one**NORM + new_other**NORM < before * (1.0 - 1e-6):
                        costs[one], costs[other] = new_one, new_other
                        moved = True
                    else:
                        tours[one, i], tours[other, j] = a, b
    return moved
