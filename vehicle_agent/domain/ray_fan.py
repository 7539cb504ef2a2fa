"""A down-looking half-sphere of rays, and what it meets among voxels (the sensor of Renzaglia 2020, section 7.1).

A sensor in the middle of a voxel sends one ray to the middle of every voxel that is within range and not above it. All
such sensors have the same rays, so the voxels along each ray are computed once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.voxel_evidence import ByteArray
from vehicle_agent.domain.voxels import FREE, OCCUPIED, UNKNOWN

StepArray = npt.NDArray[np.int16]
AIM = (0.0171, 0.0133, -0.0119)
"""Rays aim this much beside a voxel's middle, in voxels, so that none runs exactly along edges."""


@dataclass(frozen=True, slots=True)
class Crossings:
    """Which rays of a fan pass the voxel at a displacement from the sensor.

    Attributes
    ----------
    firsts : (2 reach + 1, 2 reach + 1, reach + 1) int64 and one more: displacement (du, dv, -dw), flattened, has the
        entries firsts[d] to firsts[d + 1] - 1.
    rays : (S,) int32, the ray of each entry; steps : (S,) int64, at which of its steps.
    """

    firsts: IndexArray
    rays: npt.NDArray[np.int32]
    steps: IndexArray


@dataclass(frozen=True, slots=True)
class RayFan:
    """Rays from the middle of a voxel.

    Attributes
    ----------
    reach : whole voxels of range.
    targets : (R, 3) int16, voxels that the rays aim at, relative to the sensor's.
    steps : (S, 3) int16, voxels along all rays, the sensor's own left out, relative to it.
    middles : (S,) float32, place on its ray (0 at the sensor, 1 at the target) half-way through each voxel.
    firsts : (R + 1,) int64, ray r has steps firsts[r] to firsts[r + 1] - 1.
    ray_to : (2 reach + 1, 2 reach + 1, reach + 1) int32, the ray that aims at (du, dv, -dw), or -1.
    crossings : rays that pass a displacement, see `Crossings`.
    """

    reach: int
    targets: StepArray
    steps: StepArray
    middles: npt.NDArray[np.float32]
    firsts: IndexArray
    ray_to: npt.NDArray[np.int32]
    crossings: Crossings

    @property
    def aims(self) -> FloatArray:
        """Where the rays end that meet nothing, from the sensor: (R, 3) float64, voxels."""
        aims: FloatArray = self.targets + np.array(AIM)
        return aims

    def ends(self, centre: FloatArray, last_steps: IndexArray, voxel_m: float) -> FloatArray:
        """Points in which rays from a sensor at `centre` end that end at these steps: (R, 3) float64, metres."""
        aims = self.targets + np.array(AIM)
        ends: FloatArray = centre + voxel_m * aims * self.middles[last_steps][:, None]
        return ends


@lru_cache(maxsize=8)
def down_looking_fan(range_voxels: float) -> RayFan:
    """Build the rays of a sensor that sees so many voxels far."""
    reach = math.floor(range_voxels)
    span = np.arange(-reach, reach + 1)
    around = np.stack(np.meshgrid(span, span, np.arange(-reach, 1), indexing="ij"), axis=-1).reshape(-1, 3)
    squared = (around**2).sum(axis=1)
    targets = around[(squared <= range_voxels**2) & (squared > 0)].astype(np.int16)
    steps, middles, firsts = _steps_along(targets, np.array(AIM))
    ray_to = np.full((2 * reach + 1, 2 * reach + 1, reach + 1), -1, dtype=np.int32)
    ray_to[targets[:, 0] + reach, targets[:, 1] + reach, -targets[:, 2]] = np.arange(len(targets))
    side = 2 * reach + 1
    at = steps.astype(np.int64)
    displacements = ((at[:, 0] + reach) * side + at[:, 1] + reach) * (reach + 1) - at[:, 2]
    order = np.argsort(displacements, kind="stable")
    crossings = Crossings(
        np.searchsorted(displacements[order], np.arange(side * side * (reach + 1) + 1)).astype(np.int64),
        np.repeat(np.arange(len(targets), dtype=np.int32), np.diff(firsts))[order],
        order.astype(np.int64),
    )
    return RayFan(reach, targets, steps, middles, firsts, ray_to, crossings)


@compiled
def _steps_along(targets: StepArray, aim: FloatArray) -> tuple[StepArray, npt.NDArray[np.float32], IndexArray]:
    total = 0
    for ray in range(len(targets)):
        total += abs(targets[ray, 0]) + abs(targets[ray, 1]) + abs(targets[ray, 2])
    steps = np.empty((total, 3), dtype=np.int16)
    middles = np.empty(total, dtype=np.float32)
    firsts = np.zeros(len(targets) + 1, dtype=np.int64)
    count = 0
    at, left, nearest, between = np.zeros(3, np.int64), np.zeros(3, np.int64), np.zeros(3), np.zeros(3)
    for ray in range(len(targets)):
        for axis in range(3):
            change = targets[ray, axis] + aim[axis]
            at[axis], left[axis] = 0, abs(targets[ray, axis])
            between[axis] = 1.0 / abs(change)
            nearest[axis] = 0.5 * between[axis] if left[axis] > 0 else math.inf
        while left.sum() > 0:
            axis = int(np.argmin(nearest))
            entered = nearest[axis]
            at[axis] += 1 if targets[ray, axis] > 0 else -1
            left[axis] -= 1
            nearest[axis] = nearest[axis] + between[axis] if left[axis] > 0 else math.inf
            for a in range(3):
                steps[count, a] = at[a]
            middles[count] = 0.5 * (entered + min(nearest.min(), 1.0))
            count += 1
        firsts[ray + 1] = count
    return steps, middles, firsts


