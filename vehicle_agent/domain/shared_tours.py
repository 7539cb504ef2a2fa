"""Mends a team's open tours over places so that the longest is short (min-max vehicle routing).

Ruin and recreate: places near each other are taken out of their tours and put back where they cost least, and what is
no better is undone (Schrimpf et al. 2000). The order of trials follows from a number, so that everybody who begins with
the same tours and the same number ends with the same tours.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray

_SHORTER_TOURS_TOO = 1e-6
"""Weight of the sum of all tours beside the longest ones."""


class _Tours(NamedTuple):
    """Tours while they are mended, of N vehicles over all N + P points, vehicles first.

    Attributes
    ----------
    points : (N + P, 2) float64; homes : (N, 2) float64; way_back, service : as for `mend_tours`.
    next_of, previous_of : (N + P,) int64, the point after and before each, -1 for none.
    tour_of : (N + P,) int64, whose tour a point is in, -1 for none.
    gaps : (N + P,) float64, distance to the next point, 0 at ends.
    homeward : (N + P,) float64, `way_back` times the distance to the home of whose tour it is in.
    lengths : (N,) float64, service included.
    away : (N + P,) float64, least : (N,) float64, where : (N,) int64, scratch of `_put_in`.
    """

    points: FloatArray
    homes: FloatArray
    way_back: float
    service: FloatArray
    next_of: IndexArray
    previous_of: IndexArray
    tour_of: IndexArray
    gaps: FloatArray
    homeward: FloatArray
    lengths: FloatArray
    away: FloatArray
    least: FloatArray
    where: IndexArray


@compiled
def _distance(points: FloatArray, first: int, second: int) -> float:
    return math.sqrt((points[first, 0] - points[second, 0]) ** 2 + (points[first, 1] - points[second, 1]) ** 2)


@compiled
def _homeward(tours: _Tours, place: int, tour: int) -> float:
    if tours.way_back <= 0.0:
        return 0.0
    point, home = tours.points[place], tours.homes[tour]
    return tours.way_back * math.sqrt((point[0] - home[0]) ** 2 + (point[1] - home[1]) ** 2)


@compiled
def _weight(length: float, scale: float) -> float:
    """A tour's weight: the eighth power of its length, near enough to counting the longest alone."""
    square = (length / scale) ** 2
    fourth = square * square
    return fourth * fourth + _SHORTER_TOURS_TOO * length / scale


@compiled
def _measure_from(points: FloatArray, place: int, away: FloatArray) -> None:
    """Write the distance of every point from one."""
    u, v = points[place, 0], points[place, 1]
    for index in range(len(points)):
        away[index] = math.sqrt((points[index, 0] - u) ** 2 + (points[index, 1] - v) ** 2)


@compiled
def _put_in(tours: _Tours, place: int, scale: float) -> None:
    """Put a free place where the weight of all tours grows least: in each tour, that is where it costs least."""
    away, least, where, next_of, tour_of = tours.away, tours.least, tours.where, tours.next_of, tours.tour_of
    _measure_from(tours.points, place, away)
    least[:] = math.inf
    for before in range(len(away)):
        tour = tour_of[before]
        if tour < 0:
            continue
        after = next_of[before]
        added = away[before]
        added += away[after] - tours.gaps[before] if after >= 0 else -tours.homeward[before]
        if after < 0 and tours.way_back > 0.0:
            added += _homeward(tours, place, tour)
        if added < least[tour]:
            least[tour], where[tour] = added, before
    smallest, best = math.inf, 0
    for tour in range(len(least)):
        length = tours.lengths[tour]
        growth = _weight(length + tours.service[place] + least[tour], scale) - _weight(length, scale)
        if growth < smallest:
            smallest, best = growth, tour
    before, after = where[best], next_of[where[best]]
    next_of[before], tours.previous_of[place], next_of[place] = place, before, after
    tours.gaps[before], tours.gaps[place] = away[before], 0.0
    if after >= 0:
        tours.previous_of[after] = place
        tours.gaps[place] = away[after]
    tour_of[place] = best
    tours.homeward[place] = _homeward(tours, place, best)
    tours.lengths[best] += tours.service[place] + least[best]


