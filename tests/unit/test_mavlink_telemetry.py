"""Telemetry into vehicle states: clocks, missing knowledge, reboots, batteries and long texts."""

from __future__ import annotations

from typing import Any

import pytest

from vehicle_agent.adapters.ardupilot import COPTER
from vehicle_agent.adapters.mavlink_telemetry import PREARM_CHECK, StatusTexts, TelemetryFold
from vehicle_agent.domain.frames import Datum
from vehicle_agent.ports import FlightMode, Landed, VehicleState

UNIX_MS = 1_767_225_600_000


def position(boot_ms: int, **changes: int) -> dict[str, Any]:
    fields = {"lat": 365_700_000, "lon": -842_700_000, "alt": 400_000, "vx": 0, "vy": 0, "vz": 0, "hdg": 65_535}
    return {"time_boot_ms": boot_ms, **fields, **changes}


def system_time(boot_ms: int, unix_ms: int) -> dict[str, Any]:
    return {"time_unix_usec": unix_ms * 1_000, "time_boot_ms": boot_ms}


def health(battery_percent: int, passed: bool = True) -> dict[str, Any]:
    return {
        "onboard_control_sensors_present": PREARM_CHECK,
        "onboard_control_sensors_enabled": PREARM_CHECK,
        "onboard_control_sensors_health": PREARM_CHECK if passed else 0,
        "battery_remaining": battery_percent,
    }


@pytest.fixture
def fold() -> TelemetryFold:
    return TelemetryFold(Datum(36.57, -84.27), COPTER.flight_mode)


def state_of(fold: TelemetryFold, boot_ms: int) -> VehicleState:
    state = fold.fold("GLOBAL_POSITION_INT", position(boot_ms))
    assert state is not None
    return state


def test_there_is_no_state_without_time_of_day_or_place(fold: TelemetryFold) -> None:
    assert fold.fold("GLOBAL_POSITION_INT", position(100)) is None
    fold.fold("SYSTEM_TIME", system_time(200, 0))
    assert fold.fold("GLOBAL_POSITION_INT", position(300)) is None
    fold.fold("SYSTEM_TIME", system_time(400, UNIX_MS + 400))
    assert fold.fold("GLOBAL_POSITION_INT", position(500, lat=0, lon=0)) is None
    assert state_of(fold, 600).stamp_ms == UNIX_MS + 600


def test_rounding_does_not_shake_the_stamps_but_a_new_clock_is_taken(fold: TelemetryFold) -> None:
    fold.fold("SYSTEM_TIME", system_time(0, UNIX_MS))
    fold.fold("SYSTEM_TIME", system_time(1_000, UNIX_MS + 1_001))
    assert state_of(fold, 1_200).stamp_ms == UNIX_MS + 1_200
    fold.fold("SYSTEM_TIME", system_time(2_000, UNIX_MS + 9_000))
    assert state_of(fold, 2_200).stamp_ms == UNIX_MS + 9_200


def test_after_a_reboot_there_is_no_state_until_the_time_is_told_anew(fold: TelemetryFold) -> None:
    fold.fold("SYSTEM_TIME", system_time(90_000, UNIX_MS + 90_000))
    state_of(fold, 90_200)
    assert fold.fold("GLOBAL_POSITION_INT", position(500)) is None
    fold.fold("SYSTEM_TIME", system_time(700, UNIX_MS + 95_700))
    assert state_of(fold, 900).stamp_ms == UNIX_MS + 95_900


def test_readiness_needs_checks_passed_and_a_home(fold: TelemetryFold) -> None:
    fold.fold("SYSTEM_TIME", system_time(0, UNIX_MS))
    fold.fold("SYS_STATUS", health(80))
    assert not state_of(fold, 1).ready_to_arm
    fold.fold("HOME_POSITION", {"latitude": 365_700_000, "longitude": -842_700_000, "altitude": 300_000})
    assert state_of(fold, 2).ready_to_arm
    fold.fold("SYS_STATUS", health(80, passed=False))
    assert not state_of(fold, 3).ready_to_arm


