"""A map that a team makes together: what its exchange, its agent and its reports need of it."""

from __future__ import annotations

from typing import Protocol

from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.team_map import TeamMap
from vehicle_agent.ports import SensorScan


class SharedMap(Protocol):
    """One vehicle's copy of the team's map, of whatever kind."""

    @property
    def team_map(self) -> TeamMap:
        """Everything that the vehicle measured or was told."""
        ...

    @property
    def version(self) -> int:
        """Changes with the map."""
        ...

    def take_scan(self, scan: SensorScan) -> tuple[int, bool]:
        """Fold a scan of the own sensor in; how much it changed, and whether all of it made sense."""
        ...

    def next_blob(self, most_bytes: int) -> bytes | None:
        """What was observed since the last call, packed into so many bytes; None when nothing was.

        What does not fit is left for the next call.
        """
        ...

    def fold(self, contributor: int, blob: bytes) -> bool:
        """Fold in what a vehicle told, by team index; False (and nothing changes) when it makes no sense.

        It may come twice, late and in any order.
        """
        ...

    def known_fraction(self, area_cells: BoolArray) -> float:
        """Share of what is to be seen over some cells, (columns, rows) bool, that is known: 1 when nothing is left."""
        ...

    def first_seen(self, index: int, area_cells: BoolArray) -> float:
        """J_E of a vehicle over some cells (Renzaglia eq. 5)."""
        ...

    def highest_up_m(self) -> float:
        """Highest known surface, ENU z."""
        ...
