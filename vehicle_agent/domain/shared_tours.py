"""Mends a team's open tours over places so that the longest is short (min-max vehicle routing).

Ruin and recreate: places near each other are taken out of their tours and put back where they cost least, and what is
no better is undone (Schrimpf et al. 2000). The order of trials follows from a number, so that everybody who begins with
the same tours and the same number ends with the same tours.
"""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray

_SHORTER_TOURS_TOO = 1e-6
"""Weight of the sum of all tours beside the longest ones."""


@compiled
def _distance(points: FloatArray, first: int, second: int) -> float:
    return math.hypot(points[first, 0] - points[second, 0], points[first, 1] - points[second, 1])


@compiled
def _weight(length: float, scale: float) -> float:
    """A tour's weight: the eighth power of its length, near enough to counting the longest alone."""
    square = (length / scale) ** 2
    fourth = square * square
    return fourth * fourth + _SHORTER_TOURS_TOO * length / scale


@compiled
def _detour(
    points: FloatArray, home: FloatArray, way_back: float, before: int, place: int, after: int
) -> float:  # fmt: skip
    """How much longer a tour is with `place` between two others; `after` is -1 at a tour's end."""
    added = _distance(points, before, place)
    if after >= 0:
        return added + _distance(points, place, after) - _distance(points, before, after)
    if way_back > 0.0:
        old = math.hypot(points[before, 0] - home[0], points[before, 1] - home[1])
        new = math.hypot(points[place, 0] - home[0], points[place, 1] - home[1])
        added += way_back * (new - old)
    return added


@compiled
def _put_in(
    points: FloatArray, homes: FloatArray, way_back: float, service: FloatArray, next_of: IndexArray,
    previous_of: IndexArray, tour_of: IndexArray, lengths: FloatArray, place: int, scale: float,
) -> None:  # fmt: skip
    """Put a free place where the weight of all tours grows least."""
    least, best_before, best_added = math.inf, 0, 0.0
    for before in range(len(points)):
        tour = tour_of[before]
        if tour < 0:
            continue
        added = service[place] + _detour(points, homes[tour], way_back, before, place, next_of[before])
        growth = _weight(lengths[tour] + added, scale) - _weight(lengths[tour], scale)
        if growth < least:
            least, best_before, best_added = growth, before, added
    after = next_of[best_before]
    next_of[best_before], previous_of[place], next_of[place] = place, best_before, after
    if after >= 0:
        previous_of[after] = place
    tour_of[place] = tour_of[best_before]
    lengths[tour_of[place]] += best_added


@compiled
def _take_out(
    points: FloatArray, homes: FloatArray, way_back: float, service: FloatArray, next_of: IndexArray,
    previous_of: IndexArray, tour_of: IndexArray, lengths: FloatArray, place: int,
) -> None:  # fmt: skip
    before, after, tour = previous_of[place], next_of[place], tour_of[place]
    lengths[tour] -= service[place] + _detour(points, homes[tour], way_back, before, place, after)
    next_of[before] = after
    if after >= 0:
        previous_of[after] = before
    tour_of[place] = -1


@compiled
def _put_in_free(
    points: FloatArray, homes: FloatArray, way_back: float, service: FloatArray, next_of: IndexArray,
    previous_of: IndexArray, tour_of: IndexArray, lengths: FloatArray, scale: float,
) -> None:  # fmt: skip
    """Put all free places in, those farthest from every vehicle first."""
    vehicles = len(lengths)
    away = np.full(len(points), -1.0)
    for place in range(vehicles, len(points)):
        if tour_of[place] < 0:
            away[place] = math.inf
            for vehicle in range(vehicles):
                away[place] = min(away[place], _distance(points, vehicle, place))
    while away.max() >= 0.0:
        place = int(np.argmax(away))
        away[place] = -1.0
        _put_in(points, homes, way_back, service, next_of, previous_of, tour_of, lengths, place, scale)


@compiled
def _in_order(taken: IndexArray, trial: int) -> None:
    """Turn the order of places that were taken out, nearest first, by what the trial's number says."""
    if trial % 3 == 1:
        taken[:] = taken[::-1].copy()
    elif trial % 3 == 2:
        for last in range(len(taken) - 1, 0, -1):
            trial = (trial * 1103515245 + 12345) & 0x7FFFFFFF
            other = (trial >> 8) % (last + 1)
            taken[last], taken[other] = taken[other], taken[last]


