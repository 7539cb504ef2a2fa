"""ArduCopter: its flight modes, parameters and failsafes."""

from __future__ import annotations

from dataclasses import replace
from enum import IntEnum

from sim_bridge.modes import Behaviour, ModeTraits
from sim_bridge.parameter_sets.copter import copter_rows
from sim_bridge.parameters import ParameterTable
from sim_bridge.personalities.ardupilot import (
    AUTOMATIC_BASE_MODE,
    AUTOPILOT,
    VERSION_4_7,
    fence_settings,
    waypoint_settings,
)
from sim_bridge.personality import Action, Personality, Settings

CONTINUE_IF_LANDING = 8
CONTINUE_IF_PILOTED = 16
"""Bits of FS_OPTIONS."""


class CopterMode(IntEnum):
    """ArduCopter's `custom_mode` numbers."""

    STABILIZE = 0
    ALT_HOLD = 2
    AUTO = 3
    GUIDED = 4
    LOITER = 5
    RTL = 6
    LAND = 9
    BRAKE = 17


MODES: dict[IntEnum, ModeTraits] = {
    CopterMode.STABILIZE: ModeTraits("STABILIZE", Behaviour.PILOTED, armable=True, flown_by_pilot=True),
    CopterMode.ALT_HOLD: ModeTraits("ALT_HOLD", Behaviour.PILOTED, armable=True, flown_by_pilot=True),
    CopterMode.AUTO: ModeTraits("AUTO", Behaviour.AUTO, needs_position=True),
    CopterMode.GUIDED: ModeTraits("GUIDED", Behaviour.GUIDED, needs_position=True, armable=True),
    CopterMode.LOITER: ModeTraits("LOITER", Behaviour.HOLD, needs_position=True, armable=True, flown_by_pilot=True),
    CopterMode.RTL: ModeTraits("RTL", Behaviour.RETURN, needs_position=True),
    CopterMode.LAND: ModeTraits("LAND", Behaviour.LAND),
    CopterMode.BRAKE: ModeTraits("BRAKE", Behaviour.BRAKE, needs_position=True, flown_by_pilot=True),
}
MODE_OF: dict[Behaviour, IntEnum] = {
    Behaviour.PILOTED: CopterMode.STABILIZE,
    Behaviour.HOLD: CopterMode.LOITER,
    Behaviour.BRAKE: CopterMode.BRAKE,
    Behaviour.GUIDED: CopterMode.GUIDED,
    Behaviour.AUTO: CopterMode.AUTO,
    Behaviour.RETURN: CopterMode.RTL,
    Behaviour.LAND: CopterMode.LAND,
}
_CONTROLLER_ACTIONS = {0: None, 4: Action.LAND, 5: Action.LAND, 7: Action.BRAKE}
"""FS_GCS_ENABLE; every other value returns home."""
_BATTERY_ACTIONS = {
    0: Action.WARN, 1: Action.LAND, 2: Action.RETURN, 3: Action.RETURN, 4: Action.RETURN, 5: Action.DISARM,
}  # fmt: skip
_FENCE_ACTIONS = {0: Action.WARN, 1: Action.RETURN, 2: Action.LAND, 3: Action.RETURN, 4: Action.BRAKE, 5: Action.LAND}
_POSITION_ACTIONS = {1: Action.LAND, 2: Action.HOLD, 3: Action.LAND}
"""FS_EKF_ACTION."""


def settings(parameters: ParameterTable) -> Settings:
    """What ArduCopter's parameters mean; lengths in centimetres become metres."""
    options = int(parameters["FS_OPTIONS"])
    return replace(
        waypoint_settings(parameters),
        return_height_m=parameters["RTL_ALT"] / 100.0,
        return_climb_min_m=parameters["RTL_CLIMB_MIN"] / 100.0,
        return_cone_slope=parameters["RTL_CONE_SLOPE"],
        return_speed_m_s=parameters["RTL_SPEED"] / 100.0,
        return_loiter_s=parameters["RTL_LOIT_TIME"] / 1000.0,
        land_speed_m_s=parameters["LAND_SPEED"] / 100.0,
        land_speed_high_m_s=parameters["LAND_SPEED_HIGH"] / 100.0,
        land_slow_below_m=parameters["LAND_ALT_LOW"] / 100.0,
        disarm_delay_s=parameters["DISARM_DELAY"],
        controller_action=_CONTROLLER_ACTIONS.get(int(parameters["FS_GCS_ENABLE"]), Action.RETURN),
        continue_landing=bool(options & CONTINUE_IF_LANDING),
        continue_piloted=bool(options & CONTINUE_IF_PILOTED),
        low_battery_action=_BATTERY_ACTIONS.get(int(parameters["BATT_FS_LOW_ACT"]), Action.WARN),
        critical_battery_action=_BATTERY_ACTIONS.get(int(parameters["BATT_FS_CRT_ACT"]), Action.WARN),
        lost_position_action=_POSITION_ACTIONS.get(int(parameters["FS_EKF_ACTION"]), Action.WARN),
        fence=fence_settings(parameters, _FENCE_ACTIONS.get(int(parameters["FENCE_ACTION"])), heights=True),
    )


ARDUCOPTER = Personality(
    name="ArduCopter",
    mav_type=2,
    autopilot=AUTOPILOT,
    modes=MODES,
    mode_of=MODE_OF,
    start_mode=CopterMode.STABILIZE,
    base_mode_piloted=AUTOMATIC_BASE_MODE,
    base_mode_automatic=AUTOMATIC_BASE_MODE,
    parameters=copter_rows(),
    settings=settings,
    capabilities=64495,
    flight_software_version=VERSION_4_7,
    banner=("ArduCopter V4.7.0-dev (fieldfleet)", "simulated by sim-bridge", "Frame: QUAD/X"),
)
