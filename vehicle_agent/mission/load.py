"""Reads and checks a mission file; every error is one sentence with the file, the key and the mend."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from vehicle_agent.domain.frames import Datum, FloatArray, Geodetic
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.polygon import cells_inside
from vehicle_agent.mission.checks import check_fence, check_ports, check_task, check_team, check_terrain
from vehicle_agent.mission.explain import explain_refusal, non_finite_keys
from vehicle_agent.mission.model import AreaTable, Mission
from vehicle_agent.mission.plan import MissionError, MissionPlan
from vehicle_agent.mission.schema import mission_schema
from vehicle_agent.mission.tasks import DEFAULT_PLANNER, ExploreTask, PlannerName

__all__ = ["MissionError", "MissionPlan", "check_task", "load_mission", "mission_schema", "plan_mission"]

MAX_FILE_BYTES = 1_000_000


def load_mission(path: Path, change: Callable[[Mission], Mission] | None = None) -> MissionPlan:
    """Read, check and complete a mission file.

    Parameters
    ----------
    path
        The TOML file.
    change
        Applied to the content before it is checked, e.g. another seed or speed-up from the command line.

    Raises
    ------
    MissionError
        With one sentence that names the file, the key's path and the mend.
    """
    mission = _typed(_read_toml(path), path)
    return plan_mission(change(mission) if change else mission, path)


def plan_mission(mission: Mission, source: Path = Path("mission")) -> MissionPlan:
    """Check a mission and work out its frame, fence and grid; raises MissionError like `load_mission`."""

    def fail(key: str, trouble: str) -> MissionError:
        return MissionError(f"{source}: {key}: {trouble}")

    try:
        content = msgspec.to_builtins(mission)
    except TypeError as error:
        raise MissionError(f"{source}: holds a value that no mission file can hold ({error})") from None
    # A mission that was built or changed in Python has not met the model's bounds yet.
    mission = _typed(content, source)
    datum = Datum(mission.datum.latitude_deg, mission.datum.longitude_deg, mission.datum.altitude_amsl_m)
    key, fence = _fence(mission.area, datum, fail)
    check_fence(key, fence, mission.area.cell_m, fail)
    west, south = fence.min(axis=0)
    east, north = fence.max(axis=0)
    grid = Grid.over(float(west), float(south), float(east), float(north), mission.area.cell_m)
    area_cells = cells_inside(grid, fence)
    if not area_cells.any():
        raise fail("area", "holds no cell centre; make the area larger or area.cell_m smaller")
    if isinstance(mission.task, ExploreTask) and mission.task.planner is None:
        planner: PlannerName = DEFAULT_PLANNER if mission.area.up_m is None else "tours"
        mission = msgspec.structs.replace(mission, task=msgspec.structs.replace(mission.task, planner=planner))
    plan = MissionPlan(mission, source, datum, fence, grid, area_cells)
    check_terrain(plan, fail)
    check_team(plan, fail)
    check_ports(plan, fail)
    return plan


def _read_toml(path: Path) -> dict[str, Any]:
    try:
        with path.open("rb") as file:
            content = file.read(MAX_FILE_BYTES + 1)
    except FileNotFoundError:
        raise MissionError(f"{path}: no such file; `missions list` names the missions that there are") from None
    except IsADirectoryError:
        raise MissionError(f"{path}: is a folder; name the mission file in it") from None
    except OSError as error:
        raise MissionError(f"{path}: cannot be read ({error.strerror}); check the path and its permissions") from None
    except ValueError:
        raise MissionError(f"{path}: is not a path; name a mission file") from None
    if len(content) > MAX_FILE_BYTES:
        raise MissionError(f"{path}: is larger than {MAX_FILE_BYTES} bytes; name a mission file")
    try:
        return tomllib.loads(content.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise MissionError(f"{path}: is not UTF-8 text (byte {error.start}); save it as UTF-8") from None
    except RecursionError:
        raise MissionError(f"{path}: is nested too deeply; mend its brackets") from None
    except ValueError as error:
        raise MissionError(f"{path}: is not TOML ({error}); mend the syntax there") from None


def _typed(content: Any, source: Path) -> Mission:
    for key, value in non_finite_keys(content):
        raise MissionError(f"{source}: {key}: {value} is not a quantity; give a finite number")
    try:
        return msgspec.convert(content, Mission)
    except msgspec.ValidationError as error:
        raise MissionError(f"{source}: {explain_refusal(str(error))}") from None


def _fence(area: AreaTable, datum: Datum, fail: Callable[[str, str], MissionError]) -> tuple[str, FloatArray]:
    """Key that gives the area's shape, and its corners, (V, 2) float64 in ENU metres."""
    shapes = [key for key in ("rectangle_enu_m", "polygon_enu_m", "polygon_deg") if getattr(area, key) is not None]
    if len(shapes) != 1:
        found = " and ".join(shapes) or "none"
        raise fail("area", f"give exactly one of rectangle_enu_m, polygon_enu_m, polygon_deg (found {found})")
    corners: list[tuple[float, float]]
    if area.rectangle_enu_m is not None:
        west, south, east, north = area.rectangle_enu_m
        if not (west < east and south < north):
            raise fail("area.rectangle_enu_m", "must be [west, south, east, north] with west < east and south < north")
        corners = [(west, south), (east, south), (east, north), (west, north)]
    elif area.polygon_enu_m is not None:
        corners = list(area.polygon_enu_m)
    else:
        corners = [
            datum.to_enu(Geodetic(latitude, longitude, datum.altitude_amsl_m))[:2]
            for latitude, longitude in area.polygon_deg or ()
        ]
    return f"area.{shapes[0]}", np.array(corners, dtype=np.float64)
