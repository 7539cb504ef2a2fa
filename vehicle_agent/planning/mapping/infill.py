"""The track that tells most of a rough surface within a length: stops where soundings are far for the ground, then a
chain of soundings that settles among them.

Between tracks a distance d apart, a surface whose increments over r have a mean square of s^2 r^p is uncertain by about
s^2 d^p. Over a given length of track the sum of that is least where d is proportional to s^(-2 / (p + 1)): tracks lie
close on rough ground and wide apart on even ground. Stops are set at such distances and a short way is laid through
them; then every sounding of the track is drawn to the middle of the ground that it speaks for, as in Lloyd's iteration.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import KDTree

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray

MOST_STOPS = 400
"""Of a way at most."""
STOPS_FOLLOW = (0.75, 1.0, 1.3)
"""Powers of what is wanted between tracks that stops are tried at: the chain that settles from them is judged."""
NEAREST_M = 0.3
"""Ground nearer to a sounding pulls no harder than at this distance."""
PULL = 0.5
"""Share of the way to the middle of its ground that a sounding goes in one round."""
LINKS_MENDED = 10
"""How often the chain's links are shortened in one round."""
LIGHT = 0.1
"""What a sounding without ground weighs, over the mean."""


def telling_track(
    here_en_m: FloatArray,
    nodes_en_m: FloatArray,
    strengths: FloatArray,
    away_m: FloatArray,
    length_m: float,
    step_m: float,
    exponent: float,
    rounds: int,
) -> FloatArray:
    """Places of soundings, at most `step_m` apart, the present place first: (K, 2) ENU metres.

    Parameters
    ----------
    nodes_en_m : (M, 2), the ground; strengths : (M,), its roughness over that on the whole, positive.
    away_m : (M,), distance of the nearest sounding that there is already.
    exponent
        Of the power law, p above.
    rounds
        Of settling; with none the way is left as the stops make it.
    """
    best, least = here_en_m[None], math.inf
    for follows in STOPS_FOLLOW:
        way = _longest_way(here_en_m, nodes_en_m, strengths ** (-2.0 * follows / (exponent + 1.0)), away_m, length_m)
        if len(way) == 1:
            continue
        soundings = max(2, int(length_m / step_m) + 1)
        gone_m = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(way, axis=0).T))))
        at_m = np.linspace(0.0, gone_m[-1], soundings)
        track = np.column_stack([np.interp(at_m, gone_m, way[:, axis]) for axis in (0, 1)])
        track = settled_track(track, nodes_en_m, strengths, away_m, step_m, exponent, rounds)
        untold = left_untold(track, nodes_en_m, strengths, away_m, exponent)
        if untold < least:
            best, least = track, untold
    return best


def _longest_way(
    here_en_m: FloatArray, nodes_en_m: FloatArray, wanted_m: FloatArray, away_m: FloatArray, length_m: float
) -> FloatArray:
    """A short way through as many stops as a length allows: (K, 2), the present place first; wanted_m : (M,)."""
    order = _stops(nodes_en_m, wanted_m, away_m, min(len(nodes_en_m), MOST_STOPS))
    fits, too_many = 0, len(order) + 1
    way = here_en_m[None]
    while too_many - fits > 1:
        count = (fits + too_many) // 2
        tried = _way_through(here_en_m, nodes_en_m[order[:count]])
        if _length_m(tried) <= length_m:
            fits, way = count, tried
        else:
            too_many = count
    return way


def settled_track(
    track_en_m: FloatArray,
    nodes_en_m: FloatArray,
    strengths: FloatArray,
    away_m: FloatArray,
    step_m: float,
    exponent: float,
    rounds: int,
) -> FloatArray:
    """A track, its first place kept, drawn to where it tells most nearby; parameters as for `telling_track`."""
    return _settled(np.ascontiguousarray(track_en_m), nodes_en_m, strengths**2, away_m, step_m, exponent, rounds)


