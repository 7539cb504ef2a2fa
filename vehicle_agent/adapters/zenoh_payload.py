"""The vehicle's own mapping sensor: the `Payload` port over a link of its own, apart from the team's radio."""

from __future__ import annotations

from vehicle_agent.link.session import FleetLink
from vehicle_agent.ports import SensorScan
from vehicle_agent.wire.cells import unpack_cells
from vehicle_agent.wire.messages import Scan


class ZenohPayload:
    """Hears the scans said on its vehicle's key.

    Attributes
    ----------
    undecodable
        Scans whose cells were not a valid blob for this mission's grid.
    """

    def __init__(self, link: FleetLink, vehicle: str, grid_cells: int) -> None:
        self.undecodable = 0
        self._link = link
        self._grid_cells = grid_cells
        link.subscribe("scan", vehicle)

    def poll(self) -> list[SensorScan]:
        scans = []
        for message in self._link.poll():
            cells = unpack_cells(message.cells, self._grid_cells) if isinstance(message, Scan) else None
            if cells is None:
                self.undecodable += 1
            else:
                scans.append(SensorScan(cells))
        return scans
