"""What a vehicle knows: the map that it measured and was told, and its teammates."""

from __future__ import annotations

from collections.abc import Iterable

from vehicle_agent.behaviour.guide import Surroundings
from vehicle_agent.behaviour.intent import Line, may_cross, within_reach_m
from vehicle_agent.behaviour.map_exchange import MapExchange
from vehicle_agent.behaviour.shared_map import SharedMap
from vehicle_agent.behaviour.team_picture import TeamPicture
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.team_map import TeamMap
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.mission.tasks import MapTask
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

    def __init__(
        self, plan: MissionPlan, index: int, shared: SharedMap, boot_id: int, journal_records: Iterable[bytes]
    ) -> None:
        self._plan, self._index = plan, index
        self._own_name, self._names = plan.vehicle_names[index], plan.vehicle_names
        self._speeds_m_s = tuple(vehicle.speed_m_s for vehicle in plan.mission.vehicles)
        self._within_m = within_reach_m(plan)
        self._meets_nobody = isinstance(plan.mission.task, MapTask)  # they keep depths of their own
        self.shared = shared
        self.exchange = MapExchange(shared, plan.vehicle_names, index, boot_id, journal_records)
        self.team = TeamPicture(self._own_name, plan.vehicle_names, plan.mission.safety.teammate_silence_s)

    @property
    def map(self) -> TeamMap:
        return self.shared.team_map

    @property
    def first_seen_cells(self) -> float:
        """J_E of this vehicle (Renzaglia eq. 5)."""
        return self.shared.first_seen(self._index, self._plan.area_cells)

    def known_fraction(self, area_cells: BoolArray) -> float:
        """Share of what is to be seen over those cells, (columns, rows) bool, on this vehicle's map."""
        return self.shared.known_fraction(area_cells)

    def observe(self, scan: SensorScan) -> None:
        self.exchange.observe(scan)

    def receive(self, records: Iterable[DeltaRecord], repaired_at_s: float | None = None) -> None:
        self.exchange.receive(records, repaired_at_s)

    def repair_for(self, digest: Digest, now_s: float) -> tuple[DeltaRecord, ...]:
        """What to send to a digest's sender."""
        heard = self.team.living()
        living = [name for name in self._plan.vehicle_names if name == self._own_name or name in heard]
        return self.exchange.repair_for(digest, living, now_s)

    def is_awaited(self, name: str, flown: Line, now_s: float) -> bool:
        """Whether a teammate that tells an intent may wait for the word of this vehicle, with what it flies now."""
        known = (mate for mate in self.team.whereabouts(now_s, self._speeds_m_s) if self._names[mate.index] == name)
        return any(may_cross((flown,), mate.lines, self._within_m + mate.strayed_m) for mate in known)

    def around(self, now_s: float, state: VehicleState, at_work: bool) -> Surroundings:
        """What the navigator needs to know now; who is `at_work` keeps clear of teammates' passages, too."""
        reservations, passages = self.team.reservations(now_s), self.team.passages(now_s)
        return Surroundings(
            now_s,
            state,
            self.shared.version,
            self.team.teammates(),
            tuple(dict.fromkeys(reservations + passages)) if at_work else reservations,
            passages,
            self.first_seen_cells,
            () if self._meets_nobody else self.team.whereabouts(now_s, self._speeds_m_s),
        )
