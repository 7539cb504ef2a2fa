"""A short leg out of the way of teammates that must pass where a vehicle rests."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point, as_array
from vehicle_agent.domain.segments import segment_distance_m
from vehicle_agent.planning.constraints import Constraints, Reservation

DIRECTIONS = 16
AWAY = (0.6, 1.1, 1.6, 2.2, 4.0)
"""Horizontal distances that are tried, in separations."""
LIFTS = (0.0, 0.25, 0.5, 1.0)
"""Climbs that are tried, as shares of the height band."""
LEAST_GAIN_M = 1.0
"""A leg that leads no further out is not worth flying."""


def way_aside(here_enu_m: Point, passages: Sequence[Reservation], constraints: Constraints) -> Point | None:
    """End of the shortest admissible leg that keeps the separation from all passages, else of the one that leads
    furthest out; None when none leads further out than here.
    """
    ends = _places_around(here_enu_m, constraints)
    ends = ends[constraints.admissible(here_enu_m, ends)]
    if len(ends) == 0:
        return None
    room_m = np.minimum([_room_m(end, passages) for end in ends], constraints.separation_m)
    if room_m.max() < min(_room_m(as_array(here_enu_m), passages) + LEAST_GAIN_M, constraints.separation_m):
        return None
    away_m = np.linalg.norm(ends - as_array(here_enu_m), axis=1)
    east_m, north_m, up_m = ends[np.lexsort((away_m, -room_m))[0]].tolist()
    return (east_m, north_m, up_m)


def _room_m(place: FloatArray, passages: Sequence[Reservation]) -> float:
    """Distance of a place from the nearest passage."""
    return min(segment_distance_m(place, place, as_array(p.start_enu_m), as_array(p.end_enu_m)) for p in passages)


def _places_around(here_enu_m: Point, constraints: Constraints) -> FloatArray:
    """Level and higher places in all directions, moved into the height band: (M, 3) float64."""
    angles = np.arange(DIRECTIONS) * (2.0 * math.pi / DIRECTIONS)
    away_m = np.minimum(np.array(AWAY) * constraints.separation_m, constraints.reach_m)
    lifts_m = np.array(LIFTS) * (constraints.max_above_m - constraints.min_above_m)
    angle, away, lift = (axis.ravel() for axis in np.meshgrid(angles, away_m, lifts_m, indexing="ij"))
    ends: FloatArray = np.column_stack((away * np.cos(angle), away * np.sin(angle), lift)) + as_array(here_enu_m)
    ground_m = constraints.grounds_m(ends)
    ends[:, 2] = ends[:, 2].clip(ground_m + constraints.min_above_m, ground_m + constraints.max_above_m)
    return ends[~np.isnan(ground_m)]
