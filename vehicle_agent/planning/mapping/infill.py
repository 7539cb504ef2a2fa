"""The way that tells most of what is still uncertain of a surface, within a length: insertion, then untangling."""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray

LONGEST_WAY = 600
"""Corners of a way at most."""


@compiled
def most_telling_way(
    east_m: float,
    north_m: float,
    nodes_en_m: FloatArray,
    covariance_m2: FloatArray,
    weights: FloatArray,
    sounding_m2: float,
    length_m: float,
    turn_m: float,
) -> FloatArray:
    """Corners of a way from a place over nodes, no longer than a length: (K, 2), the place first.

    The node comes next that takes most weighted variance away per metre of detour, at the best place of the way; then
    the covariance is what it would be after sounding there (a Gaussian process's A-optimal design, greedily).

    Parameters
    ----------
    nodes_en_m : (M, 2); covariance_m2 : (M, M), overwritten; weights : (M,), what a node's variance counts.
    sounding_m2
        Variance of a sounding.
    turn_m
        A detour is reckoned this much longer.
    """
    count = len(nodes_en_m)
    way = np.empty((LONGEST_WAY, 2))
    way[0, 0], way[0, 1] = east_m, north_m
    corners, gone_m = 1, 0.0
    detours, places = np.empty(count), np.ones(count, dtype=np.int64)
    visited = np.zeros(count, dtype=np.bool_)
    for node in range(count):
        detours[node] = math.hypot(nodes_en_m[node, 0] - east_m, nodes_en_m[node, 1] - north_m)
        visited[node] = detours[node] < 0.25 * turn_m  # it is there already
    while corners < LONGEST_WAY:
        best, chosen = 0.0, -1
        for node in range(count):
            if visited[node] or gone_m + detours[node] > length_m:
                continue
            gain = 0.0
            for other in range(count):
                gain += weights[other] * covariance_m2[node, other] ** 2
            gain /= (covariance_m2[node, node] + sounding_m2) * (detours[node] + turn_m)
            if gain > best:
                best, chosen = gain, node
        if chosen < 0:
            break
        visited[chosen] = True
        place = places[chosen]
        for corner in range(corners, place, -1):
            way[corner] = way[corner - 1]
        way[place] = nodes_en_m[chosen]
        corners += 1
        gone_m += detours[chosen]
        shared = covariance_m2[chosen].copy()
        for node in range(count):
            share = shared[node] / (shared[chosen] + sounding_m2)
            if share != 0.0:
                for other in range(count):
                    covariance_m2[node, other] -= share * shared[other]
            detours[node], places[node] = _cheapest_place(way, corners, nodes_en_m[node])
    _untangle(way, corners)
    return way[:corners].copy()


@compiled
def _cheapest_place(way: FloatArray, corners: int, node: FloatArray) -> tuple[float, int]:
    """Detour over a node and the corner that it would become."""
    least_m = math.hypot(way[corners - 1, 0] - node[0], way[corners - 1, 1] - node[1])
    place = corners
    before_m = math.hypot(way[0, 0] - node[0], way[0, 1] - node[1])
    for corner in range(1, corners):
        after_m = math.hypot(way[corner, 0] - node[0], way[corner, 1] - node[1])
        straight_m = math.hypot(way[corner, 0] - way[corner - 1, 0], way[corner, 1] - way[corner - 1, 1])
        if before_m + after_m - straight_m < least_m:
            least_m, place = before_m + after_m - straight_m, corner
        before_m = after_m
    return least_m, place


@compiled
def _untangle(way: FloatArray, corners: int) -> None:
    """Turn parts of an open way round while that makes it shorter (2-opt)."""
    shorter = True
    while shorter:
        shorter = False
        for first in range(1, corners - 1):
            for last in range(first + 1, corners):
                saved_m = math.hypot(way[first - 1, 0] - way[first, 0], way[first - 1, 1] - way[first, 1])
                saved_m -= math.hypot(way[first - 1, 0] - way[last, 0], way[first - 1, 1] - way[last, 1])
                if last + 1 < corners:
                    saved_m += math.hypot(way[last, 0] - way[last + 1, 0], way[last, 1] - way[last + 1, 1])
                    saved_m -= math.hypot(way[first, 0] - way[last + 1, 0], way[first, 1] - way[last + 1, 1])
                if saved_m > 1e-9:
                    way[first : last + 1] = way[first : last + 1][::-1].copy()
                    shorter = True
