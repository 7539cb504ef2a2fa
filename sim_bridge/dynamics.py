"""Bodies of all vehicles, moved by fixed steps: multicopters, surface vessels and underwater vehicles per call."""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from sim_bridge.laws import BRAKING_SHARE, POSITION_GAIN_1_S, accelerate, approach_speed, wanted_velocity
from sim_bridge.world import World, surface_height
from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray, Point

__all__ = ["BRAKING_SHARE", "POSITION_GAIN_1_S", "Bodies", "BodyKind", "Motion"]

IntArray = npt.NDArray[np.int64]

GRAVITY_M_S2 = 9.80665
TURN_RATE_DEG_S = 60.0
OBSTACLE_STEP_M = 2.0
"""Resolution of distances to the ground around a body."""
FALL_LIMIT_M_S = 50.0
"""Terminal velocity of a copter without thrust."""
AIR_DRAG_1_S = 0.15
"""Deceleration of a copter per metre a second of airspeed; it leans against it."""
GUST_SHARE = 0.1
"""Share of a gust that carries the copter along before its controller has leant against it."""
WATER_DRAG_1_S = 0.5
"""Deceleration of an unpowered hull per metre a second through the water."""
VESSEL_TURN_DEG_S = 45.0
STEERAGE_SHARE = 0.4
"""Share of its speed that a vessel keeps in a turn: a rudder needs flow."""
VESSEL_ARRIVED_M = 2.0
"""A vessel idles within this distance of its target and returns when it has drifted away."""
DRAUGHT_M = 0.3

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


@compiled
def _turn(heading: float, course: float, most: float) -> float:
    """Heading after a turn towards a course by at most so many degrees."""
    turn = (course - heading + 180.0) % 360.0 - 180.0
    return (heading + min(max(turn, -most), most)) % 360.0


@compiled
def _move_copter(
    i: int,
    position: FloatArray,
    velocity: FloatArray,
    acceleration: FloatArray,
    motion: int,
    believed: FloatArray,
    target: FloatArray,
    limits: FloatArray,
    gust: FloatArray,
    ground: float,
    dt_s: float,
    wanted: FloatArray,
) -> None:
    if motion == 0:
        acceleration[i, :] = 0.0
        if position[i, 2] > ground:
            velocity[i, 2] = max(velocity[i, 2] - GRAVITY_M_S2 * dt_s, -FALL_LIMIT_M_S)
        return
    wanted_velocity(motion, target - believed, velocity[i], target, limits, dt_s, wanted)
    accelerate(velocity[i], acceleration[i], wanted, limits, dt_s)
    if position[i, 2] > ground:
        position[i, 0] += GUST_SHARE * gust[0] * dt_s
        position[i, 1] += GUST_SHARE * gust[1] * dt_s


@compiled
def _move_vessel(
    i: int,
    velocity: FloatArray,
    acceleration: FloatArray,
    heading: FloatArray,
    surge: FloatArray,
    motion: int,
    believed: FloatArray,
    target: FloatArray,
    limits: FloatArray,
    current: FloatArray,
    dt_s: float,
) -> None:
    """A hull that moves along its heading through water that itself moves."""
    speed, course = 0.0, heading[i]
    if motion == 1:
        east, north = target[0] - believed[0], target[1] - believed[1]
        distance = math.hypot(east, north)
        if distance > VESSEL_ARRIVED_M:
            pace = min(limits[0], approach_speed(distance, BRAKING_SHARE * limits[3]))
            # Steer up against the current, so that the course over ground leads to the target.
            east = east / distance * pace - current[0]
            north = north / distance * pace - current[1]
            course = math.degrees(math.atan2(east, north))
            speed = min(math.hypot(east, north), limits[0])
    elif motion == 2:
        speed = min(math.hypot(target[0], target[1]), limits[0])
        if speed > 1e-6:
            course = math.degrees(math.atan2(target[0], target[1]))
    if motion == 0:
        surge[i] -= min(1.0, WATER_DRAG_1_S * dt_s) * surge[i]
    else:
        off = abs((course - heading[i] + 180.0) % 360.0 - 180.0)
        speed *= max(STEERAGE_SHARE, 1.0 - off / 90.0)
        most = limits[3] * dt_s
        surge[i] += min(max(speed - surge[i], -most), most)
        rate = VESSEL_TURN_DEG_S
        if limits[5] > 0.0:
            rate = min(rate, math.degrees(abs(surge[i]) / limits[5]))
        heading[i] = _turn(heading[i], course, rate * dt_s)
    along = math.radians(heading[i])
    east, north = surge[i] * math.sin(along) + current[0], surge[i] * math.cos(along) + current[1]
    acceleration[i, 0], acceleration[i, 1] = (east - velocity[i, 0]) / dt_s, (north - velocity[i, 1]) / dt_s
    velocity[i, 0], velocity[i, 1], velocity[i, 2] = east, north, 0.0


