"""Multicopter kinematics: limited speed and acceleration, smooth braking, ground contact; all vehicles per call.

A vehicle in guided flight follows its target as ArduPilot's square-root controller does: the wanted speed falls with
the root of the remaining distance, so that the deceleration stays below the limit, and linearly close by. Horizontal
and vertical limits are scaled together, so that a leg flown from rest is a straight line in space.
"""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from sim_bridge.world import World, surface_height
from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray

IntArray = npt.NDArray[np.int64]

GRAVITY_M_S2 = 9.80665
POSITION_GAIN_1_S = 1.0
"""Gain of the position loop close to the target (ArduPilot's PSC_POSXY_P and PSC_POSZ_P)."""
BRAKING_SHARE = 0.8
"""Share of the acceleration limit that braking plans with; the rest follows the course."""
TURN_RATE_DEG_S = 60.0
FALL_LIMIT_M_S = 50.0
"""Terminal velocity of a copter without thrust."""

SPEED, CLIMB, SINK, ACCELERATION, VERTICAL_ACCELERATION = range(5)
"""Columns of `Bodies.limits`, metres and seconds."""


class Motion(IntEnum):
    """What drives a body."""

    OFF = 0
    """Motors stopped: stands, or falls."""
    POSITION = 1
    """Flies straight to `target` and stays there."""
    VELOCITY = 2
    """Flies with the velocity in `target`."""
    DESCEND = 3
    """Sinks at the rate limit while keeping east and north of `target`."""


@compiled
def _approach_speed(distance_m: float, acceleration_m_s2: float) -> float:
    """Speed from which a body still stops at `distance_m` with that deceleration."""
    knee_m = acceleration_m_s2 / POSITION_GAIN_1_S**2
    if distance_m < knee_m:
        return distance_m * POSITION_GAIN_1_S
    return math.sqrt(2.0 * acceleration_m_s2 * (distance_m - 0.5 * knee_m))


@compiled
def _wanted_velocity(
    motion: int,
    offset: FloatArray,
    velocity: FloatArray,
    target: FloatArray,
    limits: FloatArray,
    dt_s: float,
    wanted: FloatArray,
) -> None:
    speed, climb, sink = limits[0], limits[1], limits[2]
    acceleration, vertical_acceleration = limits[3], limits[4]
    wanted[:] = 0.0
    if motion == 1:
        distance = math.sqrt(offset[0] ** 2 + offset[1] ** 2 + offset[2] ** 2)
        if distance < 1e-9:
            return
        across = math.hypot(offset[0], offset[1]) / distance
        upward = offset[2] / distance
        fastest, hardest = 1e9, 1e9
        if across > 1e-9:
            fastest, hardest = speed / across, acceleration / across
        if abs(upward) > 1e-9:
            fastest = min(fastest, (climb if upward > 0 else sink) / abs(upward))
            hardest = min(hardest, vertical_acceleration / abs(upward))
        # Speed along the leg grows no faster than both limits allow together, or the steeper one would lag behind.
        present = (velocity[0] * offset[0] + velocity[1] * offset[1] + velocity[2] * offset[2]) / distance
        fastest = min(fastest, max(present, 0.0) + hardest * dt_s)
        wanted[:] = offset * (min(fastest, _approach_speed(distance, BRAKING_SHARE * hardest)) / distance)
    elif motion == 2:
        pace = math.hypot(target[0], target[1])
        scale = speed / pace if pace > speed else 1.0
        wanted[0], wanted[1] = target[0] * scale, target[1] * scale
        wanted[2] = min(max(target[2], -sink), climb)
    elif motion == 3:
        distance = math.hypot(offset[0], offset[1])
        if distance > 1e-9:
            rate = min(speed, _approach_speed(distance, BRAKING_SHARE * acceleration)) / distance
            wanted[0], wanted[1] = offset[0] * rate, offset[1] * rate
        wanted[2] = -sink


