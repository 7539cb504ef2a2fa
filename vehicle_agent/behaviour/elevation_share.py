"""The team's elevation map as it is shared: cells observed, told once, folded in by their earliest observation."""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.elevation import CellObservations, ElevationMap
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.ports import SensorScan
from vehicle_agent.wire.cells import MAX_ELEVATION_DM, MAX_STAMP_MS, pack_cells, unpack_cells


class ElevationShare:
    """A `SharedMap` of elevations."""

    def __init__(self, grid: Grid, own_index: int) -> None:
        self.team_map = ElevationMap(grid)
        self.version = 0
        self._own_index = own_index
        self._pending: list[CellObservations] = []

    def take_scan(self, scan: SensorScan) -> tuple[int, bool]:
        """Of cells of which nobody could be told, the rest counts; an impossible scan does not count at all."""
        cells = scan.seen
        if not isinstance(cells, CellObservations):
            return 0, False
        sayable = (np.abs(cells.elevations_dm.astype(np.int64)) <= MAX_ELEVATION_DM) & (cells.stamps_ms >= 0)
        sayable &= cells.stamps_ms <= MAX_STAMP_MS
        if not sayable.all():
            cells = CellObservations(
                cells.cell_indices[sayable], cells.elevations_dm[sayable], cells.stamps_ms[sayable]
            )
        try:
            changed = self.team_map.observe(self._own_index, cells)
        except ValueError:
            return 0, False
        if len(changed):
            self._pending.append(changed)
            self.version += 1
        return len(changed), bool(sayable.all())

    def next_blob(self, most_bytes: int) -> bytes | None:
        if not self._pending:
            return None
        cells = _earliest(self._pending)
        self._pending.clear()
        blob = pack_cells(cells)
        while len(blob) > most_bytes:
            cells, rest = _split(cells, max(1, int(0.9 * len(cells) * most_bytes / len(blob))))
            self._pending.append(rest)
            blob = pack_cells(cells)
        return blob

    def fold(self, contributor: int, blob: bytes) -> bool:
        cells = unpack_cells(blob, self.team_map.grid.cells)
        if cells is None:
            return False
        self.team_map.observe(contributor, cells)
        self.version += 1
        return True

    def known_fraction(self, area_cells: BoolArray) -> float:
        return float((self.team_map.observed & area_cells).sum()) / max(1, int(area_cells.sum()))

    def first_seen(self, index: int, area_cells: BoolArray) -> float:
        return self.team_map.first_observer_share(index, area_cells)

    def highest_up_m(self) -> float:
        known = self.team_map.observed
        return 0.1 * float(np.max(self.team_map.elevation_dm, where=known, initial=-(10**6)))


def _earliest(batches: list[CellObservations]) -> CellObservations:
    """One batch with every cell once, its earliest observation kept."""
    indices = np.concatenate([batch.cell_indices for batch in batches])
    elevations = np.concatenate([batch.elevations_dm for batch in batches])
    stamps = np.concatenate([batch.stamps_ms for batch in batches])
    order = np.lexsort((elevations, stamps, indices))
    first = order[np.unique(indices[order], return_index=True)[1]]
    return CellObservations(indices[first], elevations[first], stamps[first])


def _split(cells: CellObservations, count: int) -> tuple[CellObservations, CellObservations]:
    """The first `count` observations and the rest."""
    indices, elevations, stamps = cells.cell_indices, cells.elevations_dm, cells.stamps_ms
    return (
        CellObservations(indices[:count], elevations[:count], stamps[:count]),
        CellObservations(indices[count:], elevations[count:], stamps[count:]),
    )
