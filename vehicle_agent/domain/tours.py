"""Shares places out among vehicles as open tours whose longest is short (min-max vehicle routing), by given distances.

Cheapest insertion for whoever is least busy, then relocation, exchange and reversal while they help. No randomness:
everybody who knows the same places and vehicles finds the same tours, so that a team needs nobody in the middle.
"""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray

NORM = 6.0
"""Tours are weighed by the sum of their lengths to this power: near the maximum, but the shorter ones count too."""


@compiled
def _insertion(away: FloatArray, tour: IndexArray, length: int, vehicle: int, place: int, position: int) -> float:
    """How much longer a tour becomes with `place` before its `position`-th stop, service left out."""
    before = vehicle if position == 0 else tour[position - 1]
    if position < length:
        after = tour[position]
        return float(away[before, place] + away[place, after] - away[before, after])
    return float(away[before, place])


@compiled
def _removal(away: FloatArray, tour: IndexArray, length: int, vehicle: int, position: int) -> float:
    """How much shorter a tour becomes without its `position`-th stop, service left out."""
    before = vehicle if position == 0 else tour[position - 1]
    place = tour[position]
    if position + 1 < length:
        after = tour[position + 1]
        return float(away[before, place] + away[place, after] - away[before, after])
    return float(away[before, place])


@compiled
def _reverse_where_shorter(away: FloatArray, tour: IndexArray, length: int, vehicle: int) -> float:
    """Reverse stretches of one tour while that shortens it; returns the length saved."""
    saved = 0.0
    improved = True
    while improved:
        improved = False
        for first in range(length - 1):
            before = vehicle if first == 0 else tour[first - 1]
            for last in range(first + 1, length):
                gain = away[before, tour[first]] - away[before, tour[last]]
                if last + 1 < length:
                    gain += away[tour[last], tour[last + 1]] - away[tour[first], tour[last + 1]]
                if gain > 1e-6:
                    tour[first : last + 1] = tour[first : last + 1][::-1].copy()
                    saved += gain
                    improved = True
    return saved


@compiled
def share_out(away: FloatArray, ahead: FloatArray, service: FloatArray, passes: int) -> tuple[IndexArray, IndexArray]:
    """Tours of N vehicles over P places.

    Parameters
    ----------
    away : (N + P, N + P) float64, symmetric: distances between vehicles and places, vehicles first.
    ahead : (N,) float64, way that each vehicle has to go before its tour begins.
    service : (P,) float64, extra way that each place costs.
    passes : most rounds of improvement.

    Returns
    -------
    tours : (N, P) int64, places by vehicle in order; only the first `lengths[n]` of a row count.
    lengths : (N,) int64.
    """
    vehicles, count = len(ahead), len(service)
    tours = np.zeros((vehicles, max(count, 1)), dtype=np.int64)
    lengths = np.zeros(vehicles, dtype=np.int64)
    costs = ahead.copy()
    free = np.ones(count, dtype=np.bool_)
    for _ in range(count):
        _insert_cheapest(away, tours, lengths, costs, service, free)
    for _ in range(passes):
        improved = False
        for vehicle in range(vehicles):
            saved = _reverse_where_shorter(away, tours[vehicle], lengths[vehicle], vehicle)
            costs[vehicle] -= saved
            improved = improved or saved > 1e-6
        improved = _relocate(away, tours, lengths, costs, service) or improved
        improved = _exchange(away, tours, lengths, costs, service) or improved
        if not improved:
            break
    return tours - vehicles, lengths


@compiled
def _insert_cheapest(
    away: FloatArray, tours: IndexArray, lengths: IndexArray, costs: FloatArray, service: FloatArray, free: BoolArray
) -> None:
    """Give the least busy vehicle the free place that lengthens its way least."""
    vehicles = len(lengths)
    vehicle = int(np.argmin(costs))
    best, best_place, best_position = math.inf, -1, 0
    for place in range(len(free)):
        if free[place]:
            for position in range(lengths[vehicle] + 1):
                added = _insertion(away, tours[vehicle], lengths[vehicle], vehicle, vehicles + place, position)
                if added < best:
                    best, best_place, best_position = added, place, position
    length = lengths[vehicle]
    tours[vehicle, best_position + 1 : length + 1] = tours[vehicle, best_position:length].copy()
    tours[vehicle, best_position] = vehicles + best_place
    lengths[vehicle] = length + 1
    costs[vehicle] += best + service[best_place]
    free[best_place] = False


@compiled
def _relocate(away: FloatArray, tours: IndexArray, lengths: IndexArray, costs: FloatArray, service: FloatArray) -> bool:
    """Move single places to better positions, in their own tour or another's; True when one moved."""
    vehicles = len(lengths)
    moved = False
    for giver in range(vehicles):
        position = 0
        while position < lengths[giver]:
            place = tours[giver, position]
            saved = _removal(away, tours[giver], lengths[giver], giver, position)
            work = service[place - vehicles]
            best, best_taker, best_position = -1e-6, -1, 0
            given = costs[giver] - saved - work
            tours[giver, position : lengths[giver] - 1] = tours[giver, position + 1 : lengths[giver]].copy()
            lengths[giver] -= 1
            for taker in range(vehicles):
                for target in range(lengths[taker] + 1):
                    added = _insertion(away, tours[taker], lengths[taker], taker, place, target)
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
                added = _insertion(away, tours[best_taker], lengths[best_taker], best_taker, place, best_position)
                costs[giver] = given
                costs[best_taker] += added + work
            length = lengths[best_taker]
            tours[best_taker, best_position + 1 : length + 1] = tours[best_taker, best_position:length].copy()
            tours[best_taker, best_position] = place
            lengths[best_taker] = length + 1
            position += 1
    return moved


@compiled
def _exchange(away: FloatArray, tours: IndexArray, lengths: IndexArray, costs: FloatArray, service: FloatArray) -> bool:
    """Exchange single places between two tours where that helps; True when one was."""
    vehicles = len(lengths)
    moved = False
    for one in range(vehicles):
        for other in range(one + 1, vehicles):
            for i in range(lengths[one]):
                for j in range(lengths[other]):
                    a, b = tours[one, i], tours[other, j]
                    saved_one = _removal(away, tours[one], lengths[one], one, i)
                    saved_other = _removal(away, tours[other], lengths[other], other, j)
                    tours[one, i], tours[other, j] = b, a
                    new_one = costs[one] - saved_one - service[a - vehicles] + service[b - vehicles]
                    new_one += _removal(away, tours[one], lengths[one], one, i)
                    new_other = costs[other] - saved_other - service[b - vehicles] + service[a - vehicles]
                    new_other += _removal(away, tours[other], lengths[other], other, j)
                    before = costs[one] ** NORM + costs[other] ** NORM
                    if new_one**NORM + new_other**NORM < before * (1.0 - 1e-6):
                        costs[one], costs[other] = new_one, new_other
                        moved = True
                    else:
                        tours[one, i], tours[other, j] = a, b
    return moved
