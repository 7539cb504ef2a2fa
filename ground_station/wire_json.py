"""Inputs of the picture as JSON objects with schemas, and back: what a recording is made of."""

from __future__ import annotations

import types
import typing
from enum import IntEnum
from typing import Any

import msgspec

from ground_station.inputs import (
    Acknowledged,
    AliveChanged,
    AutopilotHeard,
    CommandSent,
    FleetInput,
    Heard,
    LinkCounted,
    Muted,
    Tick,
)
from vehicle_agent.wire.keys import TOPICS, topic_of
from vehicle_agent.wire.messages import AnyMessage, Command

STATION_TOPICS: dict[str, type[FleetInput]] = {
    "tick": Tick,
    "alive": AliveChanged,
    "sent": CommandSent,
    "link": LinkCounted,
    "acknowledged": Acknowledged,
    "muted": Muted,
    "autopilot": AutopilotHeard,
}
"""Inputs of the station's own, by the last part of their topic."""
HEARD_S = "station_s"
"""Field with the station's time, seconds, beside a message's own fields."""
_MESSAGES = {topic.name: topic.message for topic in TOPICS if topic.over_radio}


def topic_name(event: FleetInput) -> str:
    """Last part of the topic on which an input is recorded."""
    if isinstance(event, Heard):
        return topic_of(event.message).name
    return next(name for name, kind in STATION_TOPICS.items() if isinstance(event, kind))


def to_object(event: FleetInput) -> dict[str, Any]:
    """An input as a JSON object; enumerations are lower-case words, bytes are base64."""
    if isinstance(event, Heard):
        return {HEARD_S: event.arrival_s, **_message_object(event.message)}
    if isinstance(event, CommandSent):
        return {HEARD_S: event.sent_s, **_message_object(event.command)}
    return {name: getattr(event, name) for name in event.__dataclass_fields__}


def from_object(name: str, content: dict[str, Any]) -> FleetInput | None:
    """The input of a JSON object recorded under a topic's name; None when it is not one of ours."""
    try:
        if name in _MESSAGES:
            return Heard(_message(_MESSAGES[name], content), float(content[HEARD_S]))
        kind = STATION_TOPICS.get(name)
        if kind is CommandSent:
            return CommandSent(typing.cast(Command, _message(Command, content)), float(content[HEARD_S]))
        return None if kind is None else kind(**content)
    except (KeyError, TypeError, ValueError, msgspec.ValidationError):
        return None


def schema_of(name: str) -> dict[str, Any]:
    """JSON Schema of the objects recorded under a topic's name."""
    kind: type = _MESSAGES.get(name) or STATION_TOPICS[name]
    if kind is CommandSent:
        kind = Command
    hints = typing.get_type_hints(kind)
    properties = {field: _type_schema(hint) for field, hint in hints.items() if not field.startswith("_")}
    if issubclass(kind, msgspec.Struct):
        properties = {HEARD_S: {"type": "number"}, **{f: properties[f] for f in kind.__struct_fields__}}
    return {"title": f"fieldfleet.{kind.__name__}", "type": "object", "properties": properties}


def _message_object(message: AnyMessage) -> dict[str, Any]:
    hints = typing.get_type_hints(type(message))
    return {
        field: getattr(message, field).name.lower()
        if _is_enum(hints[field])
        else msgspec.to_builtins(getattr(message, field))
        for field in message.__struct_fields__
    }


def _message(kind: type[AnyMessage], content: dict[str, Any]) -> AnyMessage:
    hints = typing.get_type_hints(kind)
    defaults = dict(zip(reversed(kind.__struct_fields__), reversed(kind.__struct_defaults__), strict=False))
    values = []
    for field in kind.__struct_fields__:
        value = content[field] if field in content or field not in defaults else msgspec.to_builtins(defaults[field])
        values.append(hints[field][value.upper()].value if _is_enum(hints[field]) else value)
    message: AnyMessage = msgspec.convert([kind.__struct_config__.tag, *values], kind)
    return message


def _is_enum(hint: Any) -> bool:
    return isinstance(hint, type) and issubclass(hint, IntEnum)


def _type_schema(hint: Any) -> dict[str, Any]:
    if _is_enum(hint):
        return {"type": "string", "enum": [member.name.lower() for member in hint]}
    plain: dict[Any, dict[str, Any]] = {
        bool: {"type": "boolean"},
        int: {"type": "integer"},
        float: {"type": "number"},
        str: {"type": "string"},
        bytes: {"type": "string", "contentEncoding": "base64"},
    }
    if hint in plain:
        return plain[hint]
    origin = typing.get_origin(hint)
    if origin is tuple:
        items = [part for part in typing.get_args(hint) if part is not Ellipsis]
        return {"type": "array", "items": _type_schema(items[0])}
    if origin in (typing.Union, types.UnionType):
        return {}
    return {"type": "array"}
