"""Compiled kernels of the mapping bench: what vehicles at trial positions would see, and where they may be."""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray

_LIFT = 1e-3
"""A landmark is looked at so much above the surface that the surface's own kinks do not hide it."""


@compiled
def surface_at(elevation: FloatArray, x: float, y: float) -> float:
    """Height of a surface over [-1, 1] x [-1, 1], (columns, rows) of cell centres joined bilinearly."""
    columns, rows = elevation.shape
    u = min(max((x + 1.0) * 0.5 * columns - 0.5, 0.0), columns - 1.0)
    v = min(max((y + 1.0) * 0.5 * rows - 0.5, 0.0), rows - 1.0)
    i, j = min(int(u), columns - 2), min(int(v), rows - 2)
    p, q = u - i, v - j
    south = (1.0 - p) * elevation[i, j] + p * elevation[i + 1, j]
    north = (1.0 - p) * elevation[i, j + 1] + p * elevation[i + 1, j + 1]
    return float((1.0 - q) * south + q * north)


@compiled
def _is_clear(elevation: FloatArray, u0: float, v0: float, z0: float, u1: float, v1: float, z1: float) -> bool:
    """Whether the line between two points (in cells) stays above the surface where it crosses its lines."""
    columns, rows = elevation.shape
    du, dv, dz = u1 - u0, v1 - v0, z1 - z0
    along = abs(du) >= abs(dv)
    start, way = (u0, du) if along else (v0, dv)
    if way == 0.0:
        return True
    low, high = min(start, start + way), max(start, start + way)
    for line in range(max(math.floor(low) + 1, 0), min(math.ceil(high) - 1, (columns if along else rows) - 1) + 1):
        part = (line - start) / way
        across = min(max(v0 + part * dv if along else u0 + part * du, 0.0), (rows if along else columns) - 1.0)
        first = min(int(across), (rows if along else columns) - 2)
        rest = across - first
        if along:
            ground = (1.0 - rest) * elevation[line, first] + rest * elevation[line, first + 1]
        else:
            ground = (1.0 - rest) * elevation[first, line] + rest * elevation[first + 1, line]
        if ground > z0 + part * dz:
            return False
    return True


@compiled
def surface_heights(elevation: FloatArray, places: FloatArray) -> FloatArray:
    """Heights under places: (N, 2) -> (N,)."""
    heights = np.empty(len(places))
    for index in range(len(places)):
        heights[index] = surface_at(elevation, places[index, 0], places[index, 1])
    return heights


@compiled
def look(
    elevation: FloatArray, shape: IndexArray, heights: FloatArray, eye: FloatArray, reach: float, skip: BoolArray,
    ids: IndexArray, ranges: FloatArray,
) -> int:  # fmt: skip
    """Landmarks that an eye sees (definition 1) but those to skip, in order of their ids; how many were written.

    Landmarks form a lattice of shape[0] x shape[1] cell centres over [-1, 1] x [-1, 1].
    """
    columns, rows = elevation.shape
    wide, long = shape[0], shape[1]
    dx, dy = 2.0 / wide, 2.0 / long
    low_i, high_i = (
        max(0, math.ceil((eye[0] - reach + 1.0) / dx - 0.5)),
        min(wide - 1, math.floor((eye[0] + reach + 1.0) / dx - 0.5)),
    )
    low_j, high_j = (
        max(0, math.ceil((eye[1] - reach + 1.0) / dy - 0.5)),
        min(long - 1, math.floor((eye[1] + reach + 1.0) / dy - 0.5)),
    )
    u0, v0 = (eye[0] + 1.0) * 0.5 * columns - 0.5, (eye[1] + 1.0) * 0.5 * rows - 0.5
    count = 0
    for i in range(low_i, high_i + 1):
        for j in range(low_j, high_j + 1):
            landmark = i * long + j
            if skip[landmark]:
                continue
            x, y, z = -1.0 + (i + 0.5) * dx, -1.0 + (j + 0.5) * dy, heights[landmark]
            squared = (x - eye[0]) ** 2 + (y - eye[1]) ** 2 + (z - eye[2]) ** 2
            if squared >= reach * reach:
                continue
            u, v = (x + 1.0) * 0.5 * columns - 0.5, (y + 1.0) * 0.5 * rows - 0.5
            if _is_clear(elevation, u0, v0, eye[2], u, v, z + _LIFT):
                ids[count] = landmark
                ranges[count] = math.sqrt(squared)
                count += 1
    return count