@compiled
def _take_out(tours: _Tours, place: int) -> None:
    before, after, tour = tours.previous_of[place], tours.next_of[place], tours.tour_of[place]
    saved = tours.service[place] + tours.gaps[before]
    tours.next_of[before] = after
    if after >= 0:
        tours.previous_of[after] = before
        joined = _distance(tours.points, before, after)
        saved += tours.gaps[place] - joined
        tours.gaps[before] = joined
    else:
        saved += tours.homeward[place] - tours.homeward[before]
        tours.gaps[before] = 0.0
    tours.lengths[tour] -= saved
    tours.tour_of[place] = -1


@compiled
def _put_in_free(tours: _Tours, scale: float) -> None:
    """Put all free places in, those farthest from every vehicle first."""
    points, vehicles = tours.points, len(tours.lengths)
    away = np.full(len(points), -1.0)
    for place in range(vehicles, len(points)):
        if tours.tour_of[place] < 0:
            away[place] = math.inf
            for vehicle in range(vehicles):
                away[place] = min(away[place], _distance(points, vehicle, place))
    while away.max() >= 0.0:
        place = int(np.argmax(away))
        away[place] = -1.0
        _put_in(tours, place, scale)


@compiled
def _follow(tours: _Tours) -> float:
    """Fill everything in from `next_of`; returns the greatest distance of a point from a vehicle, at least 1."""
    points, farthest = tours.points, 1.0
    for vehicle in range(len(tours.lengths)):
        before, place = vehicle, tours.next_of[vehicle]
        tours.tour_of[vehicle] = vehicle
        tours.homeward[vehicle] = _homeward(tours, vehicle, vehicle)
        length = 0.0
        while place >= 0:
            tours.gaps[before] = _distance(points, before, place)
            tours.homeward[place] = _homeward(tours, place, vehicle)
            length += tours.service[place] + tours.gaps[before]
            tours.previous_of[place], tours.tour_of[place] = before, vehicle
            before, place = place, tours.next_of[place]
        tours.lengths[vehicle] = length + tours.homeward[before]
        _measure_from(points, vehicle, tours.away)
        farthest = max(farthest, tours.away.max())
    return farthest


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
def _try_changes(tours: _Tours, scale: float, trials: int, most_taken: int, number: int) -> None:
    """Take neighbouring places out and put them back, so often, and keep what makes the weight of all tours less."""
    lengths, count = tours.lengths, len(tours.points)
    vehicles = len(lengths)
    places = count - vehicles
    state = 88172645463325252 + 1234567 * number
    weight = 0.0
    for length in lengths:
        weight += _weight(length, scale)
    away = np.empty(count)
    links = np.empty((3, count), dtype=np.int64)
    measures = np.empty((2, count))
    lengths_before = np.empty(vehicles)
    for _ in range(trials):
        state ^= (state << 13) & 0x7FFFFFFFFFFFFFFF  # xorshift
        state ^= state >> 7
        state ^= (state << 17) & 0x7FFFFFFFFFFFFFFF
        trial = (state >> 16) & 0x3FFFFFFF
        centre = _centre_of(tours.next_of, lengths, places, trial)
        _measure_from(tours.points, centre, away)
        links[0], links[1], links[2] = tours.next_of, tours.previous_of, tours.tour_of
        measures[0], measures[1], lengths_before[:] = tours.gaps, tours.homeward, lengths
        taken = np.empty(1 + (trial // 1000) % min(most_taken, places), dtype=np.int64)
        for index in range(len(taken)):
            taken[index] = vehicles + int(np.argmin(away[vehicles:]))
            away[taken[index]] = math.inf
            _take_out(tours, taken[index])
        _in_order(taken, trial // 7)
        for index in range(len(taken)):
            _put_in(tours, taken[index], scale)
        changed = 0.0
        for length in lengths:
            changed += _weight(length, scale)
        if changed < weight:
            weight = changed
        else:
            tours.next_of[:], tours.previous_of[:], tours.tour_of[:] = links[0], links[1], links[2]
            tours.gaps[:], tours.homeward[:], lengths[:] = measures[0], measures[1], lengths_before


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
    count, vehicles = len(points), len(homes)
    places = count - vehicles
    tours = _Tours(
        points, homes, way_back, service, next_of, np.full(count, -1, dtype=np.int64),
        np.full(count, -1, dtype=np.int64), np.zeros(count), np.zeros(count), np.zeros(vehicles),
        np.zeros(count), np.zeros(vehicles), np.zeros(vehicles, dtype=np.int64),
    )  # fmt: skip
    scale = _follow(tours)
    _put_in_free(tours, scale)
    if places > 0:
        _try_changes(tours, scale, trials, most_taken, number)
    return tours.lengths
