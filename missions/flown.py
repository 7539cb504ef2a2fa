"""The mission as it is flown: the file with the command line's changes, kept in the run folder with its terrain.

All processes of a run read this one file, so they cannot disagree, and anybody can attach another station to it.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from vehicle_agent.mission.load import MissionError, MissionPlan, load_mission
from vehicle_agent.mission.model import Mission
from vehicle_agent.mission.terrain import GridTerrain, TownTerrain

MAVLINK_PORT_OFFSET = 100
"""From `--port-base` to the first MAVLink port; below it lie the simulator's and 64 agents' Zenoh ports."""
HIGHEST_PORT_BASE = 65_535 - MAVLINK_PORT_OFFSET - 640


@dataclass(frozen=True, slots=True)
class Changes:
    """What the command line changes in a mission; None leaves the file's value.

    Attributes
    ----------
    speedup
        Simulated seconds per second, above 0 and at most 100.
    seed
        Seed of every random draw.
    port_base
        Zenoh ports from here on, MAVLink ports from here + 100 on.
    planner
        Who decides where to go next.
    """

    speedup: float | None = None
    seed: int | None = None
    port_base: int | None = None
    planner: str | None = None

    def apply(self, mission: Mission) -> Mission:
        """Return the changed mission; raises MissionError when a value is not one the file could have."""
        content = msgspec.to_builtins(mission)
        if self.speedup is not None:
            content["simulation"]["speedup"] = self.speedup
        if self.seed is not None:
            content["seed"] = self.seed
        if self.port_base is not None:
            content["radio"]["zenoh_port"] = self.port_base
            content["simulation"]["mavlink_port"] = self.port_base + MAVLINK_PORT_OFFSET
        if self.planner is not None:
            content["task"]["planner"] = self.planner
        try:
            return msgspec.convert(content, Mission)
        except msgspec.ValidationError as error:
            raise MissionError(f"an option does not fit the mission ({error}); choose another value") from None


def write_flown(plan: MissionPlan, run_dir: Path) -> MissionPlan:
    """Write `mission.toml` and its terrain into the run folder and load it from there.

    Raises MissionError when a file cannot be read or written.
    """
    mission = plan.mission
    path = run_dir / "mission.toml"
    try:
        if isinstance(mission.terrain, GridTerrain | TownTerrain) and mission.terrain.file is not None:
            source = plan.source.parent / mission.terrain.file
            name = f"terrain{source.suffix}"
            shutil.copyfile(source, run_dir / name)
            mission = msgspec.structs.replace(mission, terrain=msgspec.structs.replace(mission.terrain, file=name))
        path.write_text(to_toml(msgspec.to_builtins(mission)), encoding="utf-8")
    except OSError as error:
        raise MissionError(
            f"{error.filename or run_dir}: {error.strerror}; check the path and its permissions"
        ) from None
    return load_mission(path)


def to_toml(content: Mapping[str, Any]) -> str:
    """TOML text of a mission's content: scalars, lists, tables and lists of tables; None is left out."""
    lines: list[str] = []
    _write_table(lines, (), content)
    return "\n".join(lines).lstrip("\n") + "\n"


def _write_table(lines: list[str], path: tuple[str, ...], table: Mapping[str, Any]) -> None:
    tables = {key: value for key, value in table.items() if isinstance(value, Mapping) and not path}
    table_lists = {key: value for key, value in table.items() if _is_table_list(value)}
    for key, value in table.items():
        if value is not None and key not in tables and key not in table_lists:
            lines.append(f"{key} = {_value(value)}")
    for key, value in tables.items():
        lines += ["", f"[{'.'.join((*path, key))}]"]
        _write_table(lines, (*path, key), value)
    for key, items in table_lists.items():
        for item in items:
            lines += ["", f"[[{'.'.join((*path, key))}]]"]
            _write_table(lines, (*path, key), item)


def _is_table_list(value: Any) -> bool:
    return (
        isinstance(value, Sequence) and not isinstance(value, str) and any(isinstance(item, Mapping) for item in value)
    )


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")  # JSON escapes are TOML escapes
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, Mapping):
        inner = ", ".join(f"{key} = {_value(item)}" for key, item in value.items() if item is not None)
        return f"{{ {inner} }}"
    return f"[{', '.join(_value(item) for item in value)}]"
