"""What a vehicle knows: the map that it measured and was told, and its teammates."""

from __future__ import annotations

from collections.abc import Iterable

from vehicle_agent.behaviour.map_exchange import MapExchange
from vehicle_agent.behaviour.navigator import Surroundings
from vehicle_agent.behaviour.team_picture import TeamPicture
from vehicle_agent.domain.elevation import ElevationMap
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.ports import SensorScan, VehicleState
from vehicle_agent.wire.messages import DeltaRecord, Digest


class Knowledge:
    """One vehicle's knowledge.

    Attributes
    ----------
    exchange
        The map, and the streams of records that it is made of.
    team
        Who is heard, where, and going where.
    """

    def __init__(self, plan: MissionPlan, index: int, boot_id: int, journal_records: Iterable[bytes]) -> None:
        self._plan, self._index = plan, index
        self._own_name = plan.vehicle_names[index]
        self._map_version = 0
        self.exchange = MapExchange(plan.grid, plan.vehicle_names, index, boot_id, journal_records)
        self.team = TeamPicture(self._own_name, plan.vehicle_names, plan.mission.safety.teammate_silence_s)

    @property
    def map(self) -> ElevationMap:
        return self.exchange.team_map

    @property
    def first_seen_cells(self) -> float:
        """J_E of this vehicle (Renzaglia eq. 5)."""
        return self.map.first_observer_share(self._index, self._plan.area_cells)

    def known_fraction(self, area_cells: BoolArray) -> float:
        """Share of those cells, (columns, rows) bool, on this vehicle's map."""
        return float((self.map.observed & area_cells).sum()) / max(1, int(area_cells.sum()))

    def observe(self, scan: SensorScan) -> None:
        self._map_version += self.exchange.observe(scan.cells)

    def receive(self, records: Iterable[DeltaRecord], repaired_at_s: float | None = None) -> None:
        self._map_version += self.exchange.receive(records, repaired_at_s)

    def repair_for(self, digest: Digest, now_s: float) -> tuple[DeltaRecord, ...]:
        """What to send to a digest's sender."""
        heard = self.team.living()
        living = [name for name in self._plan.vehicle_names if name == self._own_name or name in heard]
        return self.exchange.repair_for(digest, living, now_s)

    def around(self, now_s: float, state: VehicleState) -> Surroundings:
        """What the navigator needs to know now."""
        return Surroundings(
            now_s,
            state,
            self.map,
            self._map_version,
            self.team.teammates(),
            self.team.reservations(now_s),
            self.first_seen_cells,
        )