@compiled
def _advance(
    position: FloatArray,
    velocity: FloatArray,
    heading: FloatArray,
    motion: IntArray,
    target: FloatArray,
    limits: FloatArray,
    ground: FloatArray,
    impact: FloatArray,
    elevation: FloatArray,
    west_m: float,
    south_m: float,
    cell_m: float,
    dt_s: float,
) -> None:
    wanted = np.zeros(3)
    for i in range(position.shape[0]):
        impact[i] = -1.0
        vx, vy, vz = velocity[i, 0], velocity[i, 1], velocity[i, 2]
        if motion[i] == 0:
            if position[i, 2] <= ground[i]:
                velocity[i, :] = 0.0
                continue
            velocity[i, 2] = max(velocity[i, 2] - GRAVITY_M_S2 * dt_s, -FALL_LIMIT_M_S)
        else:
            _wanted_velocity(motion[i], target[i] - position[i], velocity[i], target[i], limits[i], dt_s, wanted)
            dx, dy, dz = wanted[0] - vx, wanted[1] - vy, wanted[2] - vz
            change = math.hypot(dx, dy)
            most = limits[i, 3] * dt_s
            scale = most / change if change > most else 1.0
            most = limits[i, 4] * dt_s
            velocity[i, 0] += dx * scale
            velocity[i, 1] += dy * scale
            velocity[i, 2] += min(max(dz, -most), most)
        position[i, 0] += 0.5 * (vx + velocity[i, 0]) * dt_s
        position[i, 1] += 0.5 * (vy + velocity[i, 1]) * dt_s
        position[i, 2] += 0.5 * (vz + velocity[i, 2]) * dt_s
        ground[i] = surface_height(
            elevation, (position[i, 0] - west_m) / cell_m - 0.5, (position[i, 1] - south_m) / cell_m - 0.5
        )
        if position[i, 2] <= ground[i]:
            impact[i] = math.sqrt(velocity[i, 0] ** 2 + velocity[i, 1] ** 2 + velocity[i, 2] ** 2)
            position[i, 2] = ground[i]
            velocity[i, :] = 0.0
        if motion[i] != 0 and math.hypot(velocity[i, 0], velocity[i, 1]) > 0.5:
            course = math.degrees(math.atan2(velocity[i, 0], velocity[i, 1]))
            turn = (course - heading[i] + 180.0) % 360.0 - 180.0
            most = TURN_RATE_DEG_S * dt_s
            heading[i] = (heading[i] + min(max(turn, -most), most)) % 360.0


class Bodies:
    """State of all bodies; row i belongs to vehicle i.

    Attributes
    ----------
    position_enu_m, velocity_enu_m_s
        (N, 3) float64.
    heading_deg
        (N,) float64, clockwise from north.
    motion
        (N,) int64, a `Motion` each.
    target
        (N, 3) float64, ENU metres, or ENU metres per second in `Motion.VELOCITY`.
    limits
        (N, 5) float64: speed, climb and sink rate (m/s), horizontal and vertical acceleration (m/s^2).
    ground_m
        (N,) float64, ENU z of the surface beneath.
    impact_m_s
        (N,) float64, speed at which the body met the ground in the last step; negative when it did not.
    """

    def __init__(self, world: World, starts_en_m: FloatArray) -> None:
        count = len(starts_en_m)
        self._world = world
        self.ground_m = np.array([world.ground_m(float(east), float(north)) for east, north in starts_en_m])
        self.position_enu_m = np.column_stack((starts_en_m, self.ground_m)).astype(np.float64)
        self.velocity_enu_m_s: FloatArray = np.zeros((count, 3))
        self.heading_deg: FloatArray = np.zeros(count)
        self.motion: IntArray = np.zeros(count, dtype=np.int64)
        self.target: FloatArray = self.position_enu_m.copy()
        self.limits: FloatArray = np.tile([5.0, 2.5, 1.5, 2.5, 1.0], (count, 1))
        self.impact_m_s: FloatArray = np.full(count, -1.0)

    def advance(self, dt_s: float) -> None:
        """Move every body by one step (0.02 to 0.05 s)."""
        grid = self._world.grid
        _advance(
            self.position_enu_m,
            self.velocity_enu_m_s,
            self.heading_deg,
            self.motion,
            self.target,
            self.limits,
            self.ground_m,
            self.impact_m_s,
            self._world.elevation_m,
            grid.west_m,
            grid.south_m,
            grid.cell_m,
            dt_s,
        )
