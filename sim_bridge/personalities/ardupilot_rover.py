"""ArduRover steering a boat: its flight modes, parameters and failsafes."""

from __future__ import annotations

from enum import IntEnum

from sim_bridge.modes import Behaviour, ModeTraits
from sim_bridge.parameter_sets.rover import rover_rows
from sim_bridge.parameters import ParameterTable
from sim_bridge.personalities.ardupilot import (
    AUTOMATIC_BASE_MODE,
    AUTOPILOT,
    VERSION_4_7,
    fence_settings,
)
from sim_bridge.personality import Action, Personality, Settings
from sim_bridge.wording import Wording


class RoverMode(IntEnum):
    """ArduRover's `custom_mode` numbers."""

    MANUAL = 0
    HOLD = 4
    LOITER = 5
    AUTO = 10
    RTL = 11
    GUIDED = 15
    INITIALISING = 16


MODES: dict[IntEnum, ModeTraits] = {
    RoverMode.MANUAL: ModeTraits("Manual", Behaviour.PILOTED, armable=True, flown_by_pilot=True),
    RoverMode.HOLD: ModeTraits("Hold", Behaviour.BRAKE, armable=True),
    RoverMode.LOITER: ModeTraits("Loiter", Behaviour.HOLD, needs_position=True, armable=True),
    RoverMode.AUTO: ModeTraits("Auto", Behaviour.AUTO, needs_position=True, armable=True),
    RoverMode.RTL: ModeTraits("RTL", Behaviour.RETURN, needs_position=True),
    RoverMode.GUIDED: ModeTraits("Guided", Behaviour.GUIDED, needs_position=True, armable=True),
    RoverMode.INITIALISING: ModeTraits("Initialising", Behaviour.STARTING),
}
MODE_OF: dict[Behaviour, IntEnum] = {
    Behaviour.PILOTED: RoverMode.MANUAL,
    Behaviour.BRAKE: RoverMode.HOLD,
    Behaviour.HOLD: RoverMode.LOITER,
    Behaviour.AUTO: RoverMode.AUTO,
    Behaviour.RETURN: RoverMode.RTL,
    Behaviour.GUIDED: RoverMode.GUIDED,
}
_FAILSAFE_ACTIONS = {
    0: Action.WARN, 1: Action.RETURN, 2: Action.BRAKE, 3: Action.RETURN, 4: Action.RETURN, 5: Action.DISARM,
    6: Action.HOLD,
}  # fmt: skip
"""FS_ACTION and BATT_FS_LOW_ACT; SmartRTL is taken for RTL."""
_FENCE_ACTIONS = {0: Action.WARN, 1: Action.RETURN, 2: Action.BRAKE, 3: Action.RETURN, 4: Action.RETURN}
_MANUAL_BASE_MODE = 0b0100_0001
"""MAV_MODE_FLAG: custom mode, manual input."""


def settings(parameters: ParameterTable) -> Settings:
    """What ArduRover's parameters mean; they are in metres already."""
    speed_m_s = parameters["WP_SPEED"] or parameters["CRUISE_SPEED"]
    controller = _FAILSAFE_ACTIONS.get(int(parameters["FS_ACTION"]), Action.WARN)
    return Settings(
        speed_m_s=speed_m_s,
        climb_m_s=1.0,
        sink_m_s=1.0,
        acceleration_m_s2=parameters["WP_ACCEL"] or parameters["ATC_ACCEL_MAX"],
        vertical_acceleration_m_s2=1.0,
        arrival_radius_m=max(parameters["WP_RADIUS"], 2.0),
        turn_radius_m=parameters["TURN_RADIUS"],
        return_speed_m_s=parameters["RTL_SPEED"],
        target_timeout_s=parameters["GUID_TIMEOUT"],
        controller_id=int(parameters["SYSID_MYGCS"]),
        controller_timeout_s=parameters["FS_GCS_TIMEOUT"],
        controller_action=controller if parameters["FS_GCS_ENABLE"] else None,
        capacity_mah=parameters["BATT_CAPACITY"],
        low_mah=parameters["BATT_LOW_MAH"],
        critical_mah=parameters["BATT_CRT_MAH"],
        low_battery_action=_FAILSAFE_ACTIONS.get(int(parameters["BATT_FS_LOW_ACT"]), Action.WARN),
        critical_battery_action=_FAILSAFE_ACTIONS.get(int(parameters["BATT_FS_CRT_ACT"]), Action.WARN),
        lost_position_action=Action.BRAKE if parameters["FS_EKF_ACTION"] == 1 else Action.WARN,
        fence=fence_settings(parameters, _FENCE_ACTIONS.get(int(parameters["FENCE_ACTION"])), heights=False),
    )


ARDUROVER = Personality(
    name="ArduRover",
    mav_type=11,
    autopilot=AUTOPILOT,
    modes=MODES,
    mode_of=MODE_OF,
    start_mode=RoverMode.INITIALISING,
    mode_after_start=RoverMode.MANUAL,
    base_mode_piloted=_MANUAL_BASE_MODE,
    base_mode_automatic=AUTOMATIC_BASE_MODE,
    parameters=rover_rows(),
    settings=settings,
    capabilities=61935,
    flight_software_version=VERSION_4_7,
    banner=("ArduRover V4.7.0-dev (fieldfleet)", "simulated by sim-bridge"),
    wording=Wording(armed="Throttle armed", disarmed="Throttle disarmed", mode_refused="Flight mode change failed"),
    reports_landed_state=False,
)
