"""A checked mission: its content, and the frame, fence, grid, ids, ports and endpoints that follow from it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from vehicle_agent.domain.frames import Datum, FloatArray
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.mission.model import Mission
from vehicle_agent.mission.vehicles import VehicleTable

CONTROLLER_ID_OFFSET = 100
"""An agent's MAVLink system id is its vehicle's plus this."""
MAVLINK_PORT_STEP = 10


class MissionError(Exception):
    """A mission file that cannot be flown; its text is one sentence, on one line, for who wrote the file."""

    def __init__(self, sentence: str) -> None:
        # A file's keys and its path may hold anything, even a terminal's control sequences.
        super().__init__(
            "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in sentence)
        )


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
    def voxel_grid(self) -> VoxelGrid | None:
        """Voxels over the grid's cells when the map is one in three dimensions, else None."""
        if self.mission.area.up_m is None:
            return None
        low_m, high_m = self.mission.area.up_m
        grid = self.grid
        layers = max(1, math.ceil((high_m - low_m) / grid.cell_m - 1e-9))
        return VoxelGrid(grid.west_m, grid.south_m, low_m, grid.cell_m, grid.columns, grid.rows, layers)

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
        return self.mission.simulation.mavlink_port + MAVLINK_PORT_STEP * index

    def connection(self, index: int) -> str:
        """MAVSDK connection URL of a vehicle."""
        given = self.mission.vehicles[index].connection
        return given or f"tcpout://{self.mission.radio.endpoint_host}:{self.mavlink_port(index)}"

    def simulator_endpoint(self) -> str:
        """Zenoh endpoint on which the simulator listens."""
        return f"tcp/{self.mission.radio.endpoint_host}:{self.mission.radio.zenoh_port}"

    def agent_endpoint(self, index: int) -> str:
        """Zenoh endpoint on which a vehicle's agent listens."""
        protocol = "tcp" if self.mission.radio.tls is None else "tls"
        return f"{protocol}/{self.mission.radio.endpoint_host}:{self.mission.radio.zenoh_port + 1 + index}"

    def tls_paths(self, participant: str) -> tuple[Path, Path, Path] | None:
        """Authority, certificate and key of a participant; None when the link is not secured.

        `{name}` in `radio.tls` stands for the vehicle, or for `station` at everybody who is none.
        """
        tls = self.mission.radio.tls
        if tls is None:
            return None
        role = participant if participant in self.vehicle_names else "station"
        ca, certificate, key = (
            self.source.parent / text.replace("{name}", role) for text in (tls.ca, tls.certificate, tls.key)
        )
        return ca, certificate, key