@compiled
def rays_until(
    solid: BoolArray, steps: StepArray, firsts: IndexArray, u: int, v: int, w: int
) -> tuple[IndexArray, BoolArray, BoolArray]:
    """Follow all rays from a voxel until something solid.

    Returns
    -------
    The last step of each ray, whether it met something there, and whether it counts: a ray that leaves the grid at once
    does not.
    """
    rays = len(firsts) - 1
    last, met, counts = np.zeros(rays, np.int64), np.zeros(rays, np.bool_), np.zeros(rays, np.bool_)
    columns, rows, layers = solid.shape
    for ray in range(rays):
        for step in range(firsts[ray], firsts[ray + 1]):
            a, b, c = u + steps[step, 0], v + steps[step, 1], w + steps[step, 2]
            if a < 0 or b < 0 or c < 0 or a >= columns or b >= rows or c >= layers:
                break
            last[ray], counts[ray] = step, True
            if solid[a, b, c]:
                met[ray] = True
                break
    return last, met, counts


@compiled
def sees_first(states: ByteArray, steps: StepArray, firsts: IndexArray, ray: int, u: int, v: int, w: int) -> bool:
    """Tell whether a ray from a voxel passes known free voxels only, up to its target, whatever that is."""
    for step in range(firsts[ray], firsts[ray + 1] - 1):
        if states[u + steps[step, 0], v + steps[step, 1], w + steps[step, 2]] != FREE:
            return False
    return True


@compiled
def count_seen(
    states: ByteArray, steps: StepArray, firsts: IndexArray, ray_to: npt.NDArray[np.int32],
    places: IndexArray, wanted: IndexArray, weights: FloatArray, enough: float,
) -> FloatArray:  # fmt: skip
    """Weight of those among some voxels that would be seen for sure from each of some places: (P,) float64.

    Parameters
    ----------
    places : (P, 3) and wanted : (W, 3) int64 voxels, both inside the grid.
    weights : (W,) float64.
    enough : count no further than this.
    """
    reach = ray_to.shape[2] - 1
    seen = np.zeros(len(places))
    for place in range(len(places)):
        u, v, w = places[place]
        for index in range(len(wanted)):
            du, dv, dw = wanted[index, 0] - u, wanted[index, 1] - v, w - wanted[index, 2]
            if dw < 0 or dw > reach or abs(du) > reach or abs(dv) > reach:
                continue
            ray = ray_to[du + reach, dv + reach, dw]
            if ray >= 0 and sees_first(states, steps, firsts, ray, u, v, w):
                seen[place] += weights[index]
                if seen[place] >= enough:
                    break
    return seen


@compiled
def first_with_view(
    states: ByteArray, steps: StepArray, firsts: IndexArray, reach: int, crossing_firsts: IndexArray,
    crossing_rays: npt.NDArray[np.int32], crossing_steps: IndexArray, places: IndexArray, wanted: IndexArray,
) -> tuple[int, int]:  # fmt: skip
    """First place and wanted voxel such that some ray passes known free voxels only before it gets there; or (-1, -1).

    Other than `count_seen` it takes rays that aim at something beyond or beside the voxel too.
    """
    side = 2 * reach + 1
    for place in range(len(places)):
        u, v, w = places[place]
        for index in range(len(wanted)):
            du, dv, dw = wanted[index, 0] - u, wanted[index, 1] - v, w - wanted[index, 2]
            if dw < 0 or dw > reach or abs(du) > reach or abs(dv) > reach:
                continue
            at = ((du + reach) * side + dv + reach) * (reach + 1) + dw
            for entry in range(crossing_firsts[at], crossing_firsts[at + 1]):
                clear = True
                for step in range(firsts[crossing_rays[entry]], crossing_steps[entry]):
                    if states[u + steps[step, 0], v + steps[step, 1], w + steps[step, 2]] != FREE:
                        clear = False
                        break
                if clear:
                    return place, index
    return -1, -1


@compiled
def unknown_met(
    states: ByteArray, steps: StepArray, firsts: IndexArray, places: IndexArray, stride: int, above_ground: float
) -> FloatArray:
    """Surface expected where rays from some places aim at unknown voxels before something occupied: (P,) float64.

    Every `stride`-th ray counts: 1 when it aims at the lowest layer, which is ground, else `above_ground`.
    """
    columns, rows, layers = states.shape
    met = np.zeros(len(places))
    for place in range(len(places)):
        u, v, w = places[place]
        for ray in range(place % stride, len(firsts) - 1, stride):
            for step in range(firsts[ray], firsts[ray + 1]):
                a, b, c = u + steps[step, 0], v + steps[step, 1], w + steps[step, 2]
                if a < 0 or b < 0 or c < 0 or a >= columns or b >= rows or c >= layers:
                    break
                state = states[a, b, c]
                if state == OCCUPIED:
                    break
                if state == UNKNOWN and step == firsts[ray + 1] - 1:
                    met[place] += 1.0 if c == 0 else above_ground
    return met
