"""Between the agent's metres and the wire's centimetres."""

from __future__ import annotations

from vehicle_agent.domain.frames import Point
from vehicle_agent.wire.messages import PositionCm

_LIMIT_CM = 10**8


def to_metres(position_cm: PositionCm) -> Point:
    return (position_cm[0] * 0.01, position_cm[1] * 0.01, position_cm[2] * 0.01)


def to_centimetres(position_m: Point) -> PositionCm:
    """Rounded, and held within what the wire can say (1000 km)."""
    east, north, up = (min(max(round(value * 100.0), -_LIMIT_CM), _LIMIT_CM) for value in position_m)
    return (east, north, up)
