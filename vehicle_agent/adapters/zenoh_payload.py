"""The vehicle's own mapping sensor: the `Payload` port over a link of its own, apart from the team's radio."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from vehicle_agent.domain.elevation import CellObservations
from vehicle_agent.domain.range_image import RangeImage
from vehicle_agent.link.session import FleetLink
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.ports import SensorScan
from vehicle_agent.wire.cells import unpack_cells
from vehicle_agent.wire.messages import Scan
from vehicle_agent.wire.range_blob import unpack_ranges


class ZenohPayload:
    """Hears the scans said on its vehicle's key.

    Attributes
    ----------
    undecodable
        Scans that were not a valid blob for this mission's grid and sensor.
    """

    def __init__(
        self, link: FleetLink, vehicle: str, unpack: Callable[[bytes], CellObservations | RangeImage | None]
    ) -> None:
        self.undecodable = 0
        self._link = link
        self._unpack = unpack
        link.subscribe("scan", vehicle)

    def poll(self) -> list[SensorScan]:
        scans = []
        for message in self._link.poll():
            seen = self._unpack(message.cells) if isinstance(message, Scan) else None
            if seen is None:
                self.undecodable += 1
            else:
                scans.append(SensorScan(seen))
        return scans


def unpacker(plan: MissionPlan, index: int) -> Callable[[bytes], CellObservations | RangeImage | None]:
    """How scans of a vehicle's sensor are unpacked."""
    if plan.voxel_grid is None:
        return partial(unpack_cells, grid_cells=plan.grid.cells)
    from vehicle_agent.domain.ray_fan import down_looking_fan  # its kernels load only where there is a town

    fan = down_looking_fan(plan.mission.vehicles[index].sensor.range_m / plan.grid.cell_m)
    return partial(unpack_ranges, rays=len(fan.targets))
