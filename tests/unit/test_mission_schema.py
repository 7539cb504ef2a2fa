"""The exported JSON Schema says what the loader accepts, and describes every key."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import msgspec
import pytest

from vehicle_agent.mission.load import MissionError, load_mission, mission_schema
from vehicle_agent.mission.schema import allowed_values

MISSIONS = Path(__file__).parents[2] / "missions"
TYPES: dict[str, tuple[type, ...]] = {
    "object": (dict,),
    "array": (list,),
    "string": (str,),
    "integer": (int,),
    "number": (int, float),
    "boolean": (bool,),
    "null": (type(None),),
}
KNOWN_WORDS = {
    "$ref", "anyOf", "type", "properties", "required", "additionalProperties", "items", "prefixItems", "minItems",
    "maxItems", "minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum", "minLength", "maxLength", "pattern",
    "enum", "const", "default", "description", "title", "discriminator", "$defs", "$schema",
}  # fmt: skip


def troubles(value: Any, node: dict[str, Any], schema: dict[str, Any], path: str = "$") -> list[str]:
    """What JSON Schema says against a value; knows as much of the language as the schema uses."""
    assert set(node) <= KNOWN_WORDS
    if "$ref" in node:
        return troubles(value, schema["$defs"][node["$ref"].removeprefix("#/$defs/")], schema, path)
    if "anyOf" in node:
        tries = [troubles(value, branch, schema, path) for branch in node["anyOf"]]
        return [] if [] in tries else min(tries, key=len)
    if "enum" in node or "const" in node:
        return [] if value in node.get("enum", [node.get("const")]) else [f"{path}: {value!r} is not listed"]
    if not isinstance(value, TYPES[node["type"]]) or (isinstance(value, bool) and node["type"] != "boolean"):
        return [f"{path}: {value!r} is not of type {node['type']}"]
    if isinstance(value, dict):
        found = [f"{path}.{key}: unknown" for key in value if key not in node["properties"]]
        found += [f"{path}.{key}: missing" for key in node.get("required", []) if key not in value]
        for key, item in value.items():
            if key in node["properties"]:
                found += troubles(item, node["properties"][key], schema, f"{path}.{key}")
        return found
    if isinstance(value, list):
        wrong_length = not node.get("minItems", 0) <= len(value) <= node.get("maxItems", len(value))
        found = [f"{path}: {len(value)} items"] if wrong_length else []
        first = node.get("prefixItems", [])
        for index, item in enumerate(value):
            rest = node.get("items")
            part = first[index] if index < len(first) else rest
            if isinstance(part, dict):
                found += troubles(item, part, schema, f"{path}[{index}]")
        return found
    if isinstance(value, str):
        fits = node.get("minLength", 0) <= len(value) <= node.get("maxLength", len(value))
        return [] if fits and re.search(node.get("pattern", ""), value) else [f"{path}: {value!r} is not allowed"]
    if value is None or isinstance(value, bool):
        return []
    low, high = node.get("minimum", value), node.get("maximum", value)
    above, below = node.get("exclusiveMinimum", value - 1), node.get("exclusiveMaximum", value + 1)
    return [] if low <= value <= high and above < value < below else [f"{path}: {value!r} is out of bounds"]


def check(content: Any) -> list[str]:
    schema = mission_schema()
    return troubles(content, schema["$defs"]["Mission"], schema)


@pytest.mark.parametrize("file", sorted(MISSIONS.glob("*.toml")), ids=lambda file: str(file.stem))
def test_the_schema_accepts_what_flies(file: Path) -> None:
    assert check(tomllib.loads(file.read_text(encoding="utf-8"))) == []
    assert check(msgspec.json.decode(msgspec.json.encode(load_mission(file).mission))) == []


@pytest.mark.parametrize(
    ("old", "new", "where"),
    [
        ("seed = 7", "seed = -1", "$.seed"),
        ("seed = 7", "sed = 7", "$.sed"),
        ("format = 1", "format = 2", "$.format"),
        ('name = "ridge"', 'name = "Ridge"', "$.name"),
        ("[200.0, 200.0]", "[200.0]", "$.vehicles[0].start_enu_m"),
        ("range_m = 350.0", 'range_m = "far"', "$.vehicles[0].sensor.range_m"),
        ('kind = "grid"', 'kind = "moon"', "$.terrain"),
        ("cell_m = 20.0", "cell_m = 0.0", "$.area.cell_m"),
    ],
)
def test_the_schema_refuses_what_the_loader_refuses(tmp_path: Path, old: str, new: str, where: str) -> None:
    text = (MISSIONS / "ridge.toml").read_text(encoding="utf-8")
    assert old in text
    wrong = text.replace(old, new, 1)
    assert any(trouble.startswith(where) for trouble in check(tomllib.loads(wrong)))
    (tmp_path / "m.toml").write_text(wrong, encoding="utf-8")
    with pytest.raises(MissionError, match=re.escape(where.removeprefix("$."))):
        load_mission(tmp_path / "m.toml")


def test_every_key_of_every_table_is_described() -> None:
    schema = mission_schema()
    silent = [
        f"{table}.{key}"
        for table, definition in schema["$defs"].items()
        for key, content in definition["properties"].items()
        if len(content.get("description", "")) < 5
    ]
    assert silent == []
    assert all(definition["description"] for definition in schema["$defs"].values())
    assert {"Mission", "DatumTable", "AreaTable", "VehicleTable", "RangeSensor", "ExploreTask"} <= set(schema["$defs"])


def test_the_schema_is_plain_json_in_a_fixed_order() -> None:
    text = msgspec.json.encode(mission_schema())
    assert msgspec.json.decode(text) == mission_schema()
    assert text == msgspec.json.encode(mission_schema())
    assert rb"\\Z" not in text


@pytest.mark.parametrize(
    ("path", "values"),
    [
        ("task.kind", ["cover", "explore", "map"]),
        ("terrain.kind", ["flat", "gaussians", "grid", "town"]),
        ("vehicles[3].type", ["multicopter", "surface-vessel", "underwater-vehicle"]),
        ("vehicles[3].autopilot", ["ardupilot", "px4"]),
        ("vehicles[3].sensor.kind", ["half-sphere", "range", "single-beam"]),
        ("format", [1]),
        ("seed", []),
        ("no.such.key", []),
        ("", []),
    ],
)
def test_values_to_choose_from(path: str, values: list[Any]) -> None:
    assert sorted(allowed_values(path)) == values
