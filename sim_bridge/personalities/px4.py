"""PX4 flying a multicopter: packed flight modes, parameters by other names, offboard flight, its own failsafes."""

from __future__ import annotations

import math
from enum import IntEnum

from sim_bridge.modes import Behaviour, ModeTraits
from sim_bridge.parameter_sets.px4 import px4_rows
from sim_bridge.parameters import ParameterTable
from sim_bridge.personality import Action, FenceSettings, Personality, Settings
from sim_bridge.wording import Wording


def packed(main: int, sub: int = 0) -> int:
    """PX4's `custom_mode`: main mode in byte 2, sub mode in byte 3."""
    return main << 16 | sub << 24


class Px4Mode(IntEnum):
    """PX4's `custom_mode` numbers."""

    MANUAL = packed(1)
    ALTCTL = packed(2)
    POSCTL = packed(3)
    AUTO_TAKEOFF = packed(4, 2)
    AUTO_LOITER = packed(4, 3)
    AUTO_MISSION = packed(4, 4)
    AUTO_RTL = packed(4, 5)
    AUTO_LAND = packed(4, 6)
    OFFBOARD = packed(6)
    STABILIZED = packed(7)


MODES: dict[IntEnum, ModeTraits] = {
    Px4Mode.MANUAL: ModeTraits("Manual", Behaviour.PILOTED, armable=True, flown_by_pilot=True),
    Px4Mode.STABILIZED: ModeTraits("Stabilized", Behaviour.PILOTED, armable=True, flown_by_pilot=True),
    Px4Mode.ALTCTL: ModeTraits("Altitude", Behaviour.PILOTED, armable=True, flown_by_pilot=True),
    Px4Mode.POSCTL: ModeTraits("Position", Behaviour.PILOTED, needs_position=True, armable=True, flown_by_pilot=True),
    Px4Mode.AUTO_TAKEOFF: ModeTraits("Takeoff", Behaviour.TAKE_OFF, needs_position=True, armable=True),
    Px4Mode.AUTO_LOITER: ModeTraits("Hold", Behaviour.HOLD, needs_position=True, armable=True),
    Px4Mode.AUTO_MISSION: ModeTraits("Mission", Behaviour.AUTO, needs_position=True, armable=True),
    Px4Mode.AUTO_RTL: ModeTraits("Return", Behaviour.RETURN, needs_position=True),
    Px4Mode.AUTO_LAND: ModeTraits("Land", Behaviour.LAND),
    Px4Mode.OFFBOARD: ModeTraits("Offboard", Behaviour.GUIDED, needs_position=True, armable=True),
}
MODE_OF: dict[Behaviour, IntEnum] = {
    Behaviour.PILOTED: Px4Mode.POSCTL,
    Behaviour.HOLD: Px4Mode.AUTO_LOITER,
    Behaviour.BRAKE: Px4Mode.AUTO_LOITER,
    Behaviour.GUIDED: Px4Mode.OFFBOARD,
    Behaviour.AUTO: Px4Mode.AUTO_MISSION,
    Behaviour.TAKE_OFF: Px4Mode.AUTO_TAKEOFF,
    Behaviour.RETURN: Px4Mode.AUTO_RTL,
    Behaviour.LAND: Px4Mode.AUTO_LAND,
}
_LINK_ACTIONS = {0: None, 1: Action.HOLD, 2: Action.RETURN, 3: Action.LAND, 5: Action.DISARM, 6: Action.DISARM}
"""NAV_DLL_ACT."""
_OFFBOARD_ACTIONS = {
    0: Action.HOLD, 1: Action.HOLD, 2: Action.HOLD, 3: Action.RETURN, 4: Action.LAND, 5: Action.HOLD, 6: Action.DISARM,
}  # fmt: skip
"""COM_OBL_RC_ACT; without sticks the piloted modes hold."""
_FENCE_ACTIONS = {0: None, 1: Action.WARN, 2: Action.HOLD, 3: Action.RETURN, 4: Action.DISARM, 5: Action.LAND}


