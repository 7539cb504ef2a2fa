"""Control laws that the bodies' kernels share: approach without overshoot, limited acceleration and jerk.

A vehicle follows its target as ArduPilot's square-root controller does: the wanted speed falls with the root of the
remaining distance, so that the deceleration stays below the limit, and linearly close by. Horizontal and vertical
limits are scaled together, so that a leg from rest is a straight line in space.
"""

from __future__ import annotations

import math

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray

POSITION_GAIN_1_S = 1.0
"""Gain of the position loop close to the target (ArduPilot's PSC_POSXY_P and PSC_POSZ_P)."""
BRAKING_SHARE = 0.8
"""Share of the acceleration limit that braking plans with; the rest follows the course."""
JERK_M_S3 = 20.0


@compiled
def approach_speed(distance_m: float, acceleration_m_s2: float) -> float:
    """Speed from which a body still stops at `distance_m` with that deceleration."""
    knee_m = acceleration_m_s2 / POSITION_GAIN_1_S**2
    if distance_m < knee_m:
        return distance_m * POSITION_GAIN_1_S
    return math.sqrt(2.0 * acceleration_m_s2 * (distance_m - 0.5 * knee_m))


@compiled
def wanted_velocity(
    motion: int,
    offset: FloatArray,
    velocity: FloatArray,
    target: FloatArray,
    limits: FloatArray,
    dt_s: float,
    wanted: FloatArray,
) -> None:
    """Velocity (3,) that a freely moving body wants for its `Motion`, written into `wanted`."""
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
        wanted[:] = offset * (min(fastest, approach_speed(distance, BRAKING_SHARE * hardest)) / distance)
    elif motion == 2:
        pace = math.hypot(target[0], target[1])
        scale = speed / pace if pace > speed else 1.0
        wanted[0], wanted[1] = target[0] * scale, target[1] * scale
        wanted[2] = min(max(target[2], -sink), climb)
    elif motion == 3:
        distance = math.hypot(offset[0], offset[1])
        if distance > 1e-9:
            rate = min(speed, approach_speed(distance, BRAKING_SHARE * acceleration)) / distance
            wanted[0], wanted[1] = offset[0] * rate, offset[1] * rate
        wanted[2] = -sink


@compiled
def accelerate(
    velocity: FloatArray, acceleration: FloatArray, wanted: FloatArray, limits: FloatArray, dt_s: float
) -> None:
    """Change `velocity` and `acceleration` (3,) towards a wanted velocity within the limits and the jerk."""
    dx, dy, dz = wanted[0] - velocity[0], wanted[1] - velocity[1], wanted[2] - velocity[2]
    change = math.hypot(dx, dy)
    most = limits[3] * dt_s
    scale = most / change if change > most else 1.0
    most = limits[4] * dt_s
    ax, ay, az = dx * scale / dt_s, dy * scale / dt_s, min(max(dz, -most), most) / dt_s
    size = math.sqrt(ax * ax + ay * ay + az * az)
    missing = math.sqrt(dx * dx + dy * dy + dz * dz)
    step = JERK_M_S3 * dt_s
    # The acceleration from which falling by the jerk still ends at the wanted velocity, in whole steps of time.
    ending = step * (math.sqrt(0.25 + 2.0 * missing / (step * dt_s)) - 0.5)
    if size > max(ending, 0.0) and missing > step * dt_s:
        ax, ay, az = ax * ending / size, ay * ending / size, az * ending / size
    jx, jy, jz = ax - acceleration[0], ay - acceleration[1], az - acceleration[2]
    size = math.sqrt(jx * jx + jy * jy + jz * jz)
    scale = step / size if size > step else 1.0
    acceleration[0] += jx * scale
    acceleration[1] += jy * scale
    acceleration[2] += jz * scale
    velocity[0] += acceleration[0] * dt_s
    velocity[1] += acceleration[1] * dt_s
    velocity[2] += acceleration[2] * dt_s
