"""What all ArduPilot firmwares share."""

from __future__ import annotations

from sim_bridge.parameters import ParameterTable
from sim_bridge.personality import Action, FenceSettings, Settings

AUTOPILOT = 3
"""MAV_AUTOPILOT_ARDUPILOTMEGA."""
VERSION_4_7 = 4 << 24 | 7 << 16
VERSION_4_6 = 4 << 24 | 6 << 16
PILOTED_BASE_MODE = 0b0101_0001
"""MAV_MODE_FLAG: custom mode, stabilised, manual input."""
AUTOMATIC_BASE_MODE = PILOTED_BASE_MODE | 0b1000
"""The same, and guided."""
_FENCE_HIGHEST, _FENCE_CIRCLE, _FENCE_ZONES, _FENCE_LOWEST = 1, 2, 4, 8
"""Bits of FENCE_TYPE."""


def fence_settings(parameters: ParameterTable, action: Action | None, heights: bool) -> FenceSettings:
    """FENCE_* as settings; vehicles on the water have no heights to keep."""
    if not parameters["FENCE_ENABLE"]:
        return FenceSettings()
    kinds = int(parameters["FENCE_TYPE"])
    return FenceSettings(
        action=action or Action.WARN,
        lowest_m=parameters["FENCE_ALT_MIN"] if heights and kinds & _FENCE_LOWEST else None,
        highest_m=parameters["FENCE_ALT_MAX"] if heights and kinds & _FENCE_HIGHEST else None,
        radius_m=parameters["FENCE_RADIUS"] if kinds & _FENCE_CIRCLE else None,
        zones=bool(kinds & _FENCE_ZONES),
    )


def waypoint_settings(parameters: ParameterTable) -> Settings:
    """What WPNAV_* and the parameters of links and batteries mean; lengths in centimetres become metres."""
    return Settings(
        speed_m_s=parameters["WPNAV_SPEED"] / 100.0,
        climb_m_s=parameters["WPNAV_SPEED_UP"] / 100.0,
        sink_m_s=parameters["WPNAV_SPEED_DN"] / 100.0,
        acceleration_m_s2=parameters["WPNAV_ACCEL"] / 100.0,
        vertical_acceleration_m_s2=parameters["WPNAV_ACCEL_Z"] / 100.0,
        arrival_radius_m=parameters["WPNAV_RADIUS"] / 100.0,
        target_timeout_s=parameters["GUID_TIMEOUT"],
        controller_id=int(parameters["SYSID_MYGCS"]),
        controller_timeout_s=parameters["FS_GCS_TIMEOUT"],
        capacity_mah=parameters["BATT_CAPACITY"],
        low_mah=parameters["BATT_LOW_MAH"],
        critical_mah=parameters["BATT_CRT_MAH"],
    )