def settings(parameters: ParameterTable) -> Settings:
    """What PX4's parameters mean."""
    battery = int(parameters["COM_LOW_BAT_ACT"])
    capacity_mah = parameters["BAT1_CAPACITY"]
    fence = _FENCE_ACTIONS.get(int(parameters["GF_ACTION"]))
    return Settings(
        speed_m_s=parameters["MPC_XY_CRUISE"],
        climb_m_s=parameters["MPC_Z_V_AUTO_UP"],
        sink_m_s=parameters["MPC_Z_V_AUTO_DN"],
        acceleration_m_s2=parameters["MPC_ACC_HOR"],
        vertical_acceleration_m_s2=min(parameters["MPC_ACC_UP_MAX"], parameters["MPC_ACC_DOWN_MAX"]),
        arrival_radius_m=parameters["NAV_ACC_RAD"],
        takeoff_height_m=parameters["MIS_TAKEOFF_ALT"],
        return_height_m=parameters["RTL_RETURN_ALT"],
        return_cone_slope=math.tan(math.radians(90.0 - min(max(parameters["RTL_CONE_ANG"], 1.0), 63.0))),
        return_loiter_s=max(0.0, parameters["RTL_LAND_DELAY"]),
        land_speed_m_s=parameters["MPC_LAND_SPEED"],
        land_slow_below_m=parameters["MPC_LAND_ALT1"],
        disarm_delay_s=max(0.0, parameters["COM_DISARM_PRFLT"]),
        landed_disarm_delay_s=parameters["COM_DISARM_LAND"],
        target_timeout_s=parameters["COM_OF_LOSS_T"],
        positions_expire=True,
        expired_target_action=_OFFBOARD_ACTIONS.get(int(parameters["COM_OBL_RC_ACT"]), Action.HOLD),
        controller_id=None,
        controller_timeout_s=parameters["COM_DL_LOSS_T"],
        controller_action=_LINK_ACTIONS.get(int(parameters["NAV_DLL_ACT"])),
        capacity_mah=capacity_mah,
        low_mah=parameters["BAT_LOW_THR"] * capacity_mah,
        critical_mah=parameters["BAT_CRIT_THR"] * capacity_mah,
        low_battery_action=Action.WARN,
        critical_battery_action={1: Action.RETURN, 2: Action.LAND, 3: Action.RETURN}.get(battery, Action.WARN),
        lost_position_action=Action.LAND,
        fence=FenceSettings(
            action=fence,
            highest_m=parameters["GF_MAX_VER_DIST"] or None,
            radius_m=parameters["GF_MAX_HOR_DIST"] or None,
            zones=True,
        ),
    )


WORDING = Wording(
    origin_set="",
    position_used="",
    armed="Armed by external command",
    disarmed="Disarmed by external command",
    crashed="Disarmed by failure detector",
    arming_refused="Arming denied: {problem}",
    not_ready="Preflight Fail: {problem}",
    mode_refused="Switching to mode '{title}' is currently not possible",
    failsafe="Failsafe activated",
    controller_back="GCS connection regained",
    position_back="",
    battery_low="Low battery level, return advised",
    battery_critical="Critical battery level, land now",
    fence_breached="Geofence violation",
    fence_cleared="",
    position_lost="",
    position_failsafe="Failsafe activated",
)

PX4 = Personality(
    name="PX4",
    mav_type=2,
    autopilot=12,
    modes=MODES,
    mode_of=MODE_OF,
    start_mode=Px4Mode.AUTO_LOITER,
    base_mode_piloted=0b0101_0001,
    base_mode_automatic=0b0001_1101,
    parameters=px4_rows(),
    settings=settings,
    capabilities=0xE0FF,
    flight_software_version=1 << 24 | 15 << 16 | 4 << 8 | 255,
    banner=("PX4 v1.15.4 (fieldfleet)", "simulated by sim-bridge"),
    bytewise_parameters=True,
    guided_behaviour=Behaviour.HOLD,
    takes_off_in_guided=False,
    packed_modes=True,
    takeoff_altitude_amsl=True,
    fresh_targets_first=True,
    wording=WORDING,
    system_id_parameter="MAV_SYS_ID",
)
