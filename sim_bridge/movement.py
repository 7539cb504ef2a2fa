"""Kernels that move bodies by one step: multicopters, surface vessels and underwater vehicles, row by row.

What the columns of the arrays mean is told by `sim_bridge.dynamics.Bodies`; kinds and motions are the numbers of its
`BodyKind` and `Motion`.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from sim_bridge.laws import BRAKING_SHARE, accelerate, approach_speed, wanted_velocity
from sim_bridge.world import surface_height
from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray

IntArray = npt.NDArray[np.int64]

GRAVITY_M_S2 = 9.80665
TURN_RATE_DEG_S = 60.0
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
def _move(
    i: int,
    kind: int,
    position: FloatArray,
    velocity: FloatArray,
    acceleration: FloatArray,
    heading: FloatArray,
    surge: FloatArray,
    motion: int,
    believed: FloatArray,
    target: FloatArray,
    limits: FloatArray,
    flow: FloatArray,
    gust: FloatArray,
    ground: float,
    dt_s: float,
    wanted: FloatArray,
) -> None:
    """Let a body's drive change its velocity."""
    if kind == 0:
        _move_copter(i, position, velocity, acceleration, motion, believed, target, limits, gust, ground, dt_s, wanted)
    elif kind == 1:
        _move_vessel(i, velocity, acceleration, heading, surge, motion, believed, target, limits, flow, dt_s)
    else:
        _move_underwater(i, velocity, acceleration, motion, believed, target, limits, flow, dt_s, wanted)


@compiled
def _meet_surfaces(
    i: int,
    kind: int,
    position: FloatArray,
    velocity: FloatArray,
    acceleration: FloatArray,
    surge: FloatArray,
    ground: float,
    impact: FloatArray,
    east_step: float,
    north_step: float,
    water_m: float,
) -> None:
    """Keep a body that has just moved by a step out of the ground, and hulls in the water."""
    speed = math.sqrt(velocity[i, 0] ** 2 + velocity[i, 1] ** 2 + velocity[i, 2] ** 2)
    if kind == 1:
        position[i, 2] = water_m
        if ground > water_m - DRAUGHT_M:
            impact[i] = speed
            position[i, 0] -= east_step
            position[i, 1] -= north_step
            surge[i] = 0.0
            velocity[i, :] = 0.0
        return
    if kind == 2 and position[i, 2] > water_m:
        position[i, 2] = water_m
        velocity[i, 2] = min(velocity[i, 2], 0.0)
    if position[i, 2] <= ground:
        impact[i] = speed
        position[i, 2] = ground
        velocity[i, :] = 0.0
        acceleration[i, :] = 0.0


@compiled
def advance(
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
    """Move every body by one step; the arguments are the attributes of `Bodies` and of its world's grid."""
    wanted = np.zeros(3)
    for i in range(position.shape[0]):
        impact[i] = -1.0
        if kind[i] == 0 and motion[i] == 0 and position[i, 2] <= ground[i]:
            velocity[i, :] = 0.0
            attitude[i, :] = 0.0
            acceleration[i, :] = 0.0
            continue
        vx, vy, vz = velocity[i, 0], velocity[i, 1], velocity[i, 2]
        _move(
            i, kind[i], position, velocity, acceleration, heading, surge, motion[i], position[i] + error[i], target[i],
            limits[i], flow[i], gust[i], ground[i], dt_s, wanted,
        )  # fmt: skip
        east_step, north_step = 0.5 * (vx + velocity[i, 0]) * dt_s, 0.5 * (vy + velocity[i, 1]) * dt_s
        position[i, 0] += east_step
        position[i, 1] += north_step
        position[i, 2] += 0.5 * (vz + velocity[i, 2]) * dt_s
        ground[i] = surface_height(
            elevation, (position[i, 0] - west_m) / cell_m - 0.5, (position[i, 1] - south_m) / cell_m - 0.5
        )
        _meet_surfaces(
            i, kind[i], position, velocity, acceleration, surge, ground[i], impact, east_step, north_step, water_m
        )
        drives = motion[i] != 0 and motion[i] != 4
        if kind[i] != 1 and drives and math.hypot(velocity[i, 0], velocity[i, 1]) > 0.5:
            course = math.degrees(math.atan2(velocity[i, 0], velocity[i, 1]))
            heading[i] = _turn(heading[i], course, TURN_RATE_DEG_S * dt_s)
        if kind[i] == 0:
            _lean(i, attitude, acceleration, velocity, flow[i], heading[i])