@compiled
def _move_underwater(
    i: int,
    velocity: FloatArray,
    acceleration: FloatArray,
    motion: int,
    believed: FloatArray,
    target: FloatArray,
    limits: FloatArray,
    current: FloatArray,
    dt_s: float,
    wanted: FloatArray,
) -> None:
    """A neutrally buoyant hull with thrusters in all directions."""
    if motion == 0 or motion == 4:
        share = min(1.0, WATER_DRAG_1_S * dt_s)
        velocity[i, 0] += share * (current[0] - velocity[i, 0])
        velocity[i, 1] += share * (current[1] - velocity[i, 1])
        acceleration[i, :] = 0.0
        if motion == 0:
            velocity[i, 2] -= share * velocity[i, 2]
            return
        height = target[2] - believed[2]
        rate = math.copysign(approach_speed(abs(height), BRAKING_SHARE * limits[4]), height)
        most = limits[4] * dt_s
        rate = min(max(rate, -limits[2]), limits[1])
        velocity[i, 2] += min(max(rate - velocity[i, 2], -most), most)
        return
    wanted_velocity(motion, target - believed, velocity[i], target, limits, dt_s, wanted)
    accelerate(velocity[i], acceleration[i], wanted, limits, dt_s)


@compiled
def _lean(
    i: int, attitude: FloatArray, acceleration: FloatArray, velocity: FloatArray, flow: FloatArray, heading: float
) -> None:
    """Roll and pitch (radians) with which a copter makes its acceleration and withstands the air."""
    east = acceleration[i, 0] + AIR_DRAG_1_S * (velocity[i, 0] - flow[0])
    north = acceleration[i, 1] + AIR_DRAG_1_S * (velocity[i, 1] - flow[1])
    along = math.radians(heading)
    forward = east * math.sin(along) + north * math.cos(along)
    rightward = east * math.cos(along) - north * math.sin(along)
    attitude[i, 0] = math.atan2(rightward, GRAVITY_M_S2)
    attitude[i, 1] = -math.atan2(forward, GRAVITY_M_S2)


@compiled
def _advance(
    kind: IntArray,
    position: FloatArray,
    velocity: FloatArray,
    acceleration: FloatArray,
    heading: FloatArray,
    surge: FloatArray,
    attitude: FloatArray,
    motion: IntArray,
    target: FloatArray,
    limits: FloatArray,
    flow: FloatArray,
    gust: FloatArray,
    error: FloatArray,
    ground: FloatArray,
    impact: FloatArray,
    elevation: FloatArray,
    west_m: float,
    south_m: float,
    cell_m: float,
    water_m: float,
    dt_s: float,
) -> None:
    wanted = np.zeros(3)
    for i in range(position.shape[0]):
        impact[i] = -1.0
        vx, vy, vz = velocity[i, 0], velocity[i, 1], velocity[i, 2]
        believed = position[i] + error[i]
        if kind[i] == 0:
            if motion[i] == 0 and position[i, 2] <= ground[i]:
                velocity[i, :] = 0.0
                attitude[i, :] = 0.0
                acceleration[i, :] = 0.0
                continue
            _move_copter(
                i, position, velocity, acceleration, motion[i], believed, target[i], limits[i], gust[i], ground[i],
                dt_s, wanted,
            )  # fmt: skip
        elif kind[i] == 1:
            _move_vessel(
                i, velocity, acceleration, heading, surge, motion[i], believed, target[i], limits[i], flow[i], dt_s
            )
        else:
            _move_underwater(
                i, velocity, acceleration, motion[i], believed, target[i], limits[i], flow[i], dt_s, wanted
            )
        position[i, 0] += 0.5 * (vx + velocity[i, 0]) * dt_s
        position[i, 1] += 0.5 * (vy + velocity[i, 1]) * dt_s
        position[i, 2] += 0.5 * (vz + velocity[i, 2]) * dt_s
        ground[i] = surface_height(
            elevation, (position[i, 0] - west_m) / cell_m - 0.5, (position[i, 1] - south_m) / cell_m - 0.5
        )
        speed = math.sqrt(velocity[i, 0] ** 2 + velocity[i, 1] ** 2 + velocity[i, 2] ** 2)
        if kind[i] == 1:
            position[i, 2] = water_m
            if ground[i] > water_m - DRAUGHT_M:
                impact[i] = speed
                position[i, 0] -= 0.5 * (vx + velocity[i, 0]) * dt_s
                position[i, 1] -= 0.5 * (vy + velocity[i, 1]) * dt_s
                surge[i] = 0.0
                velocity[i, :] = 0.0
            continue
        if kind[i] == 2 and position[i, 2] > water_m:
            position[i, 2] = water_m
            velocity[i, 2] = min(velocity[i, 2], 0.0)
        if position[i, 2] <= ground[i]:
            impact[i] = speed
            position[i, 2] = ground[i]
            velocity[i, :] = 0.0
            acceleration[i, :] = 0.0
        if motion[i] != 0 and motion[i] != 4 and math.hypot(velocity[i, 0], velocity[i, 1]) > 0.5:
            course = math.degrees(math.atan2(velocity[i, 0], velocity[i, 1]))
            heading[i] = _turn(heading[i], course, TURN_RATE_DEG_S * dt_s)
        if kind[i] == 0:
            _lean(i, attitude, acceleration, velocity, flow[i], heading[i])


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
        _advance(
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