@compiled
def _centre_of(next_of: IndexArray, lengths: FloatArray, places: int, trial: int) -> int:
    """A place to take out, two times out of three from the longest tour."""
    vehicles = len(lengths)
    number = trial // 3
    if trial % 3 != 0:
        longest = int(np.argmax(lengths))
        stops, place = 0, next_of[longest]
        while place >= 0:
            stops, place = stops + 1, next_of[place]
        if stops > 0:
            place = next_of[longest]
            for _ in range(number % stops):
                place = next_of[place]
            return int(place)
    return int(vehicles + number % places)


@compiled
def mend_tours(
    points: FloatArray, homes: FloatArray, way_back: float, service: FloatArray, next_of: IndexArray,
    trials: int, most_taken: int, number: int,
) -> FloatArray:  # fmt: skip
    """Put free places into a team's tours and make the longest shorter.

    Parameters
    ----------
    points : (N + P, 2) float64, metres: where the N vehicles are, then the P places.
    homes : (N, 2) float64, where each vehicle goes at last.
    way_back : weight in [0, 1] of the way from a tour's last place to its vehicle's home.
    service : (N + P,) float64, extra way that each place costs; nothing for vehicles.
    next_of : (N + P,) int64, the place after each vehicle or place in its tour, -1 at the end of a tour and for places
        that are in none; written to.
    trials : how many changes to try.
    most_taken : places taken out at once, at most.
    number : of this call, at least 0: another number tries other changes.

    Returns
    -------
    (N,) float64, lengths of the tours, service included.
    """
    vehicles = len(homes)
    places = len(points) - vehicles
    previous_of = np.full(len(points), -1, dtype=np.int64)
    tour_of = np.full(len(points), -1, dtype=np.int64)
    lengths = np.zeros(vehicles)
    scale = 1.0
    for vehicle in range(vehicles):
        before, place = vehicle, next_of[vehicle]
        tour_of[vehicle] = vehicle
        lengths[vehicle] = way_back * math.hypot(
            points[vehicle, 0] - homes[vehicle, 0], points[vehicle, 1] - homes[vehicle, 1]
        )
        while place >= 0:
            lengths[vehicle] += service[place] + _detour(points, homes[vehicle], way_back, before, place, -1)
            previous_of[place], tour_of[place] = before, vehicle
            before, place = place, next_of[place]
        for place in range(len(points)):
            scale = max(scale, _distance(points, vehicle, place))
    _put_in_free(points, homes, way_back, service, next_of, previous_of, tour_of, lengths, scale)
    if places == 0:
        return lengths
    state = 88172645463325252 + 1234567 * number
    weight = 0.0
    for length in lengths:
        weight += _weight(length, scale)
    away = np.empty(places)
    for _ in range(trials):
        state ^= (state << 13) & 0x7FFFFFFFFFFFFFFF  # xorshift
        state ^= state >> 7
        state ^= (state << 17) & 0x7FFFFFFFFFFFFFFF
        trial = (state >> 16) & 0x3FFFFFFF
        centre = _centre_of(next_of, lengths, places, trial)
        for place in range(places):
            away[place] = _distance(points, centre, vehicles + place)
        kept = next_of.copy(), previous_of.copy(), tour_of.copy(), lengths.copy()
        taken = np.empty(1 + (trial // 1000) % min(most_taken, places), dtype=np.int64)
        for index in range(len(taken)):
            nearest = int(np.argmin(away))
            away[nearest] = math.inf
            taken[index] = vehicles + nearest
            _take_out(points, homes, way_back, service, next_of, previous_of, tour_of, lengths, taken[index])
        _in_order(taken, trial // 7)
        for index in range(len(taken)):
            _put_in(points, homes, way_back, service, next_of, previous_of, tour_of, lengths, taken[index], scale)
        changed = 0.0
        for length in lengths:
            changed += _weight(length, scale)
        if changed < weight:
            weight = changed
        else:
            next_of[:], previous_of[:], tour_of[:], lengths[:] = kept
    return lengths