def test_the_first_batterys_own_message_outranks_the_summary(fold: TelemetryFold) -> None:
    fold.fold("SYSTEM_TIME", system_time(0, UNIX_MS))
    fold.fold("SYS_STATUS", health(-1))
    assert state_of(fold, 1).battery_fraction is None
    fold.fold("SYS_STATUS", health(80))
    assert state_of(fold, 2).battery_fraction == pytest.approx(0.8)
    fold.fold("BATTERY_STATUS", {"id": 1, "battery_remaining": 5})
    fold.fold("BATTERY_STATUS", {"id": 0, "battery_remaining": 60})
    fold.fold("SYS_STATUS", health(80))
    assert state_of(fold, 3).battery_fraction == pytest.approx(0.6)


def test_modes_and_landed_states_are_in_common_words(fold: TelemetryFold) -> None:
    fold.fold("SYSTEM_TIME", system_time(0, UNIX_MS))
    fold.fold("EXTENDED_SYS_STATE", {"landed_state": 3})
    for boot_ms, (custom_mode, mode) in enumerate(
        [(4, FlightMode.GUIDED), (6, FlightMode.RETURN), (17, FlightMode.HOLD), (0, FlightMode.MANUAL), (99, None)]
    ):
        fold.fold("HEARTBEAT", {"base_mode": 0x80 | 1, "custom_mode": custom_mode})
        state = state_of(fold, boot_ms)
        assert (state.armed, state.landed) == (True, Landed.TAKING_OFF)
        assert state.mode is (mode or FlightMode.UNKNOWN)


def test_long_texts_are_put_together_and_broken_ones_told_as_far_as_they_came() -> None:
    texts = StatusTexts()
    assert texts.fold({"text": "short", "id": 0, "chunk_seq": 0}) == "short"
    assert texts.fold({"text": "a" * 50, "id": 7, "chunk_seq": 0}) is None
    assert texts.fold({"text": "b" * 50, "id": 7, "chunk_seq": 1}) is None
    assert texts.fold({"text": "end", "id": 7, "chunk_seq": 2}) == "a" * 50 + "b" * 50 + "end"
    assert texts.fold({"text": "c" * 50, "id": 8, "chunk_seq": 0}) is None
    assert texts.fold({"text": "late", "id": 9, "chunk_seq": 1}) == "late"


def distance(boot_ms: int, told_cm: int) -> dict[str, Any]:
    limits = {"min_distance": 50, "max_distance": 4_000, "orientation": 25}
    return {"time_boot_ms": boot_ms, "current_distance": told_cm, **limits}


def test_a_distance_counts_from_when_it_is_told_first() -> None:
    fold = TelemetryFold(Datum(36.57, -84.27), COPTER.flight_mode, sounding_period_s=1.0)
    fold.fold("SYSTEM_TIME", system_time(0, UNIX_MS))
    stamps = []
    for boot_ms, told_cm in (
        (200, 700),
        (400, 700),
        (600, 700),
        (800, 731),
        (1_000, 731),
        (1_800, 9_999),
        (2_000, 9_999),
    ):
        fold.fold("DISTANCE_SENSOR", distance(boot_ms, told_cm))
        sounding = state_of(fold, boot_ms + 100).sounding
        assert sounding is not None
        assert sounding.range_m == (None if told_cm > 4_000 else pytest.approx(told_cm / 100.0))
        stamps.append(sounding.stamp_ms - UNIX_MS)
    assert stamps == [200, 200, 200, 800, 800, 1_800, 1_800]


def test_the_same_distance_for_long_is_a_new_reading() -> None:
    fold = TelemetryFold(Datum(36.57, -84.27), COPTER.flight_mode, sounding_period_s=1.0)
    fold.fold("SYSTEM_TIME", system_time(0, UNIX_MS))
    stamps = set()
    for boot_ms in range(200, 4_000, 200):
        fold.fold("DISTANCE_SENSOR", distance(boot_ms, 700))
        sounding = state_of(fold, boot_ms + 100).sounding
        assert sounding is not None
        stamps.add(sounding.stamp_ms - UNIX_MS)
    assert sorted(stamps) == [200, 1_800, 3_400]
