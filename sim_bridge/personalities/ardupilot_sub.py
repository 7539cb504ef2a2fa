"""ArduSub: its flight modes, parameters and failsafes."""

from __future__ import annotations

from dataclasses import replace
from enum import IntEnum

from sim_bridge.modes import Behaviour, ModeTraits
from sim_bridge.parameter_sets.submarine import submarine_rows
from sim_bridge.parameters import ParameterTable
from sim_bridge.personalities.ardupilot import (
    AUTOMATIC_BASE_MODE,
    AUTOPILOT,
    PILOTED_BASE_MODE,
    VERSION_4_6,
    fence_settings,
    waypoint_settings,
)
from sim_bridge.personality import Action, Personality, Settings
from sim_bridge.wording import Wording


class SubMode(IntEnum):
    """ArduSub's `custom_mode` numbers."""

    STABILIZE = 0
    ALT_HOLD = 2
    AUTO = 3
    GUIDED = 4
    SURFACE = 9
    POSHOLD = 16
    MANUAL = 19
    SURFTRAK = 21


MODES: dict[IntEnum, ModeTraits] = {
    SubMode.MANUAL: ModeTraits("MANUAL", Behaviour.PILOTED, armable=True, flown_by_pilot=True),
    SubMode.STABILIZE: ModeTraits("STABILIZE", Behaviour.PILOTED, armable=True, flown_by_pilot=True),
    SubMode.ALT_HOLD: ModeTraits("ALT_HOLD", Behaviour.DEPTH_HOLD, armable=True, flown_by_pilot=True),
    SubMode.AUTO: ModeTraits("AUTO", Behaviour.AUTO, needs_position=True, armable=True),
    SubMode.GUIDED: ModeTraits("GUIDED", Behaviour.GUIDED, needs_position=True, armable=True),
    SubMode.SURFACE: ModeTraits("SURFACE", Behaviour.SURFACE, armable=True),
    SubMode.POSHOLD: ModeTraits("POSHOLD", Behaviour.HOLD, needs_position=True, armable=True, flown_by_pilot=True),
    SubMode.SURFTRAK: ModeTraits("SURFTRAK", Behaviour.TRACK_BOTTOM, armable=True, flown_by_pilot=True),
}
MODE_OF: dict[Behaviour, IntEnum] = {
    Behaviour.PILOTED: SubMode.MANUAL,
    Behaviour.DEPTH_HOLD: SubMode.ALT_HOLD,
    Behaviour.HOLD: SubMode.POSHOLD,
    Behaviour.AUTO: SubMode.AUTO,
    Behaviour.GUIDED: SubMode.GUIDED,
    Behaviour.SURFACE: SubMode.SURFACE,
}
_CONTROLLER_ACTIONS = {0: None, 1: Action.WARN, 2: Action.DISARM, 3: Action.DEPTH_HOLD, 4: Action.SURFACE}
"""FS_GCS_ENABLE."""
_LEAK_ACTIONS = {0: None, 1: Action.WARN, 2: Action.SURFACE}
"""FS_LEAK_ENABLE."""
_BATTERY_ACTIONS = {0: Action.WARN, 2: Action.DISARM, 3: Action.SURFACE}
_FENCE_ACTIONS = {0: Action.WARN, 1: Action.SURFACE}


def settings(parameters: ParameterTable) -> Settings:
    """What ArduSub's parameters mean; lengths in centimetres become metres."""
    return replace(
        waypoint_settings(parameters),
        controller_action=_CONTROLLER_ACTIONS.get(int(parameters["FS_GCS_ENABLE"]), Action.WARN),
        low_battery_action=_BATTERY_ACTIONS.get(int(parameters["BATT_FS_LOW_ACT"]), Action.WARN),
        critical_battery_action=_BATTERY_ACTIONS.get(int(parameters["BATT_FS_CRT_ACT"]), Action.WARN),
        leak_action=_LEAK_ACTIONS.get(int(parameters["FS_LEAK_ENABLE"]), Action.WARN),
        bottom_tracking_depth_m=-parameters["SURFTRAK_DEPTH"] / 100.0,
        surface_depth_m=-parameters["SURFACE_DEPTH"] / 100.0,
        fence=fence_settings(parameters, _FENCE_ACTIONS.get(int(parameters["FENCE_ACTION"])), heights=True),
    )


ARDUSUB = Personality(
    name="ArduSub",
    mav_type=12,
    autopilot=AUTOPILOT,
    modes=MODES,
    mode_of=MODE_OF,
    start_mode=SubMode.MANUAL,
    base_mode_piloted=PILOTED_BASE_MODE,
    base_mode_automatic=AUTOMATIC_BASE_MODE,
    parameters=submarine_rows(),
    settings=settings,
    capabilities=63975,
    flight_software_version=VERSION_4_6,
    banner=("ArduSub V4.6.0-dev (fieldfleet)", "simulated by sim-bridge", "Frame: VECTORED_6DOF"),
    wording=Wording(mode_refused="Mode change failed: {title} {reason}"),
    reports_landed_state=False,
)
