"""Reads and checks a mission file; every error is one sentence with the file, the key and the mend."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from vehicle_agent.domain.frames import Datum, FloatArray, Geodetic
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.polygon import BoolArray, cells_inside, points_inside
from vehicle_agent.mission.model import Mission, VehicleTable

MAX_CELLS = 4_000_000
CONTROLLER_ID_OFFSET = 100
"""An agent's MAVLink system id is its vehicle's plus this."""


class MissionError(Exception):
    """A mission file that cannot be flown; its text is one sentence for the person who wrote the file."""


@dataclass(frozen=True, slots=True)
class MissionPlan:
    """A checked mission with what follows from it.

    Attributes
    ----------
    mission
        The file's content.
    source
        The file, or where else the mission came from.
    datum
        Origin of the local frame.
    fence_en_m
        (V, 2) float64, corners of the area, east and north in ENU metres.
    grid
        Cells over the area's bounding box.
    area_cells
        (columns, rows) bool, cells whose centre lies inside the area.
    """

    mission: Mission
    source: Path
    datum: Datum
    fence_en_m: FloatArray
    grid: Grid
    area_cells: BoolArray

    @property
    def vehicle_names(self) -> tuple[str, ...]:
        return tuple(vehicle.name for vehicle in self.mission.vehicles)

    def vehicle(self, name: str) -> VehicleTable:
        """The vehicle of that name, or MissionError."""
        return self.mission.vehicles[self.index_of(name)]

    def index_of(self, name: str) -> int:
        """Team index of a vehicle by name, or MissionError."""
        try:
            return self.vehicle_names.index(name)
        except ValueError:
            raise MissionError(
                f"{self.source}: there is no vehicle '{name}'; the mission has {', '.join(self.vehicle_names)}"
            ) from None

    def system_id(self, index: int) -> int:
        """MAVLink system id of a vehicle's autopilot."""
        return self.mission.vehicles[index].system_id or index + 1

    def controller_system_id(self, index: int) -> int:
        """MAVLink system id with which a vehicle's agent speaks."""
        return CONTROLLER_ID_OFFSET + self.system_id(index)

    def mavlink_port(self, index: int) -> int:
        """TCP and UDP port of a simulated vehicle."""
        return self.mission.simulation.mavlink_port + 10 * index

    def connection(self, index: int) -> str:
        """MAVSDK connection URL of a vehicle."""
        given = self.mission.vehicles[index].connection
        return given or f"tcpout://{self.mission.radio.endpoint_host}:{self.mavlink_port(index)}"

    def simulator_endpoint(self) -> str:
        """Zenoh endpoint on which the simulator listens."""
        return f"tcp/{self.mission.radio.endpoint_host}:{self.mission.radio.zenoh_port}"

    def agent_endpoint(self, index: int) -> str:
        """Zenoh endpoint on which a vehicle's agent listens."""
        return f"tcp/{self.mission.radio.endpoint_host}:{self.mission.radio.zenoh_port + 1 + index}"


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
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        raise MissionError(f"{path}: no such file; `missions list` names the missions that there are") from None
    except OSError as error:
        raise MissionError(f"{path}: cannot be read ({error.strerror}); check the path and its permissions") from None
    try:
        mission = msgspec.toml.decode(content, type=Mission)
    except msgspec.ValidationError as error:
        raise MissionError(f"{path}: {_explain(str(error))}") from None
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise MissionError(f"{path}: is not TOML ({error}); mend the syntax there") from None
    return plan_mission(change(mission) if change else mission, path)


