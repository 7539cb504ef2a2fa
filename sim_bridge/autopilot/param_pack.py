"""ArduPilot's packed parameter file, `@PARAM/param.pck`: all parameters in a few kilobytes.

Header: magic, number of parameters in the file, number of all, 16 bits each. Then per parameter a byte with type (low
half) and flags (bit 4: a default follows the value), a byte with how many characters it shares with the name before
(low half) and how many more it has less one (high half), those characters, and the value in its own size.
"""

from __future__ import annotations

import struct

from sim_bridge.parameters import ParameterTable, ParameterType, stored_value

MAGIC = 0x671B
MAGIC_WITH_DEFAULTS = 0x671C
HAS_DEFAULT = 1 << 4
MOST_SHARED = 15
FORMATS = {
    ParameterType.INT8: (1, "<b"),
    ParameterType.INT16: (2, "<h"),
    ParameterType.INT32: (3, "<i"),
    ParameterType.REAL32: (4, "<f"),
}


def packed_parameters(table: ParameterTable, with_defaults: bool = False, first: int = 0, most: int = 0xFFFF) -> bytes:
    """The file's content, from the parameter number `first` on; `most`: at most so many."""
    chosen = range(min(first, len(table)), min(first + most, len(table)))
    magic = MAGIC_WITH_DEFAULTS if with_defaults else MAGIC
    parts = [struct.pack("<HHH", magic, len(chosen), len(table))]
    before = b""
    for index in chosen:
        row, value = table.at(index)
        number, form = FORMATS[row.kind]
        name = row.name.encode("ascii")
        shared = _shared(before, name)
        numbers = _value(form, value)
        default = stored_value(row.kind, row.default)
        flags = HAS_DEFAULT if with_defaults and default != value else 0
        if flags:
            numbers += _value(form, default)
        parts.append(bytes((number | flags, shared | len(name) - shared - 1 << 4)) + name[shared:] + numbers)
        before = name
    return b"".join(parts)


def _value(form: str, value: float) -> bytes:
    return struct.pack(form, value if form == "<f" else int(value))


def _shared(before: bytes, name: bytes) -> int:
    """How many characters two names begin with in common; one of the new name's is always left over."""
    most = min(len(before), len(name) - 1, MOST_SHARED)
    for length in range(most):
        if before[length] != name[length]:
            return length
    return most
