"""JSON Schema of the mission file, with the words of the model's docstrings at every key."""

from __future__ import annotations

import inspect
import json
import re
from typing import Any

import msgspec

from vehicle_agent.mission.model import Mission

_ENTRY = re.compile(r"^(\w+(?:, \w+)*)\n((?: {4}.+(?:\n|\Z))+)", re.MULTILINE)


def mission_schema() -> dict[str, Any]:
    """JSON Schema (2020-12) of the mission file; every key has a description."""
    (_,), components = msgspec.json.schema_components((Mission,), ref_template="#/$defs/{name}")
    definitions: dict[str, Any] = json.loads(json.dumps(components, sort_keys=True).replace(r"\\Z", "$"))
    for definition in definitions.values():
        text, keys = _read_docstring(definition.get("description", ""))
        definition["description"] = text
        for key, words in keys.items():
            definition["properties"][key]["description"] = words
        for key, content in definition["properties"].items():
            if key == "kind":
                content["description"] = "What the rest of this table describes."
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$ref": "#/$defs/Mission",
        "$defs": definitions,
        "title": "fieldfleet mission file",
    }


def allowed_values(path: str) -> list[Any]:
    """Values that a key may have, by its path (`task.planner`, `vehicles[0].type`); empty when they are not listed."""
    schema = mission_schema()
    definitions = schema["$defs"]
    found = [schema]
    for step in re.findall(r"\w+|\[", path):
        following = []
        for node in _alternatives(found, definitions):
            child = node.get("items") if step == "[" else node.get("properties", {}).get(step)
            if isinstance(child, dict):
                following.append(child)
            elif step.isdigit():
                following.append(node)
        found = following
    values: list[Any] = []
    for node in _alternatives(found, definitions):
        values += node.get("enum", [])
        if node.get("const") is not None:
            values.append(node["const"])
    return list(dict.fromkeys(values))


def _alternatives(nodes: list[dict[str, Any]], definitions: dict[str, Any]) -> list[dict[str, Any]]:
    """Follow references and unions down to plain schemas."""
    plain: list[dict[str, Any]] = []
    for node in nodes:
        if "$ref" in node:
            plain += _alternatives([definitions[node["$ref"].rsplit("/", 1)[1]]], definitions)
        elif "anyOf" in node:
            plain += _alternatives(node["anyOf"], definitions)
        else:
            plain.append(node)
    return plain


def _read_docstring(docstring: str) -> tuple[str, dict[str, str]]:
    """Split a docstring into its text and the words about each key in its Attributes section."""
    text, _, section = inspect.cleandoc(docstring).partition("\n\nAttributes\n----------\n")
    keys = {name: " ".join(words.split()) for names, words in _ENTRY.findall(section) for name in re.split(", ", names)}
    return " ".join(text.split()), keys
