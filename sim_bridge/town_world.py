"""A true town: what is solid, what a vehicle's sensor sees of it, and who touches it."""

from __future__ import annotations

import math
import zipfile
import zlib

import numpy as np
import numpy.typing as npt

from sim_bridge.town import draw_town
from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.range_image import RangeImage
from vehicle_agent.domain.ray_fan import down_looking_fan
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.mission.load import MissionError, MissionPlan
from vehicle_agent.mission.terrain import TownTerrain

TOWN_SPAWN_KEY = (1400,)
"""Key of the town's random stream: apart from those of the vehicles, which are keyed by their index."""
BODY_M = 0.3
"""Half the width of a vehicle's body, and its height."""
_CORNERS = np.array([(e, n, u) for e in (-BODY_M, BODY_M) for n in (-BODY_M, BODY_M) for u in (0.0, BODY_M)])


@compiled
def cast_rays(
    solid: BoolArray, start: FloatArray, aims: FloatArray
) -> tuple[npt.NDArray[np.float32], BoolArray]:  # fmt: skip
    """Follow rays from a place until they meet something solid or end (Amanatides and Woo 1987).

    Parameters
    ----------
    solid : (U, V, W) bool.
    start : (3,) float64, in voxels from the grid's corner.
    aims : (R, 3) float64, where rays end that meet nothing, from the start.

    Returns
    -------
    Share of each ray that was followed, (R,) float32 in (0, 1]: half-way through the voxel that it met; and whether it
    met one, (R,) bool.
    """
    columns, rows, layers = solid.shape
    shares, met = np.ones(len(aims), dtype=np.float32), np.zeros(len(aims), dtype=np.bool_)
    at, stride = np.zeros(3, np.int64), np.zeros(3, np.int64)
    following, between = np.zeros(3), np.zeros(3)
    for ray in range(len(aims)):
        for axis in range(3):
            change = aims[ray, axis]
            at[axis] = math.floor(start[axis])
            stride[axis] = 1 if change > 0.0 else -1
            if change == 0.0:
                following[axis] = between[axis] = math.inf
            else:
                border = at[axis] + 1 if change > 0.0 else at[axis]
                following[axis] = (border - start[axis]) / change
                between[axis] = 1.0 / abs(change)
        while True:
            axis = 0 if following[0] <= following[1] else 1
            axis = axis if following[axis] <= following[2] else 2
            entered = following[axis]
            if entered >= 1.0:
                break
            at[axis] += stride[axis]
            following[axis] += between[axis]
            if at[0] < 0 or at[1] < 0 or at[2] < 0 or at[0] >= columns or at[1] >= rows or at[2] >= layers:
                break
            if solid[at[0], at[1], at[2]]:
                left = min(following[0], following[1], following[2], 1.0)
                shares[ray], met[ray] = 0.5 * (entered + left), True
                break
    return shares, met


class Town:
    """The true town.

    Attributes
    ----------
    grid
        Its voxels.
    solid
        (columns, rows, layers) bool; the lowest layer is the ground.
    """

    def __init__(self, grid: VoxelGrid, solid: BoolArray) -> None:
        self.grid, self.solid = grid, np.ascontiguousarray(solid)

    @classmethod
    def of(cls, plan: MissionPlan) -> Town:
        """Build a mission's town; MissionError when it cannot be, or when a vehicle could not take off in it."""
        grid, terrain = plan.voxel_grid, plan.mission.terrain
        assert grid is not None
        assert isinstance(terrain, TownTerrain)
        if terrain.file is not None:
            solid = _read(plan, grid, terrain.file)
        else:
            rng = np.random.default_rng(np.random.SeedSequence(plan.mission.seed, spawn_key=TOWN_SPAWN_KEY))
            solid = draw_town(grid, terrain, rng)
        town = cls(grid, solid)
        town._check_starts(plan)
        return town

    def scan(self, position_enu_m: Point, range_m: float, stamp_ms: int) -> RangeImage:
        """What a half-sphere of rays at a place measures at one instant."""
        if not all(math.isfinite(coordinate) for coordinate in position_enu_m):
            raise ValueError("a sensor's position must be finite")
        voxel_m = self.grid.voxel_m
        aims = down_looking_fan(range_m / voxel_m).aims
        start = (np.array(position_enu_m) - self.grid.corner_enu_m) / voxel_m
        shares, met = cast_rays(self.solid, start, aims)
        ranges_m = shares * (voxel_m * np.linalg.norm(aims, axis=1)).astype(np.float32)
        return RangeImage(position_enu_m, ranges_m, met, stamp_ms)

    def touched_by(self, positions_enu_m: FloatArray) -> BoolArray:
        """Which bodies touch a building: (N, 3) -> (N,) bool; the ground is none."""
        corners = positions_enu_m[:, None, :] + _CORNERS
        voxels = np.floor((corners - self.grid.corner_enu_m) / self.grid.voxel_m).astype(np.int64)
        inside = ((voxels >= 0) & (voxels < np.array(self.grid.shape))).all(axis=2) & (voxels[:, :, 2] > 0)
        voxels[~inside] = 0
        touched: BoolArray = (self.solid[tuple(np.moveaxis(voxels, 2, 0))] & inside).any(axis=1)
        return touched

    def _check_starts(self, plan: MissionPlan) -> None:
        highest = int(np.flatnonzero(self.solid.any(axis=(0, 1))).max())
        for index, vehicle in enumerate(plan.mission.vehicles):
            where = f"{plan.source}: vehicles[{index}]"
            ceiling = self.grid.voxel_of((0.0, 0.0, vehicle.max_above_terrain_m))[2]
            if highest >= ceiling - 1:
                top_m = self.grid.bottom_m + (highest + 1) * self.grid.voxel_m
                raise MissionError(
                    f"{where}.max_above_terrain_m: buildings are up to {top_m:g} m high; give at least "
                    f"{top_m + 2.0 * self.grid.voxel_m:g} m, so that it can fly over them"
                )
            east_m, north_m = vehicle.start_enu_m[:2]
            column, row, _ = self.grid.voxel_of((east_m, north_m, 0.0))
            above = self.solid[max(0, column - 1) : column + 2, max(0, row - 1) : row + 2, 1:]
            if above.any():
                raise MissionError(
                    f"{where}.start_enu_m: ({east_m:g}, {north_m:g}) lies inside, under or against a building; move "
                    "the start to open ground"
                )


def _read(plan: MissionPlan, grid: VoxelGrid, file: str) -> BoolArray:
    path = plan.source.parent / file
    try:
        with np.load(path, allow_pickle=False) as content:
            solid = np.asarray(content["solid"]).astype(np.bool_)
    except FileNotFoundError:
        raise MissionError(
            f"{plan.source}: terrain.file: {path} does not exist; correct the path, which counts from the mission file"
        ) from None
    except KeyError:
        raise MissionError(f"{path}: has no array `solid`; save the town with numpy.savez(path, solid=...)") from None
    except (OSError, ValueError, EOFError, IndexError, zipfile.BadZipFile, zlib.error) as error:
        raise MissionError(f"{path}: cannot be read as a town ({error}); save it anew with numpy.savez") from None
    if solid.shape != grid.shape:
        raise MissionError(f"{path}: `solid` is {solid.shape}, but the area's voxels are {grid.shape}; match them")
    if not solid[:, :, 0].all():
        raise MissionError(f"{path}: the lowest layer of `solid` is the ground and must be true everywhere; fill it")
    return solid
