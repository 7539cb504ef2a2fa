"""ArduPilot's ways: its copter modes and parameter names, and which requests carry out an order."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from vehicle_agent.adapters.mavlink_requests import (
    COMMAND_ARM_DISARM,
    COMMAND_DO_CHANGE_SPEED,
    COMMAND_DO_REPOSITION,
    COMMAND_DO_SET_MODE,
    COMMAND_NAV_TAKEOFF,
    CommandRequest,
    ParameterRequest,
    Step,
)
from vehicle_agent.domain.frames import Datum
from vehicle_agent.ports import (
    Arm,
    Disarm,
    FlightMode,
    GoTo,
    Hold,
    Land,
    Order,
    ReturnHome,
    SetParameter,
    SetSpeed,
    TakeOff,
)

AUTOPILOT_TYPE = 3
"""MAV_AUTOPILOT_ARDUPILOTMEGA."""

GUIDED = 4
LOITER = 5
RTL = 6
LAND = 9
BRAKE = 17

COPTER_MODES: Mapping[int, FlightMode] = MappingProxyType(
    {
        0: FlightMode.MANUAL,  # STABILIZE
        1: FlightMode.MANUAL,  # ACRO
        2: FlightMode.MANUAL,  # ALT_HOLD
        3: FlightMode.MISSION,  # AUTO
        GUIDED: FlightMode.GUIDED,
        LOITER: FlightMode.HOLD,
        RTL: FlightMode.RETURN,
        LAND: FlightMode.LAND,
        11: FlightMode.MANUAL,  # DRIFT
        13: FlightMode.MANUAL,  # SPORT
        16: FlightMode.MANUAL,  # POSHOLD
        BRAKE: FlightMode.HOLD,
        21: FlightMode.RETURN,  # SMART_RTL
        27: FlightMode.RETURN,  # AUTO_RTL
    }
)

PARAMETER_NAMES: Mapping[str, tuple[str, ...]] = MappingProxyType({"SYSID_MYGCS": ("SYSID_MYGCS", "MAV_GCS_SYSID")})
"""Parameters that have had several names, older first: an ArduPilot is silent on names that it does not have."""


def flight_mode(custom_mode: int) -> FlightMode:
    """The copter mode in common words."""
    return COPTER_MODES.get(custom_mode, FlightMode.UNKNOWN)


def steps_of(order: Order, datum: Datum) -> tuple[Step, ...]:
    """What to ask of an ArduCopter, one after the other, to carry out an order."""
    match order:
        case SetParameter(name, value):
            return (_step(*(ParameterRequest(each, value) for each in PARAMETER_NAMES.get(name, (name,)))),)
        case Arm():
            return (_step(_mode(GUIDED, "GUIDED")), _step(CommandRequest(COMMAND_ARM_DISARM, "arm", (1.0,))))
        case Disarm():
            return (_step(CommandRequest(COMMAND_ARM_DISARM, "disarm", (0.0,))),)
        case TakeOff(height_m):
            climb = CommandRequest(COMMAND_NAV_TAKEOFF, "take off", (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, height_m))
            return (_step(climb),)
        case GoTo(position_enu_m):
            target = datum.to_geodetic(position_enu_m)
            position = (round(target.latitude_deg * 1e7), round(target.longitude_deg * 1e7), target.altitude_amsl_m)
            # param1 -1: keep the speed; param2 1: switch to guided flight; param4 left 0: MAVLink's JSON has no NaN.
            return (_step(CommandRequest(COMMAND_DO_REPOSITION, "go there", (-1.0, 1.0, 0.0, 0.0), position)),)
        case SetSpeed(speed_m_s):
            return (_step(CommandRequest(COMMAND_DO_CHANGE_SPEED, "limit the speed", (1.0, speed_m_s, -1.0))),)
        case Hold():
            # BRAKE needs no pilot; LOITER without a radio control may read an idle throttle stick as "sink".
            return (_step(_mode(BRAKE, "BRAKE"), _mode(LOITER, "LOITER")),)
        case ReturnHome():
            return (_step(_mode(RTL, "RTL")),)
        case Land():
            return (_step(_mode(LAND, "LAND")),)


def _step(*alternatives: CommandRequest | ParameterRequest) -> Step:
    return Step(alternatives)


def _mode(custom_mode: int, name: str) -> CommandRequest:
    return CommandRequest(COMMAND_DO_SET_MODE, f"switch to {name}", (1.0, float(custom_mode)))