def left_untold(
    track_en_m: FloatArray, nodes_en_m: FloatArray, strengths: FloatArray, away_m: FloatArray, exponent: float
) -> float:
    """How uncertain the ground still is once a track is sailed, up to a factor; parameters as for `telling_track`."""
    left_m = np.minimum(np.asarray(KDTree(track_en_m).query(nodes_en_m)[0]), away_m)
    return float((strengths**2 * np.maximum(left_m, NEAREST_M) ** exponent).sum())


@compiled
def _stops(nodes_en_m: FloatArray, wanted_m: FloatArray, away_m: FloatArray, count: int) -> IndexArray:
    """Numbers of nodes, each the one farthest from all soundings and stops before it, over what is wanted there."""
    away_m = away_m.copy()
    stops = np.empty(count, dtype=np.int64)
    for number in range(count):
        most, chosen = 0.0, -1
        for node in range(len(nodes_en_m)):
            if away_m[node] > most * wanted_m[node]:
                most, chosen = away_m[node] / wanted_m[node], node
        if chosen < 0:
            return stops[:number].copy()
        stops[number] = chosen
        for node in range(len(nodes_en_m)):
            near_m = math.hypot(
                nodes_en_m[node, 0] - nodes_en_m[chosen, 0], nodes_en_m[node, 1] - nodes_en_m[chosen, 1]
            )
            away_m[node] = min(away_m[node], near_m)
    return stops


@compiled
def _way_through(here_en_m: FloatArray, stops_en_m: FloatArray) -> FloatArray:
    """A short open way from a place through all stops: (K, 2) -> (K + 1, 2); insertion, then untangling."""
    way = np.empty((len(stops_en_m) + 1, 2))
    way[0] = here_en_m
    for corners in range(1, len(way)):
        stop = stops_en_m[corners - 1]
        place = _cheapest_place(way, corners, stop)
        for corner in range(corners, place, -1):
            way[corner] = way[corner - 1]
        way[place] = stop
    shorter = True
    while shorter:
        shorter = _turn_parts(way)
        shorter |= _move_parts(way)
    return way


@compiled
def _cheapest_place(way: FloatArray, corners: int, stop: FloatArray) -> int:
    """The corner that a stop would become on the least detour."""
    least_m = math.hypot(way[corners - 1, 0] - stop[0], way[corners - 1, 1] - stop[1])
    place = corners
    before_m = math.hypot(way[0, 0] - stop[0], way[0, 1] - stop[1])
    for corner in range(1, corners):
        after_m = math.hypot(way[corner, 0] - stop[0], way[corner, 1] - stop[1])
        straight_m = math.hypot(way[corner, 0] - way[corner - 1, 0], way[corner, 1] - way[corner - 1, 1])
        if before_m + after_m - straight_m < least_m:
            least_m, place = before_m + after_m - straight_m, corner
        before_m = after_m
    return place


@compiled
def _turn_parts(way: FloatArray) -> bool:
    """Turn parts of an open way round where that makes it shorter (2-opt); whether any was turned."""
    corners, turned = len(way), False
    for first in range(1, corners - 1):
        for last in range(first + 1, corners):
            saved_m = math.hypot(way[first - 1, 0] - way[first, 0], way[first - 1, 1] - way[first, 1])
            saved_m -= math.hypot(way[first - 1, 0] - way[last, 0], way[first - 1, 1] - way[last, 1])
            if last + 1 < corners:
                saved_m += math.hypot(way[last, 0] - way[last + 1, 0], way[last, 1] - way[last + 1, 1])
                saved_m -= math.hypot(way[first, 0] - way[last + 1, 0], way[first, 1] - way[last + 1, 1])
            if saved_m > 1e-9:
                way[first : last + 1] = way[first : last + 1][::-1].copy()
                turned = True
    return turned


