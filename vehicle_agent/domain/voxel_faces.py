"""Faces of voxels: which of a town's walls, roofs and grounds places see, and which place sees most that is new.

A ray sees the face through which it enters the first solid voxel. Rays never rise, so that undersides are never seen.
Faces of a voxel are bits of one byte.
"""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.ray_fan import RayFan, StepArray
from vehicle_agent.domain.voxel_evidence import ByteArray

WEST, EAST, SOUTH, NORTH, TOP = 1, 2, 4, 8, 16


def open_faces(solid: BoolArray) -> ByteArray:
    """Faces that touch air, undersides and the grid's border left out: (U, V, W) bool -> (U, V, W) uint8."""
    faces = np.zeros(solid.shape, dtype=np.uint8)
    air = ~solid
    faces[1:][air[:-1]] |= WEST
    faces[:-1][air[1:]] |= EAST
    faces[:, 1:][air[:, :-1]] |= SOUTH
    faces[:, :-1][air[:, 1:]] |= NORTH
    faces[:, :, :-1][air[:, :, 1:]] |= TOP
    faces[air] = 0
    return faces


def count_faces(faces: ByteArray) -> int:
    """How many faces there are: (U, V, W) uint8."""
    return int(np.bitwise_count(faces).sum())


def seen_faces(solid: BoolArray, fan: RayFan, places: IndexArray) -> ByteArray:
    """Faces that at least one of some places, (P, 3) int64 voxels inside the grid, sees: (U, V, W) uint8."""
    faces = np.zeros(solid.shape, dtype=np.uint8)
    mark_faces(solid, fan.steps, fan.firsts, places, faces)
    return faces


@compiled
def _face_entered(steps: StepArray, first: int, step: int) -> int:
    """The face through which a ray that begins with step `first` enters the voxel of a later step."""
    along = steps[step, 0] - (steps[step - 1, 0] if step > first else 0)
    if along != 0:
        return WEST if along > 0 else EAST
    along = steps[step, 1] - (steps[step - 1, 1] if step > first else 0)
    if along != 0:
        return SOUTH if along > 0 else NORTH
    return TOP


@compiled
def _step_to_solid(solid: BoolArray, steps: StepArray, first: int, end: int, u: int, v: int, w: int) -> int:
    """The first of a ray's steps, from `first` to before `end`, that meets something solid; -1 where none does."""
    columns, rows, layers = solid.shape
    for step in range(first, end):
        a, b, c = u + steps[step, 0], v + steps[step, 1], w + steps[step, 2]
        if a < 0 or b < 0 or c < 0 or a >= columns or b >= rows or c >= layers:
            return -1
        if solid[a, b, c]:
            return step
    return -1


@compiled
def mark_faces(solid: BoolArray, steps: StepArray, firsts: IndexArray, places: IndexArray, faces: ByteArray) -> None:
    """Add to `faces` those that a fan of rays meets from each of some places, (P, 3) int64 voxels."""
    for place in range(len(places)):
        u, v, w = places[place]
        for ray in range(len(firsts) - 1):
            step = _step_to_solid(solid, steps, firsts[ray], firsts[ray + 1], u, v, w)
            if step >= 0:
                a, b, c = u + steps[step, 0], v + steps[step, 1], w + steps[step, 2]
                faces[a, b, c] |= _face_entered(steps, firsts[ray], step)


@compiled
def best_faces(
    solid: BoolArray,
    steps: StepArray,
    firsts: IndexArray,
    places: IndexArray,
    worth: IndexArray,
    taken: ByteArray,
    bonuses: FloatArray,
) -> tuple[int, int, int]:
    """Choose the place that sees most that nobody else does, its bonus added: the first of equals.

    Parameters
    ----------
    places : (P, 3) int64 voxels, at least one.
    worth : (U, V) int64, what a face counts by its column; 0 where faces are not wanted.
    taken : (U, V, W) uint8, faces that others see.
    bonuses : (P,) float64, in the same measure.

    Returns
    -------
    the chosen place's index, the worth of the new faces that it sees, and of those that the first place sees.
    """
    counted = taken.copy()
    touched = np.empty((len(firsts) - 1, 3), dtype=np.int64)
    best, best_gain, first_gain, best_value = 0, 0, 0, -math.inf
    for place in range(len(places)):
        u, v, w = places[place]
        count, gain = 0, 0
        for ray in range(len(firsts) - 1):
            step = _step_to_solid(solid, steps, firsts[ray], firsts[ray + 1], u, v, w)
            if step < 0:
                continue
            a, b, c = u + steps[step, 0], v + steps[step, 1], w + steps[step, 2]
            face = _face_entered(steps, firsts[ray], step)
            if worth[a, b] > 0 and counted[a, b, c] & face == 0:
                counted[a, b, c] |= face
                touched[count, 0], touched[count, 1], touched[count, 2] = a, b, c
                count += 1
                gain += worth[a, b]
        for index in range(count):
            a, b, c = touched[index]
            counted[a, b, c] = taken[a, b, c]
        if place == 0:
            first_gain = gain
        if gain + bonuses[place] > best_value:
            best, best_gain, best_value = place, gain, gain + bonuses[place]
    return best, best_gain, first_gain