@compiled
def try_out(
    elevation: FloatArray, shape: IndexArray, heights: FloatArray, reach: float, precision: float, best: float,
    information: FloatArray, done: BoolArray, positions: FloatArray, near: IndexArray, far: IndexArray,
    supposed: FloatArray, visible_counts: IndexArray,
) -> tuple[int, float, float]:  # fmt: skip
    """What a team would gain by really moving to positions (OSARSES, algorithm 1): the parts of eq. 8, 10, 12, 14.

    Parameters
    ----------
    precision : accurate standard deviation over the sensor's share of noise; best : most that one measurement tells.
    information : (vehicles, N), what each vehicle's map has of each landmark (1 is accurate).
    done : (N,), accurate or given up in anybody's map.
    near, far, supposed : ids of the landmarks of J2 and J3, and (N, 3) where landmarks are supposed.
    visible_counts : (vehicles,), receives the sizes of B^{L,j}.

    Returns
    -------
    Landmarks newly accurate; sums of least squared distances over `near` and over `far`.
    """
    count, vehicles = len(heights), len(positions)
    sealed = np.zeros(count, dtype=np.bool_)
    ids, ranges = np.empty((vehicles, count), dtype=np.int64), np.empty(count)
    seen = np.zeros(vehicles, dtype=np.int64)
    fresh = 0
    for j in range(vehicles):
        seen[j] = look(elevation, shape, heights, positions[j], reach, done, ids[j], ranges)
        for k in range(seen[j]):
            landmark = ids[j, k]
            drop = max(positions[j, 2] - heights[landmark], 0.0)
            gain = min((precision * drop / (ranges[k] * ranges[k])) ** 2, best)
            if not sealed[landmark] and information[j, landmark] + gain >= 1.0:
                sealed[landmark] = True
                fresh += 1
    for j in range(vehicles):
        visible_counts[j] = 0
        for k in range(seen[j]):
            landmark = ids[j, k]
            if not sealed[landmark]:
                visible_counts[j] += 1
    return fresh, nearest_sum(near, supposed, positions), nearest_sum(far, supposed, positions)


@compiled
def nearest_sum(landmarks: IndexArray, supposed: FloatArray, positions: FloatArray) -> float:
    """Sum of the squared distances of landmarks to the vehicle nearest to each."""
    total = 0.0
    for k in range(len(landmarks)):
        place = supposed[landmarks[k]]
        nearest = math.inf
        for j in range(len(positions)):
            squared = (
                (place[0] - positions[j, 0]) ** 2
                + (place[1] - positions[j, 1]) ** 2
                + (place[2] - positions[j, 2]) ** 2
            )
            nearest = min(nearest, squared)
        total += nearest
    return total


@compiled
def allowed(elevation: FloatArray, clearance: float, ceiling: float, positions: FloatArray) -> BoolArray:
    """Which positions keep to the area and the height band: (N, 3) -> (N,)."""
    good = np.zeros(len(positions), dtype=np.bool_)
    for index in range(len(positions)):
        x, y, z = positions[index]
        if abs(x) <= 1.0 and abs(y) <= 1.0 and z <= ceiling:
            good[index] = z >= surface_at(elevation, x, y) + clearance - 1e-9
    return good


@compiled
def all_linked(teams: FloatArray, radio: float, alone: BoolArray, present: BoolArray) -> BoolArray:
    """`linked` for many configurations: (M, vehicles, 3) -> (M,)."""
    good = np.empty(len(teams), dtype=np.bool_)
    for index in range(len(teams)):
        good[index] = linked(teams[index], radio, alone, present)
    return good


@compiled
def linked(positions: FloatArray, radio: float, alone: BoolArray, present: BoolArray) -> bool:
    """Whether everybody present has somebody within radio range, those that had nobody (`alone`) apart."""
    for i in range(len(positions)):
        if not present[i] or alone[i]:
            continue
        heard = False
        for j in range(len(positions)):
            if i != j and present[j]:
                squared = (
                    (positions[i, 0] - positions[j, 0]) ** 2
                    + (positions[i, 1] - positions[j, 1]) ** 2
                    + (positions[i, 2] - positions[j, 2]) ** 2
                )
                if squared <= radio * radio:
                    heard = True
                    break
        if not heard:
            return False
    return True