@compiled
def _move_parts(way: FloatArray) -> bool:
    """Move single corners to where they are less of a detour (Or-opt); whether any was moved."""
    corners, moved = len(way), False
    for corner in range(1, corners):
        stop = way[corner].copy()
        saved_m = math.hypot(way[corner - 1, 0] - stop[0], way[corner - 1, 1] - stop[1])
        if corner + 1 < corners:
            saved_m += math.hypot(way[corner + 1, 0] - stop[0], way[corner + 1, 1] - stop[1])
            saved_m -= math.hypot(way[corner + 1, 0] - way[corner - 1, 0], way[corner + 1, 1] - way[corner - 1, 1])
        rest = np.empty((corners - 1, 2))
        rest[:corner] = way[:corner]
        rest[corner:] = way[corner + 1 :]
        place = _cheapest_place(rest, corners - 1, stop)
        cost_m = math.hypot(rest[place - 1, 0] - stop[0], rest[place - 1, 1] - stop[1])
        if place < corners - 1:
            cost_m += math.hypot(rest[place, 0] - stop[0], rest[place, 1] - stop[1])
            cost_m -= math.hypot(rest[place, 0] - rest[place - 1, 0], rest[place, 1] - rest[place - 1, 1])
        if cost_m < saved_m - 1e-9:
            way[:place], way[place], way[place + 1 :] = rest[:place], stop, rest[place:]
            moved = True
    return moved


@compiled
def _settled(
    track_en_m: FloatArray,
    nodes_en_m: FloatArray,
    weights: FloatArray,
    away_m: FloatArray,
    step_m: float,
    exponent: float,
    rounds: int,
) -> FloatArray:
    """Draw every sounding to the middle of its ground, links staying at most a step long and the first in place."""
    track, count = track_en_m.copy(), len(track_en_m)
    masses = np.empty(count)
    middles = np.empty((count, 2))
    for _ in range(rounds):
        masses[:], middles[:] = 0.0, 0.0
        for node in range(len(nodes_en_m)):
            east_m, north_m = nodes_en_m[node, 0], nodes_en_m[node, 1]
            least_m2, nearest = away_m[node] ** 2, -1
            for place in range(count):
                apart_m2 = (east_m - track[place, 0]) ** 2 + (north_m - track[place, 1]) ** 2
                if apart_m2 < least_m2:
                    least_m2, nearest = apart_m2, place
            if nearest >= 0:
                mass = weights[node] * max(math.sqrt(least_m2), NEAREST_M) ** (exponent - 2.0)
                masses[nearest] += mass
                middles[nearest, 0] += mass * east_m
                middles[nearest, 1] += mass * north_m
        for place in range(1, count):
            if masses[place] > 0.0:
                track[place] += PULL * (middles[place] / masses[place] - track[place])
        masses += LIGHT * masses.mean() + 1e-12
        for _ in range(LINKS_MENDED):
            shorten_links(track, masses, step_m)
    for place in range(1, count):  # from here on each sounding follows the one before: no link stays too long
        long_m = math.hypot(track[place, 0] - track[place - 1, 0], track[place, 1] - track[place - 1, 1])
        if long_m > step_m:
            track[place] = track[place - 1] + step_m / long_m * (track[place] - track[place - 1])
    return track


@compiled
def shorten_links(track: FloatArray, masses: FloatArray, step_m: float) -> None:
    """Draw the ends of links that are too long together, the lighter end further."""
    for place in range(len(track) - 1):
        east_m, north_m = track[place + 1, 0] - track[place, 0], track[place + 1, 1] - track[place, 1]
        long_m = math.hypot(east_m, north_m)
        if long_m > step_m:
            share = masses[place + 1] / (masses[place] + masses[place + 1]) if place > 0 else 0.0
            over = (long_m - step_m) / long_m
            track[place, 0] += share * over * east_m
            track[place, 1] += share * over * north_m
            track[place + 1, 0] -= (1.0 - share) * over * east_m
            track[place + 1, 1] -= (1.0 - share) * over * north_m


@compiled
def _length_m(way: FloatArray) -> float:
    length_m = 0.0
    for corner in range(1, len(way)):
        length_m += math.hypot(way[corner, 0] - way[corner - 1, 0], way[corner, 1] - way[corner - 1, 1])
    return length_m
