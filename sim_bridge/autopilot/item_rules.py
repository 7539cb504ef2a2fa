"""Which mission, fence and rally items a vehicle takes, and the answer to those that it does not."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sim_bridge.autopilot.dialect import mavlink
from sim_bridge.flight_plan import (
    CIRCLES,
    FRAME_ABOVE_HOME,
    FRAME_ABOVE_TERRAIN,
    FRAME_GLOBAL,
    NOT_INT,
    POLYGONS,
    MissionCommand,
    PlanItem,
)

HIGHEST_M = 83_000.0
"""ArduPilot's limit of an altitude in an item."""
GLOBAL_FRAMES = (FRAME_GLOBAL, FRAME_ABOVE_HOME, FRAME_ABOVE_TERRAIN)
_C = MissionCommand
WITH_PLACE = frozenset({
    _C.WAYPOINT, _C.LOITER_UNLIMITED, _C.LOITER_TURNS, _C.LOITER_TIME, _C.LAND, _C.TAKEOFF, _C.SPLINE_WAYPOINT,
    _C.SET_HOME, _C.RETURN_PATH_START, _C.LAND_START, _C.REGION_OF_INTEREST, _C.REGION_OF_INTEREST_LOCATION,
})  # fmt: skip
"""Mission commands whose last three parameters are a place."""
YAW_MAY_BE_NAN = frozenset({
    _C.WAYPOINT, _C.LAND, _C.TAKEOFF, _C.LOITER_UNLIMITED, _C.LOITER_TIME, _C.LOITER_TURNS,
})  # fmt: skip
FENCE_COMMANDS = POLYGONS | CIRCLES | {_C.FENCE_RETURN_POINT}
MISSION_COMMANDS = frozenset(command for command in _C if command < _C.FENCE_RETURN_POINT)
MOST_ITEMS = {
    mavlink.MAV_MISSION_TYPE_MISSION: 724,
    mavlink.MAV_MISSION_TYPE_FENCE: 250,
    mavlink.MAV_MISSION_TYPE_RALLY: 66,
}


@dataclass(frozen=True, slots=True)
class Refusal:
    """An item that was not taken: MAV_MISSION_RESULT and what is wrong with it."""

    result: int
    reason: str


def check_item(
    mission_type: int,
    command: int,
    frame: int,
    parameters: tuple[float, float, float, float],
    x: int,
    y: int,
    z: float,
) -> PlanItem | Refusal:
    """Take an item as it came, or tell what is wrong with it."""
    known = {
        mavlink.MAV_MISSION_TYPE_MISSION: MISSION_COMMANDS,
        mavlink.MAV_MISSION_TYPE_FENCE: FENCE_COMMANDS,
        mavlink.MAV_MISSION_TYPE_RALLY: {_C.RALLY_POINT},
    }[mission_type]
    if command not in known:
        return Refusal(mavlink.MAV_MISSION_UNSUPPORTED, f"command {command} is not supported")
    refusal = _check_parameters(MissionCommand(command), parameters)
    if refusal is not None:
        return refusal
    if mission_type == mavlink.MAV_MISSION_TYPE_MISSION and command not in WITH_PLACE:
        stored_z = z if math.isfinite(z) else 0.0
        return PlanItem(command, FRAME_GLOBAL, _without_nan(parameters), x, y, stored_z)
    stored_frame = NOT_INT.get(frame, frame)
    if stored_frame not in GLOBAL_FRAMES:
        return Refusal(mavlink.MAV_MISSION_UNSUPPORTED_FRAME, f"frame {frame} is not supported")
    if abs(x) > 900_000_000:
        return Refusal(mavlink.MAV_MISSION_INVALID_PARAM5_X, f"latitude {x} is none")
    if abs(y) > 1_800_000_000:
        return Refusal(mavlink.MAV_MISSION_INVALID_PARAM6_Y, f"longitude {y} is none")
    if not abs(z) <= HIGHEST_M:
        return Refusal(mavlink.MAV_MISSION_INVALID_PARAM7, f"altitude {z} is none")
    if mission_type == mavlink.MAV_MISSION_TYPE_FENCE:
        stored_frame = FRAME_GLOBAL
    return PlanItem(command, stored_frame, _without_nan(parameters), x, y, z)


def _without_nan(parameters: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    first, second, third, fourth = (0.0 if math.isnan(value) else value for value in parameters)
    return (first, second, third, fourth)


def _check_parameters(command: MissionCommand, parameters: tuple[float, float, float, float]) -> Refusal | None:
    for number, value in enumerate(parameters):
        if not math.isfinite(value) and not (number == 3 and math.isnan(value) and command in YAW_MAY_BE_NAN):
            return Refusal(mavlink.MAV_MISSION_INVALID_PARAM1 + number, f"parameter {number + 1} is {value}")
    if command in POLYGONS and not 0 <= parameters[0] <= 255:
        return Refusal(mavlink.MAV_MISSION_INVALID_PARAM1, f"a polygon cannot have {parameters[0]:g} corners")
    if command in CIRCLES and not parameters[0] > 0:
        return Refusal(mavlink.MAV_MISSION_ERROR, f"a circle cannot have a radius of {parameters[0]:g} m")
    return None
