"""The missions that come with the package, and how a name on the command line finds its file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from vehicle_agent.mission.load import MissionError, MissionPlan, check_task, load_mission
from vehicle_agent.mission.model import Mission

MISSIONS_DIR = Path(__file__).parent


def built_in_missions() -> dict[str, Path]:
    """Files of the missions that come with the package, by name, in order of name."""
    return {path.stem: path for path in sorted(MISSIONS_DIR.glob("*.toml"))}


def mission_path(file_or_name: str) -> Path:
    """File of a mission given by path or by built-in name; an existing file goes before a name.

    Raises MissionError with one sentence when there is neither.
    """
    path = Path(file_or_name)
    if path.is_file():
        return path
    missions = built_in_missions()
    if file_or_name in missions:
        return missions[file_or_name]
    looks_like_name = path.suffix != ".toml" and len(path.parts) == 1 and not path.exists()
    if looks_like_name:
        raise MissionError(
            f"there is no mission '{file_or_name}'; take one of {', '.join(missions)}, or give the path of a .toml file"
        )
    return path


def load_named_mission(file_or_name: str | Path, change: Callable[[Mission], Mission] | None = None) -> MissionPlan:
    """Load and check a mission given by path or by built-in name; `change` and errors as in `load_mission`."""
    plan = load_mission(mission_path(str(file_or_name)), change)
    check_task(plan)
    return plan
