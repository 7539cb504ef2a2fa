"""Ground truth: the surface under the fleet and what a sensor sees of it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from sim_bridge.terrain import true_surface
from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.elevation import CellObservations
from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.sensing import visible_surface
from vehicle_agent.mission.load import MissionError, MissionPlan
from vehicle_agent.mission.terrain import TownTerrain

if TYPE_CHECKING:
    from sim_bridge.town_world import Town

BELOW_GROUND_TOLERANCE_M = 0.05


@compiled
def surface_height(elevation_m: FloatArray, u: float, v: float) -> float:
    """Bilinear height at a place in cells (cell centres at whole numbers); beyond the border the border's height."""
    columns, rows = elevation_m.shape
    u = min(max(u, 0.0), columns - 1.0)
    v = min(max(v, 0.0), rows - 1.0)
    i, j = min(int(u), max(columns - 2, 0)), min(int(v), max(rows - 2, 0))
    s, t = u - i, v - j
    k, m = min(i + 1, columns - 1), min(j + 1, rows - 1)
    low = (1.0 - s) * elevation_m[i, j] + s * elevation_m[k, j]
    high = (1.0 - s) * elevation_m[i, m] + s * elevation_m[k, m]
    return float((1.0 - t) * low + t * high)


@compiled
def beam_length(
    elevation_m: FloatArray, u: float, v: float, up: float, du: float, dv: float, dup: float, step: float, most: float
) -> float:
    """Distance along a ray to the surface, infinite beyond `most`; (u, v) and their rates are in cells, `up` in metres.

    The ray is followed in steps of `step` metres and the crossing then found by halving; from below the surface it is
    0.
    """
    if up <= surface_height(elevation_m, u, v):
        return 0.0
    if dup < 0.0 and du == 0.0 and dv == 0.0:
        fall = (up - surface_height(elevation_m, u, v)) / -dup
        return fall if fall <= most else math.inf
    near = 0.0
    while near < most:
        far = min(near + step, most)
        if up + far * dup <= surface_height(elevation_m, u + far * du, v + far * dv):
            for _ in range(24):
                middle = 0.5 * (near + far)
                if up + middle * dup <= surface_height(elevation_m, u + middle * du, v + middle * dv):
                    far = middle
                else:
                    near = middle
            return far
        near = far
    return math.inf


class World:
    """The true surface on the mission's grid.

    Attributes
    ----------
    grid
        The mission's cells.
    elevation_m
        (columns, rows) float64, ENU z of the surface at cell centres, metres; finite everywhere. In a town the ground.
    town
        What stands on the ground; None in the open country.
    """

    __slots__ = ("_elevation_dm", "elevation_m", "grid", "town")

    def __init__(self, grid: Grid, elevation_m: FloatArray, town: Town | None = None) -> None:
        if elevation_m.shape != grid.shape or not np.isfinite(elevation_m).all():
            raise ValueError("elevation_m must be finite and of the grid's shape")
        self.grid = grid
        self.town = town
        self.elevation_m = np.ascontiguousarray(elevation_m, dtype=np.float64)
        self._elevation_dm = np.rint(self.elevation_m * 10.0).astype(np.int32).ravel()

    @classmethod
    def of(cls, plan: MissionPlan) -> World:
        """Build a mission's world; MissionError when its terrain is unusable or a vehicle starts below ground."""
        town = None
        if isinstance(plan.mission.terrain, TownTerrain):
            from sim_bridge.town_world import Town  # its kernels load only where there is a town

            town = Town.of(plan)
        world = cls(plan.grid, true_surface(plan), town)
        for index, vehicle in enumerate(plan.mission.vehicles):
            if len(vehicle.start_enu_m) < 3:
                continue
            east_m, north_m, up_m = vehicle.start_enu_m
            ground_m = world.ground_m(east_m, north_m)
            if up_m < ground_m - BELOW_GROUND_TOLERANCE_M:
                raise MissionError(
                    f"{plan.source}: vehicles[{index}].start_enu_m: up {up_m:g} m lies below the ground, which is at "
                    f"{ground_m:.1f} m there; raise it or leave it out"
                )
        return world

    def ground_m(self, east_m: float, north_m: float) -> float:
        """ENU z of the surface, bilinear between cell centres, metres."""
        grid = self.grid
        return float(
            surface_height(
                self.elevation_m,
                (east_m - grid.west_m) / grid.cell_m - 0.5,
                (north_m - grid.south_m) / grid.cell_m - 0.5,
            )
        )

    def distance_along_m(self, position_enu_m: Point, direction_enu: Point, farthest_m: float) -> float:
        """Distance from a place to the surface along a unit vector, metres; infinite beyond `farthest_m`."""
        grid = self.grid
        east_m, north_m, up_m = position_enu_m
        return float(
            beam_length(
                self.elevation_m,
                (east_m - grid.west_m) / grid.cell_m - 0.5,
                (north_m - grid.south_m) / grid.cell_m - 0.5,
                up_m,
                direction_enu[0] / grid.cell_m,
                direction_enu[1] / grid.cell_m,
                direction_enu[2],
                0.5 * grid.cell_m,
                farthest_m,
            )
        )

    def scan(self, position_enu_m: Point, range_m: float, stamp_ms: int) -> CellObservations:
        """What an omnidirectional range sensor at a place sees of the surface at one instant."""
        if not all(math.isfinite(coordinate) for coordinate in position_enu_m):
            raise ValueError("a sensor's position must be finite")
        cells = visible_surface(self.grid, self.elevation_m, position_enu_m, range_m)
        return CellObservations(cells, self._elevation_dm[cells], np.full(len(cells), stamp_ms, dtype=np.int64))
