"""The simulated copter's parameters, under ArduPilot's names, types and defaults."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum

import numpy as np


class ParameterType(IntEnum):
    """MAVLink's MAV_PARAM_TYPE."""

    INT8 = 2
    INT16 = 4
    INT32 = 6
    REAL32 = 9


_BITS = {ParameterType.INT8: 8, ParameterType.INT16: 16, ParameterType.INT32: 32}


@dataclass(frozen=True, slots=True)
class Parameter:
    """One row of the table: what it is called, how it is stored and what it is at the start."""

    name: str
    kind: ParameterType
    default: float


def _table() -> tuple[Parameter, ...]:
    int8, int16, int32, real = ParameterType.INT8, ParameterType.INT16, ParameterType.INT32, ParameterType.REAL32
    rows = (
        ("FORMAT_VERSION", int16, 120),
        ("SYSID_THISMAV", int16, 1),
        ("SYSID_MYGCS", int16, 255),
        ("PILOT_THR_FILT", real, 0),
        ("PILOT_TKOFF_ALT", real, 0),
        ("RTL_ALT", int32, 1500),
        ("RTL_CONE_SLOPE", real, 3),
        ("RTL_SPEED", int16, 0),
        ("RTL_ALT_FINAL", int16, 0),
        ("RTL_CLIMB_MIN", int16, 0),
        ("RTL_LOIT_TIME", int32, 5000),
        ("RTL_ALT_TYPE", int8, 0),
        ("FS_GCS_ENABLE", int8, 0),
        ("FS_GCS_TIMEOUT", real, 5),
        ("FS_OPTIONS", int32, 16),
        ("FS_THR_ENABLE", int8, 0),
        ("FS_CRASH_CHECK", int8, 1),
        ("FS_EKF_ACTION", int8, 1),
        ("DISARM_DELAY", int8, 10),
        ("LAND_SPEED", int16, 50),
        ("LAND_SPEED_HIGH", int16, 0),
        ("LAND_ALT_LOW", int16, 1000),
        ("WPNAV_SPEED", real, 1000),
        ("WPNAV_RADIUS", real, 200),
        ("WPNAV_SPEED_UP", real, 250),
        ("WPNAV_SPEED_DN", real, 150),
        ("WPNAV_ACCEL", real, 250),
        ("WPNAV_ACCEL_Z", real, 100),
        ("WPNAV_JERK", real, 1),
        ("WP_YAW_BEHAVIOR", int8, 2),
        ("GUID_TIMEOUT", real, 3),
        ("GUID_OPTIONS", int32, 0),
        ("ARMING_CHECK", int32, 1),
        ("ARMING_REQUIRE", int8, 1),
        ("BATT_MONITOR", int8, 4),
        ("BATT_CAPACITY", int32, 5000),
        ("BATT_LOW_VOLT", real, 0),
        ("BATT_LOW_MAH", real, 500),
        ("BATT_CRT_VOLT", real, 0),
        ("BATT_CRT_MAH", real, 200),
        ("BATT_FS_LOW_ACT", int8, 2),
        ("BATT_FS_CRT_ACT", int8, 1),
        ("FENCE_ENABLE", int8, 0),
        ("FENCE_ACTION", int8, 1),
        ("FRAME_CLASS", int8, 1),
        ("FRAME_TYPE", int8, 1),
        ("GPS_TYPE", int8, 1),
        ("COMPASS_USE", int8, 1),
        ("AHRS_EKF_TYPE", int8, 3),
        ("EK3_ENABLE", int8, 1),
        ("SCHED_LOOP_RATE", int16, 400),
        ("LOG_BITMASK", int32, 176126),
        ("MOT_THST_HOVER", real, 0.39),
        ("SIM_SPEEDUP", real, 1),
        ("STAT_BOOTCNT", int16, 1),
    )
    return tuple(Parameter(name, kind, default) for name, kind, default in rows)


class ParameterTable:
    """Parameters by name and by index; indices never change, FORMAT_VERSION is number 0."""

    __slots__ = ("_index", "_rows", "_values")

    def __init__(self, overrides: dict[str, float]) -> None:
        self._rows = _table()
        self._index = {row.name: index for index, row in enumerate(self._rows)}
        self._values = [float(np.float32(row.default)) for row in self._rows]
        for name, value in overrides.items():
            self.set(name, value)

    def __len__(self) -> int:
        return len(self._rows)

    def __iter__(self) -> Iterator[str]:
        return (row.name for row in self._rows)

    def __contains__(self, name: object) -> bool:
        return name in self._index

    def __getitem__(self, name: str) -> float:
        """Return the value of a parameter, KeyError when there is none of that name."""
        return self._values[self._index[name]]

    def at(self, index: int) -> tuple[Parameter, float]:
        """Row and value by index, IndexError when it is out of range."""
        if not 0 <= index < len(self._rows):
            raise IndexError(index)
        return self._rows[index], self._values[index]

    def index_of(self, name: str) -> int:
        """Index by name, KeyError when there is none of that name."""
        return self._index[name]

    def set(self, name: str, value: float) -> bool:
        """Store a value as its type can hold it; False for an unknown name or a value that is no number."""
        if name not in self._index or not math.isfinite(value):
            return False
        index = self._index[name]
        kind = self._rows[index].kind
        if kind is ParameterType.REAL32:
            stored = float(np.float32(min(max(value, -3.4e38), 3.4e38)))
        else:
            most = 2 ** (_BITS[kind] - 1)
            stored = float(min(max(math.floor(value + 0.5), -most), most - 1))
        self._values[index] = stored
        return True
