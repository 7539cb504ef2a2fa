"""Distance between straight legs, and which legs come too near to teammates', as compiled kernels."""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.polygon import BoolArray

WAVER_M = 0.05
"""Positions waver so much: two that are too near already may come nearer by it."""


@compiled
def _squared_gap(aa: float, bb: float, ab: float, aw: float, bw: float, ww: float, s: float, t: float) -> float:
    """Squared length of w + s a - t b from the products of the three vectors."""
    return ww + s * s * aa + t * t * bb + 2.0 * (s * aw - t * bw - s * t * ab)


@compiled
def _apart(one: FloatArray, other: FloatArray) -> float:
    return math.sqrt((one[0] - other[0]) ** 2 + (one[1] - other[1]) ** 2 + (one[2] - other[2]) ** 2)


@compiled
def segment_distance_m(a0: FloatArray, a1: FloatArray, b0: FloatArray, b1: FloatArray) -> float:
    """Smallest distance between two segments in space, metres; each argument (3,) float64.

    The closest points lie in the interior of both lines or at an end of one: both are tried. Written in scalars: an
    array for every difference would cost more than all the rest.
    """
    aa = bb = ab = aw = bw = ww = 0.0
    for axis in range(3):
        da, db, w = a1[axis] - a0[axis], b1[axis] - b0[axis], a0[axis] - b0[axis]
        aa, bb, ab = aa + da * da, bb + db * db, ab + da * db
        aw, bw, ww = aw + da * w, bw + db * w, ww + w * w
    best_s, best_t, best = 0.0, 0.0, math.inf
    determinant = aa * bb - ab * ab
    if determinant > 1e-12 * max(aa * bb, 1e-300):
        s = (ab * bw - bb * aw) / determinant
        t = (aa * bw - ab * aw) / determinant
        if 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0:
            best_s, best_t, best = s, t, _squared_gap(aa, bb, ab, aw, bw, ww, s, t)
    for end in (0.0, 1.0):
        s = 0.0 if aa == 0.0 else min(max((end * ab - aw) / aa, 0.0), 1.0)
        gap = _squared_gap(aa, bb, ab, aw, bw, ww, s, end)
        if gap < best:
            best_s, best_t, best = s, end, gap
        t = 0.0 if bb == 0.0 else min(max((end * ab + bw) / bb, 0.0), 1.0)
        gap = _squared_gap(aa, bb, ab, aw, bw, ww, end, t)
        if gap < best:
            best_s, best_t, best = end, t, gap
    squared = 0.0
    for axis in range(3):  # from the points themselves: the expanded square is not exact for segments that meet
        apart = a0[axis] - b0[axis] + best_s * (a1[axis] - a0[axis]) - best_t * (b1[axis] - b0[axis])
        squared += apart * apart
    return math.sqrt(squared)


@compiled
def least_distance_m(separation: float, now: float) -> float:
    """How near one may come: the separation, or no nearer than one is already but for what positions waver."""
    return separation if now >= separation else now - WAVER_M


@compiled
def come_too_near(
    start: FloatArray, ends: FloatArray, rival_starts: FloatArray, rival_ends: FloatArray, separation: float
) -> BoolArray:
    """Tell which legs come too near to a rival's leg or to where it is, and nearer than their start is already.

    Parameters
    ----------
    start : (3,) float64; ends : (N, 3) float64, ENU metres.
    rival_starts, rival_ends : (M, 3) float64, where each rival is and where its leg ends.
    separation : metres.

    Returns
    -------
    (N,) bool.
    """
    near = np.zeros(len(ends), dtype=np.bool_)
    longest = 0.0
    for index in range(len(ends)):
        longest = max(longest, _apart(start, ends[index]))
    for rival in range(len(rival_starts)):
        away = squared_leg = 0.0  # in scalars: most rivals are far away
        for axis in range(3):
            away += (rival_starts[rival, axis] - start[axis]) ** 2
            squared_leg += (rival_ends[rival, axis] - rival_starts[rival, axis]) ** 2
        if math.sqrt(away) > separation + longest + math.sqrt(squared_leg):
            continue
        place, leg_end = rival_starts[rival], rival_ends[rival]
        to_leg = segment_distance_m(start, start, place, leg_end)
        if to_leg > separation + longest:  # nor is where it is any nearer than its leg
            continue
        to_place = segment_distance_m(start, start, place, place)
        for index in range(len(ends)):
            if near[index]:
                continue
            apart = segment_distance_m(start, ends[index], place, leg_end)
            near[index] = apart < least_distance_m(separation, to_leg)
            if not near[index]:
                apart = segment_distance_m(start, ends[index], place, place)
                near[index] = apart < least_distance_m(separation, to_place)
    return near
