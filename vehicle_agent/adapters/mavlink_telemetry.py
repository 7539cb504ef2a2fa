"""Folds an autopilot's telemetry into vehicle states of the mission's frame. No I/O and no clock."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from vehicle_agent.domain.frames import Datum, Geodetic, Point, ned_to_enu
from vehicle_agent.ports import FlightMode, Landed, Sounding, VehicleState

ARMED_FLAG = 128
"""MAV_MODE_FLAG_SAFETY_ARMED."""
PREARM_CHECK = 0x1000_0000
"""MAV_SYS_STATUS_PREARM_CHECK."""
UNKNOWN_HEADING_CDEG = 65_535
CLOCK_STEP_MS = 50
"""Differences between Unix time and boot time smaller than this are rounding, not a new clock."""
DOWNWARDS = 25
"""MAV_SENSOR_ROTATION_PITCH_270: straight down through the keel."""
ALIKE_PERIODS = 1.5
"""A distance that stays the same for so many periods of its sensor has been measured again."""
REBOOT_MS = 1_000
"""A boot time that falls back by more than this is another boot, not reordering."""

LANDED: Mapping[int, Landed] = MappingProxyType(
    {1: Landed.ON_GROUND, 2: Landed.IN_AIR, 3: Landed.TAKING_OFF, 4: Landed.LANDING}
)
"""MAV_LANDED_STATE."""

FOLDED_MESSAGES = (
    "HEARTBEAT",
    "SYSTEM_TIME",
    "GLOBAL_POSITION_INT",
    "EXTENDED_SYS_STATE",
    "SYS_STATUS",
    "BATTERY_STATUS",
    "HOME_POSITION",
    "DISTANCE_SENSOR",
)

Fields = Mapping[str, Any]


class TelemetryFold:
    """What is known of the vehicle so far; a new `VehicleState` comes with every position.

    There is no state before the autopilot knows both the time of day and where it is.

    Parameters
    ----------
    sounding_period_s
        Between two readings of its downward beam. An autopilot tells its last reading whenever it is asked and not when
        it was taken: so it is asked more often, and a distance counts from when it is told first.

    Attributes
    ----------
    time_ms
        Latest Unix time heard from the autopilot; None before SYSTEM_TIME.
    home_enu_m
        Where it returns to; None until it has told.
    rival_controller
        Set by the owner when another component speaks with the agent's system id; sticks.
    """

    def __init__(self, datum: Datum, flight_mode: Callable[[int], FlightMode], sounding_period_s: float = 0.0) -> None:
        self.time_ms: int | None = None
        self.home_enu_m: Point | None = None
        self.rival_controller = False
        self._datum = datum
        self._flight_mode = flight_mode
        self._unix_minus_boot_ms: int | None = None
        self._boot_ms = 0
        self._armed = False
        self._mode = FlightMode.UNKNOWN
        self._landed = Landed.UNKNOWN
        self._battery_fraction: float | None = None
        self._prearm_passed = False
        self._sounding: Sounding | None = None
        self._told_cm = -1
        self._same_for_ms = ALIKE_PERIODS * 1_000.0 * sounding_period_s
        self._has_battery_status = False

    def fold(self, name: str, fields: Fields) -> VehicleState | None:
        """Take one message in; returns the new state when it was a position."""
        match name:
            case "HEARTBEAT":
                self._armed = bool(fields["base_mode"] & ARMED_FLAG)
                self._mode = self._flight_mode(fields["custom_mode"])
            case "SYSTEM_TIME":
                self._set_clock(fields["time_unix_usec"] // 1_000, fields["time_boot_ms"])
            case "EXTENDED_SYS_STATE":
                self._landed = LANDED.get(fields["landed_state"], Landed.UNKNOWN)
            case "SYS_STATUS":
                self._fold_health(fields)
            case "BATTERY_STATUS" if fields["id"] == 0:
                self._has_battery_status = True
                self._set_battery(fields["battery_remaining"])
            case "HOME_POSITION":
                self.home_enu_m = self._enu(fields["latitude"], fields["longitude"], fields["altitude"])
            case "DISTANCE_SENSOR" if fields["orientation"] == DOWNWARDS:
                self._fold_sounding(fields)
            case "GLOBAL_POSITION_INT":
                return self._state(fields)
        return None

    def _fold_sounding(self, fields: Fields) -> None:
        """Take a distance in; one at or beyond the sensor's limits measures nothing."""
        if self._unix_minus_boot_ms is None:
            return
        told_cm, stamp_ms = fields["current_distance"], fields["time_boot_ms"] + self._unix_minus_boot_ms
        known = self._sounding
        if known is not None and told_cm == self._told_cm and 0 <= stamp_ms - known.stamp_ms < self._same_for_ms:
            return  # the last reading, told again
        within = fields["min_distance"] <= told_cm <= fields["max_distance"]
        self._told_cm, self._sounding = told_cm, Sounding(stamp_ms, told_cm * 0.01 if within else None)

    def _fold_health(self, fields: Fields) -> None:
        wanted = fields["onboard_control_sensors_present"] & fields["onboard_control_sensors_enabled"]
        self._prearm_passed = bool(wanted & fields["onboard_control_sensors_health"] & PREARM_CHECK)
        if not self._has_battery_status:
            self._set_battery(fields["battery_remaining"])

    def _set_battery(self, remaining_percent: int) -> None:
        known = 0 <= remaining_percent <= 100
        self._battery_fraction = remaining_percent / 100.0 if known else None

    def _set_clock(self, unix_ms: int, boot_ms: int) -> None:
        if unix_ms == 0:  # the autopilot does not know the time of day yet
            return
        offset_ms = unix_ms - boot_ms
        if self._unix_minus_boot_ms is None or abs(offset_ms - self._unix_minus_boot_ms) >= CLOCK_STEP_MS:
            self._unix_minus_boot_ms = offset_ms
        self.time_ms = unix_ms

    def _state(self, fields: Fields) -> VehicleState | None:
        if fields["time_boot_ms"] < self._boot_ms - REBOOT_MS:
            self._unix_minus_boot_ms = None  # it booted anew: its old clock means nothing until it tells the time
        self._boot_ms = fields["time_boot_ms"]
        if self._unix_minus_boot_ms is None or (fields["lat"] == 0 and fields["lon"] == 0):
            return None
        stamp_ms = fields["time_boot_ms"] + self._unix_minus_boot_ms
        self.time_ms = max(stamp_ms, self.time_ms or 0)
        heading_cdeg = fields["hdg"]
        return VehicleState(
            stamp_ms=stamp_ms,
            position_enu_m=self._enu(fields["lat"], fields["lon"], fields["alt"]),
            velocity_enu_m_s=ned_to_enu((fields["vx"] * 0.01, fields["vy"] * 0.01, fields["vz"] * 0.01)),
            heading_deg=0.0 if heading_cdeg == UNKNOWN_HEADING_CDEG else math.fmod(heading_cdeg * 0.01, 360.0),
            armed=self._armed,
            landed=self._landed,
            mode=self._mode,
            battery_fraction=self._battery_fraction,
            ready_to_arm=self._prearm_passed and self.home_enu_m is not None,
            home_enu_m=self.home_enu_m,
            rival_controller=self.rival_controller,
            sounding=self._sounding,
        )

    def _enu(self, latitude_e7: int, longitude_e7: int, altitude_mm: int) -> Point:
        return self._datum.to_enu(Geodetic(latitude_e7 * 1e-7, longitude_e7 * 1e-7, altitude_mm * 1e-3))


class StatusTexts:
    """Puts long STATUSTEXTs together again from their chunks."""

    CHUNK_CHARACTERS = 50

    def __init__(self) -> None:
        self._open: tuple[int, list[str]] = (0, [])

    def fold(self, fields: Fields) -> str | None:
        """Take a STATUSTEXT in; returns the text once it is whole."""
        text, text_id, chunk = str(fields["text"]), int(fields.get("id", 0)), int(fields.get("chunk_seq", 0))
        if text_id == 0:
            return text
        open_id, parts = self._open
        if open_id != text_id or len(parts) != chunk:
            parts = []  # another text, or a chunk was lost: tell what there is
        parts.append(text)
        self._open = (text_id, parts)
        if len(text) < self.CHUNK_CHARACTERS:
            self._open = (0, [])
            return "".join(parts)
        return None
