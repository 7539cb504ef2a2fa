"""Parallel lines over a rectangle, as surveyors have always sailed them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray


@dataclass(frozen=True, slots=True)
class Box:
    """A rectangle along the axes, ENU metres."""

    west_m: float
    south_m: float
    east_m: float
    north_m: float

    @property
    def area_m2(self) -> float:
        return (self.east_m - self.west_m) * (self.north_m - self.south_m)

    def lane(self, number: int, lanes: int) -> Box:
        """One of equal strips, side by side from west to east."""
        width_m = (self.east_m - self.west_m) / lanes
        return Box(self.west_m + number * width_m, self.south_m, self.west_m + (number + 1) * width_m, self.north_m)


def parallel_lines(box: Box, spacing_m: float, inset_m: float, start_en_m: tuple[float, float]) -> FloatArray:
    """Corners of a way to and fro along the box's longer side, begun at the corner nearest to a start: (2 K, 2) ENU.

    Lines are `spacing_m` apart at most, half that from the sides, and end `inset_m` before the box does.
    """
    width_m, height_m = box.east_m - box.west_m, box.north_m - box.south_m
    upright = height_m >= width_m
    across_m, along_m = (width_m, height_m) if upright else (height_m, width_m)
    count = max(1, math.ceil(across_m / spacing_m - 1e-9))
    offsets = (np.arange(count) + 0.5) * across_m / count
    inset_m = min(inset_m, along_m / 2.0)
    corners = np.empty((2 * count, 2))
    corners[:, 0] = np.repeat(offsets, 2)
    corners[:, 1] = np.tile([inset_m, along_m - inset_m, along_m - inset_m, inset_m], count)[: 2 * count]
    low = np.array([box.west_m, box.south_m])
    candidates = []
    for first_last in (False, True):
        for far_end_first in (False, True):
            way = corners.copy()
            if first_last:
                way[:, 0] = across_m - way[:, 0]
            if far_end_first:
                way[:, 1] = along_m - way[:, 1]
            candidates.append(low + (way if upright else way[:, ::-1]))
    return min(candidates, key=lambda way: math.dist(way[0], start_en_m))


def points_along(corners_en_m: FloatArray, step_m: float) -> FloatArray:
    """Places every `step_m` along a way, its start left out: (K, 2) -> (M, 2)."""
    lengths = np.hypot(*np.diff(corners_en_m, axis=0).T)
    gone = np.concatenate(([0.0], np.cumsum(lengths)))
    at = np.arange(step_m, gone[-1] + 1e-9, step_m)
    return np.column_stack([np.interp(at, gone, corners_en_m[:, axis]) for axis in (0, 1)])


def corners_of(track_en_m: FloatArray, within_m: float) -> FloatArray:
    """The fewest places of a track, its ends among them, between which straight legs pass all others within a distance.

    (K, 2) -> (C, 2); Douglas and Peucker 1973.
    """
    if len(track_en_m) < 3:
        return track_en_m
    first, last = track_en_m[0], track_en_m[-1]
    along = last - first
    squared = max(float(along @ along), 1e-12)
    shares = np.clip((track_en_m - first) @ along / squared, 0.0, 1.0)
    beside_m = np.hypot(*(track_en_m - first - shares[:, None] * along).T)
    farthest = int(np.argmax(beside_m))
    if beside_m[farthest] <= within_m:
        return np.stack((first, last))
    before, after = corners_of(track_en_m[: farthest + 1], within_m), corners_of(track_en_m[farthest:], within_m)
    return np.concatenate((before[:-1], after))
