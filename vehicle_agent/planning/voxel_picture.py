"""What a voxel map shows at one moment: where to fly, what is still to be looked at, and how likely that is surface.

Surface is mostly flat: an unknown voxel that touches known surface and shows one face to known air is nearly always
surface too, one that shows several faces and touches none hardly ever, and the ground is there everywhere. Measured in
drawn towns, the shares are those of `SURE` to `HARDLY`. And nothing floats: what hangs in known air and touches neither
the ground nor anything known is a shadow that nobody need look into.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.ndimage import label

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.voxel_evidence import ByteArray
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.domain.voxel_paths import with_clearance
from vehicle_agent.domain.voxels import FREE, OCCUPIED, UNKNOWN

SURE, LIKELY, MAYBE, HARDLY = 1.0, 0.55, 0.12, 0.005
"""Chance that a frontier voxel is surface: it continues what is known; it is beside that; it shows one face; else."""


@dataclass(frozen=True, slots=True)
class VoxelPicture:
    """What a map shows at one moment, shared by all who decide on it.

    Attributes
    ----------
    states : (U, V, W) uint8.
    passable : (U, V, W) bool, known free with clearance and not above the ceiling.
    frontier : (U, V, W) bool, unknown, not above the ceiling, known free beside it or above it (rays never rise), and
        not floating.
    worth : (U, V, W) float32, chance that a frontier voxel is surface; 0 elsewhere.
    ceiling : highest layer in which vehicles fly; what is above is known to be clear.
    """

    states: ByteArray
    passable: BoolArray
    frontier: BoolArray
    worth: npt.NDArray[np.float32]
    ceiling: int

    @classmethod
    def of(cls, states: ByteArray, ceiling: int) -> VoxelPicture:
        free = states == FREE
        beside = np.zeros(states.shape, dtype=np.bool_)
        beside[:, :, :-1] |= free[:, :, 1:]
        for axis in range(2):
            out, line = np.moveaxis(beside, axis, 0), np.moveaxis(free, axis, 0)
            out[1:] |= line[:-1]
            out[:-1] |= line[1:]
        frontier = (states == UNKNOWN) & beside
        frontier[:, :, ceiling + 1 :] = False
        frontier &= ~_floating(states, ceiling)
        worth = _worth(states == OCCUPIED, free, frontier)
        free[:, :, ceiling + 1 :] = True
        passable = with_clearance(free)
        passable[:, :, ceiling + 1 :] = False
        return cls(states, passable, frontier, worth, ceiling)


def _floating(states: ByteArray, ceiling: int) -> BoolArray:
    """Unknown voxels that known air parts, all around, from the ground and from known surface: (U, V, W) bool."""
    filled = states != FREE
    filled[:, :, ceiling + 1 :] = False
    regions, count = label(filled, np.ones((3, 3, 3), dtype=np.bool_))
    stands = np.zeros(count + 1, dtype=np.bool_)
    stands[0] = True
    stands[regions[:, :, 0]] = True
    stands[regions[states == OCCUPIED]] = True
    floating: BoolArray = ~stands[regions]
    return floating


def _worth(occupied: BoolArray, free: BoolArray, frontier: BoolArray) -> npt.NDArray[np.float32]:
    """How likely each frontier voxel is surface: (U, V, W) float32."""
    places = np.argwhere(frontier)
    worth = np.zeros(frontier.shape, dtype=np.float32)
    if len(places) == 0:
        return worth
    air, wall = np.pad(free, 1), np.pad(occupied, 1)
    faces, touches = np.zeros(len(places), dtype=np.int64), np.zeros(len(places), dtype=np.bool_)
    near = np.zeros(len(places), dtype=np.bool_)
    for offset in np.ndindex(3, 3, 3):
        beside = tuple((places + offset).T)
        if np.abs(np.subtract(offset, 1)).sum() == 1:
            faces += air[beside]
            touches |= wall[beside]
        near |= wall[beside]
    chance = np.where(faces == 1, MAYBE, HARDLY)
    chance[near & (faces == 1)] = LIKELY
    chance[touches & (faces <= 2)] = SURE
    chance[places[:, 2] == 0] = SURE  # the ground
    worth[frontier] = chance
    return worth


def without_traffic(
    passable: BoolArray, grid: VoxelGrid, legs: Sequence[tuple[Point, Point]], here_enu_m: Point | None, keep_m: float
) -> BoolArray:
    """Passable voxels that keep a distance from straight legs; nearer ones as far as they are no nearer than `here`.

    `legs` are (start, end) pairs in ENU metres; a vehicle that stays is a leg without length.
    """
    result = passable.copy()
    for start_enu_m, end_enu_m in legs:
        start, end = np.array(start_enu_m), np.array(end_enu_m)
        least_m = keep_m
        if here_enu_m is not None:
            least_m = min(keep_m, float(_distance_to_leg_m(np.array([here_enu_m]), start, end)[0]) - 0.1)
        lowest = np.minimum(start, end) - keep_m - grid.corner_enu_m
        highest = np.maximum(start, end) + keep_m - grid.corner_enu_m
        low = np.clip(np.floor(lowest / grid.voxel_m).astype(int), 0, grid.shape)
        high = np.clip(np.floor(highest / grid.voxel_m).astype(int) + 1, 0, grid.shape)
        if least_m <= 0.0 or (high <= low).any():
            continue
        box = tuple(slice(first, last) for first, last in zip(low, high, strict=True))
        around = np.stack(np.meshgrid(*(np.arange(b.start, b.stop) for b in box), indexing="ij"), axis=-1)
        centres = grid.corner_enu_m + (around + 0.5) * grid.voxel_m
        away = _distance_to_leg_m(centres.reshape(-1, 3), start, end).reshape(around.shape[:3])
        result[box] &= away >= least_m
    return result


def _distance_to_leg_m(points: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """(N, 3) -> (N,) float64, metres."""
    along = end - start
    squared = float(along @ along)
    shares = np.clip((points - start) @ along / squared, 0.0, 1.0) if squared > 0.0 else np.zeros(len(points))
    away: FloatArray = np.linalg.norm(points - start - shares[:, None] * along, axis=1)
    return away
