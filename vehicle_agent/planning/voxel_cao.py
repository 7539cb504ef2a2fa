"""CAO among buildings (Renzaglia 2020, sections 3 and 4): every vehicle climbs its share of the faces in sight."""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.ray_fan import RayFan
from vehicle_agent.domain.voxel_evidence import ByteArray
from vehicle_agent.domain.voxel_faces import seen_faces
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.domain.voxels import OCCUPIED
from vehicle_agent.planning.cao import Cao, CaoParams
from vehicle_agent.planning.coverage import StepSchedule
from vehicle_agent.planning.interface import Wait
from vehicle_agent.planning.voxel_explorer import VoxelRoute
from vehicle_agent.planning.voxel_situation import VoxelSituation

FACE_BITS = 5


def face_share(own: ByteArray, teammates: list[ByteArray]) -> float:
    """J_C of one vehicle (eq. 1): the faces that it sees, each divided by the number of vehicles that see it.

    Parameters
    ----------
    own, teammates : (U, V, W) uint8 each, faces as bits.
    """
    share = 0.0
    where = own != 0
    for bit in range(FACE_BITS):
        mine = own[where] & (1 << bit) != 0
        watchers = np.ones(len(mine), dtype=np.int64)
        for view in teammates:
            watchers += view[where] & (1 << bit) != 0
        share += float((1.0 / watchers[mine]).sum())
    return share


class VoxelCao:
    """One vehicle's optimiser; its places are the middles of voxels, and its step no shorter than one.

    Attributes
    ----------
    station_enu_m
        None: it claims nothing.
    revises_under_way
        False: it decides where it has measured.
    """

    station_enu_m: Point | None = None
    revises_under_way = False

    def __init__(self, grid: VoxelGrid, fan: RayFan, step_m: float, rng: np.random.Generator) -> None:
        self._grid, self._fan = grid, fan
        self._cao, self._schedule = Cao(CaoParams(step_m), rng), StepSchedule(step_m)
        self._decisions = 0

    def ask(self, situation: VoxelSituation) -> VoxelRoute | Wait:
        """Measure J_C here by the team's map, and say where it promises most."""
        picture, here = situation.picture, situation.position_enu_m
        solid = (picture.states == OCCUPIED) & situation.wanted[:, :, None]
        places = [here, *(mate.position_enu_m for mate in situation.teammates)]
        voxels = np.array([[self._grid.clamped(self._grid.voxel_of(place))] for place in places], dtype=np.int64)
        own, *others = (seen_faces(solid, self._fan, voxel) for voxel in voxels)
        self._cao.tell(here, face_share(own, others))
        step_m = max(self._grid.voxel_m, self._schedule.step_m(self._decisions))
        self._decisions += 1
        open_air = picture.passable & situation.allowed[:, :, None]
        end = self._cao.ask(here, lambda ends: self._are_open(open_air, ends), step_m)
        if end is None:
            return Wait("no admissible perturbation")
        way = [self._grid.flat_of(self._grid.clamped(self._grid.voxel_of(place))) for place in (here, end)]
        return VoxelRoute(np.array(way, dtype=np.int64), f"local optimum of what was measured, step {step_m:.1f} m")

    def _are_open(self, open_air: BoolArray, ends_enu_m: FloatArray) -> BoolArray:
        """Which places lie in voxels where the vehicle may be: (M, 3) -> (M,) bool."""
        voxels = np.floor((ends_enu_m - self._grid.corner_enu_m) / self._grid.voxel_m).astype(np.int64)
        inside = ((voxels >= 0) & (voxels < np.array(self._grid.shape))).all(axis=1)
        voxels[~inside] = 0
        may_be: BoolArray = inside & open_air[tuple(voxels.T)]
        return may_be
