"""A vehicle's parameters, under ArduPilot's names: a table by name and by index, with types, ranges and defaults.

What there is stands in `sim_bridge.parameter_sets`, one file per firmware.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
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
_WORDS = {
    "int8": ParameterType.INT8,
    "int16": ParameterType.INT16,
    "int32": ParameterType.INT32,
    "real": ParameterType.REAL32,
}


@dataclass(frozen=True, slots=True)
class Parameter:
    """One row of the table.

    Attributes
    ----------
    name
        At most 16 characters.
    kind
        How it is stored.
    default
        Its value at the start.
    low, high
        Values that the vehicle obeys; others are refused. Infinite when any value of its type will do, as with most.
    """

    name: str
    kind: ParameterType
    default: float
    low: float = -math.inf
    high: float = math.inf

    def __post_init__(self) -> None:
        if not 1 <= len(self.name) <= 16:
            raise ValueError(f"{self.name!r} must have 1 to 16 characters")


def parameter_rows(text: str) -> tuple[Parameter, ...]:
    """Read a table: one `NAME TYPE DEFAULT [LOW HIGH]` a line; empty lines and those that begin with # are skipped."""
    rows = []
    for line in text.splitlines():
        words = line.split()
        if words and not words[0].startswith("#"):
            name, kind, *numbers = words
            rows.append(Parameter(name, _WORDS[kind], *map(float, numbers)))
    return tuple(rows)


def stored_value(kind: ParameterType, value: float) -> float:
    """The value as its type can hold it: integers rounded, everything limited to what fits (as ArduPilot does)."""
    if kind is ParameterType.REAL32:
        return float(np.float32(min(max(value, -3.4e38), 3.4e38)))
    most = 2 ** (_BITS[kind] - 1)
    return float(min(max(math.floor(value + 0.5), -most), most - 1))


class ParameterTable:
    """Parameters by name and by index; indices never change.

    Example
    -------
    ::

        table = ParameterTable(parameter_rows("RTL_ALT int32 1500"), {"RTL_ALT": 3000})
        table["RTL_ALT"]                  # 3000.0
    """

    __slots__ = ("_index", "_rows", "_values")

    def __init__(self, rows: Iterable[Parameter], overrides: dict[str, float]) -> None:
        self._rows = tuple(rows)
        self._index = {row.name: index for index, row in enumerate(self._rows)}
        if len(self._index) != len(self._rows):
            raise ValueError("two parameters have the same name")
        self._values = [stored_value(row.kind, row.default) for row in self._rows]
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

    def get(self, name: str, default: float) -> float:
        """Value of a parameter, `default` when this firmware has none of that name."""
        index = self._index.get(name)
        return default if index is None else self._values[index]

    def at(self, index: int) -> tuple[Parameter, float]:
        """Row and value by index, IndexError when it is out of range."""
        if not 0 <= index < len(self._rows):
            raise IndexError(index)
        return self._rows[index], self._values[index]

    def index_of(self, name: str) -> int:
        """Index by name, KeyError when there is none of that name."""
        return self._index[name]

    def set(self, name: str, value: float) -> bool:
        """Store a value as its type can hold it; False for an unknown name, no number, or one out of its range."""
        if name not in self._index or not math.isfinite(value):
            return False
        index = self._index[name]
        row = self._rows[index]
        stored = stored_value(row.kind, value)
        if not row.low <= stored <= row.high:
            return False
        self._values[index] = stored
        return True