def plan_mission(mission: Mission, source: Path = Path("mission")) -> MissionPlan:
    """Check a mission and work out its frame, fence and grid; raises MissionError like `load_mission`."""

    def fail(key: str, trouble: str) -> MissionError:
        return MissionError(f"{source}: {key}: {trouble}")

    datum = Datum(mission.datum.latitude_deg, mission.datum.longitude_deg, mission.datum.altitude_amsl_m)
    area = mission.area
    shapes = [key for key in ("rectangle_enu_m", "polygon_enu_m", "polygon_deg") if getattr(area, key) is not None]
    if len(shapes) != 1:
        found = " and ".join(shapes) or "none"
        raise fail("area", f"give exactly one of rectangle_enu_m, polygon_enu_m, polygon_deg (found {found})")
    if area.rectangle_enu_m is not None:
        west, south, east, north = area.rectangle_enu_m
        if not (west < east and south < north):
            raise fail("area.rectangle_enu_m", "must be [west, south, east, north] with west < east and south < north")
        corners = [(west, south), (east, south), (east, north), (west, north)]
    elif area.polygon_enu_m is not None:
        corners = list(area.polygon_enu_m)
    else:
        assert area.polygon_deg is not None
        corners = [datum.to_enu(Geodetic(lat, lon, datum.altitude_amsl_m))[:2] for lat, lon in area.polygon_deg]
    fence = np.array(corners, dtype=np.float64)
    west, south = fence.min(axis=0)
    east, north = fence.max(axis=0)
    wanted_cells = (east - west) / area.cell_m * (north - south) / area.cell_m
    if wanted_cells > MAX_CELLS:
        raise fail(
            "area.cell_m",
            f"{area.cell_m:g} m makes {wanted_cells:.0f} cells; choose a cell of at least "
            f"{((east - west) * (north - south) / MAX_CELLS) ** 0.5:.3g} m",
        )
    grid = Grid.over(float(west), float(south), float(east), float(north), area.cell_m)
    area_cells = cells_inside(grid, fence)
    if not area_cells.any():
        raise fail("area", "holds no cell centre; make the area larger or area.cell_m smaller")
    plan = MissionPlan(mission, source, datum, fence, grid, area_cells)
    _check_team(plan, fail)
    return plan


def _check_team(plan: MissionPlan, fail: Callable[[str, str], MissionError]) -> None:
    names: dict[str, int] = {}
    system_ids: dict[int, int] = {}
    for index, vehicle in enumerate(plan.mission.vehicles):
        where = f"vehicles[{index}]"
        if (other := names.setdefault(vehicle.name, index)) != index:
            raise fail(f"{where}.name", f"'{vehicle.name}' is also vehicles[{other}]; give every vehicle its own name")
        system_id = plan.system_id(index)
        if (other := system_ids.setdefault(system_id, index)) != index:
            raise fail(
                f"{where}.system_id", f"{system_id} is also vehicles[{other}]'s; give every autopilot its own id"
            )
        if vehicle.min_above_terrain_m >= vehicle.max_above_terrain_m:
            raise fail(f"{where}.max_above_terrain_m", "must be larger than min_above_terrain_m")
        if vehicle.min_above_terrain_m >= vehicle.sensor.range_m:
            raise fail(
                f"{where}.sensor.range_m",
                f"{vehicle.sensor.range_m:g} m does not reach the ground from min_above_terrain_m "
                f"({vehicle.min_above_terrain_m:g} m); fly lower or see further",
            )
        start = np.array([vehicle.start_enu_m[:2]], dtype=np.float64)
        if not points_inside(start, plan.fence_en_m)[0]:
            raise fail(f"{where}.start_enu_m", "lies outside the area; move the start inside or widen the area")
        for other, rival in enumerate(plan.mission.vehicles[:index]):
            apart = float(np.hypot(*(start[0] - np.array(rival.start_enu_m[:2]))))
            if apart < 2.0:
                raise fail(
                    f"{where}.start_enu_m",
                    f"is {apart:.1f} m from vehicles[{other}]'s start; keep starts at least 2 m apart",
                )


def _explain(error: str) -> str:
    """Turn msgspec's text into a sentence with the key's path first and the mend last."""
    trouble, _, path = error.partition(" - at `")
    key = path.rstrip("`").removeprefix("$").removeprefix(".") or "the file"
    if trouble.startswith("Object contains unknown field"):
        name = trouble.rsplit("`", 2)[-2]
        place = f"{key}.{name}" if path else name
        return f"{place}: unknown key; remove it or correct its spelling (`missions schema` lists every key)"
    if trouble.startswith("Object missing required field"):
        name = trouble.rsplit("`", 2)[-2]
        place = f"{key}.{name}" if path else name
        return f"{place}: missing; add it (`missions schema` tells what it means)"
    return f"{key}: {trouble[0].lower()}{trouble[1:]}; correct the value (`missions schema` lists what is allowed)"


def mission_schema() -> dict[str, Any]:
    """JSON Schema of the mission file."""
    schema: dict[str, Any] = msgspec.json.schema(Mission)
    return json.loads(json.dumps(schema, sort_keys=True))  # type: ignore[no-any-return]
