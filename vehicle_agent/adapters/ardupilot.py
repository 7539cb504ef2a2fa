"""ArduPilot's ways: its firmwares' modes and parameter names, and which requests carry out an order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
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
POSHOLD = 16
BRAKE = 17
SURFACE = 9

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

SUB_MODES: Mapping[int, FlightMode] = MappingProxyType(
    {
        0: FlightMode.MANUAL,  # STABILIZE
        1: FlightMode.MANUAL,  # ACRO
        2: FlightMode.MANUAL,  # ALT_HOLD
        3: FlightMode.MISSION,  # AUTO
        GUIDED: FlightMode.GUIDED,
        7: FlightMode.MISSION,  # CIRCLE
        SURFACE: FlightMode.LAND,
        POSHOLD: FlightMode.HOLD,
        19: FlightMode.MANUAL,  # MANUAL
        20: FlightMode.MANUAL,  # MOTOR_DETECT
        21: FlightMode.MANUAL,  # SURFTRAK
    }
)


@dataclass(frozen=True, slots=True)
class Firmware:
    """What differs between ArduPilot's firmwares.

    Attributes
    ----------
    modes
        Its `custom_mode` numbers in common words.
    hold_modes
        Number and name of the modes that stop and stay, in order of preference.
    land_mode
        Ends the trip where the vehicle is: on the ground, or at the water's surface.
    return_mode
        The autopilot's own return; None where it has none.
    """

    modes: Mapping[int, FlightMode]
    hold_modes: tuple[tuple[int, str], ...]
    land_mode: tuple[int, str]
    return_mode: tuple[int, str] | None

    def flight_mode(self, custom_mode: int) -> FlightMode:
        """The mode in common words."""
        return self.modes.get(custom_mode, FlightMode.UNKNOWN)


# BRAKE needs no pilot; LOITER without a radio control may read an idle throttle stick as "sink".
COPTER = Firmware(COPTER_MODES, ((BRAKE, "BRAKE"), (LOITER, "LOITER")), (LAND, "LAND"), (RTL, "RTL"))
SUB = Firmware(SUB_MODES, ((POSHOLD, "POSHOLD"),), (SURFACE, "SURFACE"), None)
FIRMWARES: Mapping[str, Firmware] = MappingProxyType({"multicopter": COPTER, "underwater-vehicle": SUB})
"""By the type of vehicle in a mission file."""

PARAMETER_NAMES: Mapping[str, tuple[str, ...]] = MappingProxyType({"SYSID_MYGCS": ("SYSID_MYGCS", "MAV_GCS_SYSID")})
"""Parameters that have had several names, older first: an ArduPilot is silent on names that it does not have."""


def steps_of(order: Order, datum: Datum, firmware: Firmware = COPTER) -> tuple[Step, ...]:
    """What to ask of an ArduPilot, one after the other, to carry out an order."""
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
            return (_step(*(_mode(*mode) for mode in firmware.hold_modes)),)
        case ReturnHome():
            return (_step(_mode(*(firmware.return_mode or firmware.land_mode))),)
        case Land():
            return (_step(_mode(*firmware.land_mode)),)


def _step(*alternatives: CommandRequest | ParameterRequest) -> Step:
    return Step(alternatives)


def _mode(custom_mode: int, name: str) -> CommandRequest:
    return CommandRequest(COMMAND_DO_SET_MODE, f"switch to {name}", (1.0, float(custom_mode)))
