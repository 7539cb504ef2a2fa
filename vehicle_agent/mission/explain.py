"""Turns what is wrong with a mission file's values into a sentence: the key's path first, the mend last."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from vehicle_agent.mission.model import ADDRESS_PATTERN
from vehicle_agent.mission.schema import allowed_values
from vehicle_agent.mission.tables import LINE_PATTERN
from vehicle_agent.mission.vehicles import CONNECTION_PATTERN
from vehicle_agent.wire.messages import NAME_PATTERN

_PATTERN_WORDS = {
    NAME_PATTERN: "must be at most 31 lower-case letters, digits and dashes, a letter first",
    LINE_PATTERN: "must be one line of printable characters",
    ADDRESS_PATTERN: "must be a host name or an IP address",
    CONNECTION_PATTERN: "must be a MAVSDK connection URL such as 'udpin://0.0.0.0:14540', 'tcpout://10.0.0.7:5760' or "
    "'serial:///dev/ttyUSB0:57600'",
}


def explain_refusal(error: str) -> str:
    """Turn msgspec's text, e.g. ``Expected `int` >= 0 - at `$.seed```, into a sentence."""
    trouble, _, path = error.rpartition(" - at `")
    if not trouble:
        trouble, path = error, ""
    key = path.removesuffix("`").removeprefix("$").removeprefix(".")
    for opening, ending in (
        ("Object contains unknown field `", "unknown key; remove it or correct its spelling"),
        ("Object missing required field `", "missing; add it"),
    ):
        if trouble.startswith(opening):
            name = trouble.removeprefix(opening).removesuffix("`")
            place = f"{key}.{name}" if key else name
            return f"{place}: {ending} (`missions schema` lists every key)"
    key = key or "the file"
    for pattern, words in _PATTERN_WORDS.items():
        if repr(pattern) in trouble or pattern in trouble:
            return f"{key}: {words}"
    if trouble.startswith(("Invalid value", "Invalid enum value")):
        found = trouble.removeprefix("Invalid ").removeprefix("enum ").removeprefix("value ")
        allowed = ", ".join(repr(value) for value in allowed_values(key))
        return f"{key}: {found} is not known; choose {allowed}" if allowed else f"{key}: {found} is not allowed"
    plain = _in_toml_words(trouble[0].lower() + trouble[1:])
    return f"{key}: {plain}; correct the value (`missions schema` lists what is allowed)"


def non_finite_keys(value: Any, path: str = "") -> Iterator[tuple[str, float]]:
    """Paths and values of all numbers in a parsed file that are NaN or infinite."""
    if isinstance(value, dict):
        for key, item in value.items():
            yield from non_finite_keys(item, f"{path}.{key}" if path else str(key))
    elif isinstance(value, list | tuple):
        for index, item in enumerate(value):
            yield from non_finite_keys(item, f"{path}[{index}]")
    elif isinstance(value, float) and not math.isfinite(value):
        yield path, value


def _in_toml_words(text: str) -> str:
    """Name types as TOML names them."""
    for theirs, ours in (
        ("`object | null`", "a table"),
        ("`array | null`", "an array"),
        ("`float | null`", "a number"),
        ("`int | null`", "a whole number"),
        ("`str | null`", "a string"),
        ("`object`", "a table"),
        ("`array`", "an array"),
        ("`float`", "a number"),
        ("`int`", "a whole number"),
        ("`str`", "a string"),
        ("`bool`", "a boolean"),
    ):
        text = text.replace(theirs, ours)
    return text
