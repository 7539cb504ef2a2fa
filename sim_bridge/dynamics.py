"""Bodies of all vehicles, moved by fixed steps: multicopters, surface vessels and underwater vehicles per call."""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np

from sim_bridge.laws import BRAKING_SHARE, POSITION_GAIN_1_S
from sim_bridge.movement import IntArray, advance
from sim_bridge.world import World
from vehicle_agent.domain.frames import FloatArray, Point

__all__ = ["BRAKING_SHARE", "POSITION_GAIN_1_S", "Bodies", "BodyKind", "Motion"]

OBSTACLE_STEP_M = 2.0
"""Resolution of distances to the ground around a body."""

SPEED, CLIMB, SINK, ACCELERATION, VERTICAL_ACCELERATION, TURN_RADIUS = range(6)
"""Columns of `Bodies.limits`, metres and seconds."""


class BodyKind(IntEnum):
    """How a body moves."""

    MULTICOPTER = 0
    SURFACE_VESSEL = 1
    UNDERWATER = 2


class Motion(IntEnum):
    """What drives a body."""

    OFF = 0
    """Motors stopped: stands, falls or drifts."""
    POSITION = 1
    """Goes straight to `target` and stays there."""
    VELOCITY = 2
    """Moves with the velocity in `target`."""
    DESCEND = 3
    """Sinks at the rate limit while keeping east and north of `target`."""
    KEEP_HEIGHT = 4
    """Keeps the height of `target` and drifts (underwater vehicles)."""


class Bodies:
    """State of all bodies; row i belongs to vehicle i.

    Attributes
    ----------
    kind
        (N,) int64, a `BodyKind` each.
    position_enu_m, velocity_enu_m_s, acceleration_enu_m_s2
        (N, 3) float64, the truth.
    heading_deg
        (N,) float64, clockwise from north.
    attitude_rad
        (N, 2) float64, roll and pitch.
    motion
        (N,) int64, a `Motion` each.
    target
        (N, 3) float64, ENU metres, or ENU metres per second in `Motion.VELOCITY`; where vehicles believe to be counts.
    limits
        (N, 6) float64: speed, climb and sink rate (m/s), horizontal and vertical acceleration (m/s^2), turning
        radius (m).
    flow_m_s, gust_m_s
        (N, 2) float64, east and north: air or water around the body, and the part of it that control cannot foresee.
    error_m
        (N, 3) float64: what each vehicle believes of its position, less the truth.
    ground_m
        (N,) float64, ENU z of the surface beneath.
    impact_m_s
        (N,) float64, speed at which the body met the ground in the last step; negative when it did not.
    water_level_m
        ENU z of the water's surface.
    """

    def __init__(
        self, world: World, starts_en_m: FloatArray, kind: IntArray | None = None, water_level_m: float = 0.0
    ) -> None:
        count = len(starts_en_m)
        self._world = world
        self.water_level_m = water_level_m
        self.kind: IntArray = np.zeros(count, dtype=np.int64) if kind is None else kind
        self.ground_m = np.array([world.ground_m(float(east), float(north)) for east, north in starts_en_m])
        heights = np.where(self.kind == BodyKind.MULTICOPTER, self.ground_m, water_level_m)
        self.position_enu_m = np.column_stack((starts_en_m, heights)).astype(np.float64)
        self.velocity_enu_m_s: FloatArray = np.zeros((count, 3))
        self.acceleration_enu_m_s2: FloatArray = np.zeros((count, 3))
        self.heading_deg: FloatArray = np.zeros(count)
        self._surge_m_s: FloatArray = np.zeros(count)
        self.attitude_rad: FloatArray = np.zeros((count, 2))
        self.motion: IntArray = np.zeros(count, dtype=np.int64)
        self.target: FloatArray = self.position_enu_m.copy()
        self.limits: FloatArray = np.tile([5.0, 2.5, 1.5, 2.5, 1.0, 0.0], (count, 1))
        self.flow_m_s: FloatArray = np.zeros((count, 2))
        self.gust_m_s: FloatArray = np.zeros((count, 2))
        self.error_m: FloatArray = np.zeros((count, 3))
        self.impact_m_s: FloatArray = np.full(count, -1.0)
        self.impacts_m_s: list[float] = self.impact_m_s.tolist()
        self.flows_m_s: list[list[float]] = self.flow_m_s.tolist()

    def surface_m(self, east_m: float, north_m: float) -> float:
        """ENU z of the ground at a place."""
        return self._world.ground_m(east_m, north_m)

    def distance_along_m(self, index: int, direction_enu: Point, farthest_m: float) -> float:
        """Distance from a body to the ground along a unit vector; infinite beyond `farthest_m`."""
        east_m, north_m, up_m = self.position_enu_m[index].tolist()
        return self._world.distance_along_m((east_m, north_m, up_m), direction_enu, farthest_m)

    def distances_around_m(self, index: int, sectors: int, farthest_m: float) -> list[float]:
        """Level distance from a body to where the ground rises to its height, per sector clockwise from its nose."""
        east_m, north_m, up_m = self.position_enu_m[index].tolist()
        bearings = np.radians(self.heading_deg[index] + np.arange(sectors) * 360.0 / sectors)
        steps = np.arange(1.0, farthest_m, OBSTACLE_STEP_M)
        distances = [farthest_m] * sectors
        for sector, bearing in enumerate(bearings.tolist()):
            east, north = math.sin(bearing), math.cos(bearing)
            for step in steps.tolist():
                if self._world.ground_m(east_m + step * east, north_m + step * north) >= up_m:
                    distances[sector] = step
                    break
        return distances

    def advance(self, dt_s: float) -> None:
        """Move every body by one step (0.02 to 0.05 s)."""
        grid = self._world.grid
        advance(
            self.kind,
            self.position_enu_m,
            self.velocity_enu_m_s,
            self.acceleration_enu_m_s2,
            self.heading_deg,
            self._surge_m_s,
            self.attitude_rad,
            self.motion,
            self.target,
            self.limits,
            self.flow_m_s,
            self.gust_m_s,
            self.error_m,
            self.ground_m,
            self.impact_m_s,
            self._world.elevation_m,
            grid.west_m,
            grid.south_m,
            grid.cell_m,
            self.water_level_m,
            dt_s,
        )
        self.impacts_m_s = self.impact_m_s.tolist()
