"""The team's merged map as immutable versions, with the sums that the dashboard shows kept up to date."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from vehicle_agent.domain.elevation import NO_ELEVATION_DM, CellObservations, ElevationArray, ElevationMap
from vehicle_agent.domain.grid import Grid, IndexArray
from vehicle_agent.domain.polygon import BoolArray


@dataclass(frozen=True, slots=True)
class TeamMap:
    """One version of the map; its arrays are read-only.

    Attributes
    ----------
    elevation
        The merged map.
    area
        (columns, rows) bool, the cells that count.
    area_cells
        How many those are.
    version
        Grows by one with every change.
    observed_cells
        Cells of the area that somebody observed.
    first_seen_cells
        Per team index, cells of the area seen first, ties shared: J_E of Renzaglia eq. 5.
    seen_per_second
        Cells of the area by the Unix second of their first observation.
    keeps_highest
        A cell shows the highest that was told of it, as a town from above; else what was observed first.
    """

    elevation: ElevationMap
    area: BoolArray
    area_cells: int
    version: int
    observed_cells: int
    first_seen_cells: tuple[float, ...]
    seen_per_second: Mapping[int, int]
    keeps_highest: bool = False

    @classmethod
    def empty(cls, grid: Grid, area: BoolArray, vehicles: int, keeps_highest: bool = False) -> TeamMap:
        blank, cells = _frozen(ElevationMap(grid)), int(np.count_nonzero(area))
        return cls(blank, area, cells, 0, 0, (0.0,) * vehicles, {}, keeps_highest)

    @property
    def coverage(self) -> float:
        """Observed share of the area's cells, in [0, 1]."""
        return self.observed_cells / max(1, self.area_cells)

    def first_seen_share(self, index: int) -> float:
        """Share of the area that one vehicle saw first, in [0, 1]."""
        return self.first_seen_cells[index] / max(1, self.area_cells)

    def joined_with(self, observations: Iterable[tuple[int, CellObservations]]) -> TeamMap:
        """The next version with (team index, observations) pairs folded in; itself when they change nothing.

        One copy of the arrays for the whole batch. Raises ValueError as `ElevationMap.observe` does.
        """
        draft = self.elevation.copy()
        shares = np.array(self.first_seen_cells)
        seconds = dict(self.seen_per_second)
        observed_cells = self.observed_cells
        changed_any = False
        for observer_index, cells in observations:
            before = _observed_part(draft, self.area, cells.cell_indices)
            stamps_before = draft.first_stamp_ms.ravel()[before]
            observers_before = draft.observers.ravel()[before]
            known_dm = draft.elevation_dm.ravel()[cells.cell_indices]
            changed = draft.observe(observer_index, cells)
            if self.keeps_highest:
                changed_any |= _raise_to(draft, cells, known_dm)
            if len(changed) == 0:
                continue
            changed_any = True
            after = _observed_part(draft, self.area, cells.cell_indices)
            _add_shares(shares, observers_before, -1.0)
            _add_shares(shares, draft.observers.ravel()[after], 1.0)
            _add_seconds(seconds, stamps_before, -1)
            _add_seconds(seconds, draft.first_stamp_ms.ravel()[after], 1)
            observed_cells += len(after) - len(before)
        if not changed_any:
            return self
        return replace(
            self,
            elevation=_frozen(draft),
            version=self.version + 1,
            observed_cells=observed_cells,
            first_seen_cells=tuple(shares.tolist()),
            seen_per_second=seconds,
        )


def coverage_curve(team_map: TeamMap, started_ms: int, points: int = 240) -> tuple[tuple[float, float], ...]:
    """Coverage over vehicle time, from the stamps of the map itself: a station that starts late draws all of it.

    Returns
    -------
    (seconds since `started_ms`, observed share in [0, 1]) pairs, both growing; at most `points`.
    """
    if not team_map.seen_per_second:
        return ()
    seconds = np.array(sorted(team_map.seen_per_second), dtype=np.int64)
    counts = np.array([team_map.seen_per_second[second] for second in seconds.tolist()], dtype=np.int64)
    shares = np.cumsum(counts) / max(1, team_map.area_cells)
    elapsed_s = np.maximum(0.0, seconds + 1.0 - started_ms / 1_000)
    if len(seconds) > points:
        kept = np.unique(np.linspace(0, len(seconds) - 1, points).astype(np.int64))
        elapsed_s, shares = elapsed_s[kept], shares[kept]
    return tuple(zip(elapsed_s.tolist(), shares.tolist(), strict=True))


def contribution_curves(
    team_map: TeamMap, started_ms: int, until_ms: int, columns: int
) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Share of the area that each vehicle has seen first over time, ties shared, from the map's own stamps.

    Returns
    -------
    (vehicles, columns) float64 in [0, 1], growing, at `columns` moments evenly from `started_ms` to `until_ms`.
    """
    seen = team_map.elevation.observed & team_map.area
    spans = (team_map.elevation.first_stamp_ms[seen] - started_ms) / max(1, until_ms - started_ms)
    places = np.clip((spans * columns).astype(np.int64), 0, columns - 1)
    words, which = np.unique(team_map.elevation.observers[seen], return_inverse=True)
    gains = np.zeros((len(team_map.first_seen_cells), columns))
    for at, word in enumerate(words.tolist()):
        counts = np.bincount(places[which == at], minlength=columns) / word.bit_count()
        for index in range(len(gains)):
            if word >> index & 1:
                gains[index] += counts
    curves: np.ndarray[tuple[int, int], np.dtype[np.float64]] = np.cumsum(gains, axis=1) / max(1, team_map.area_cells)
    return curves


def frontier_cells(team_map: TeamMap) -> BoolArray:
    """Observed cells of the area with an unobserved cell of the area on one of their four sides: (columns, rows)."""
    unknown = team_map.area & ~team_map.elevation.observed
    beside = np.zeros_like(unknown)
    beside[1:] |= unknown[:-1]
    beside[:-1] |= unknown[1:]
    beside[:, 1:] |= unknown[:, :-1]
    beside[:, :-1] |= unknown[:, 1:]
    frontiers: BoolArray = beside & team_map.area & team_map.elevation.observed
    return frontiers


def _raise_to(draft: ElevationMap, cells: CellObservations, known_dm: ElevationArray) -> bool:
    """Let cells show the highest of what was known and what is told; whether that changed any."""
    known = np.where(known_dm == NO_ELEVATION_DM, cells.elevations_dm, known_dm)
    highest = np.maximum(known, cells.elevations_dm)
    draft.elevation_dm.ravel()[cells.cell_indices] = highest
    return bool((highest != known_dm).any())


def _observed_part(elevation: ElevationMap, area: BoolArray, indices: IndexArray) -> IndexArray:
    counted = area.ravel()[indices] & (elevation.observers.ravel()[indices] != 0)
    part: IndexArray = indices[counted]
    return part


def _add_shares(shares: np.ndarray[tuple[int], np.dtype[np.float64]], observers: np.ndarray, sign: float) -> None:
    words, counts = np.unique(observers, return_counts=True)
    for word, count in zip(words.tolist(), counts.tolist(), strict=True):
        each = sign * count / word.bit_count()
        for index in range(len(shares)):
            if word >> index & 1:
                shares[index] += each


def _add_seconds(seconds: dict[int, int], stamps_ms: np.ndarray, sign: int) -> None:
    found, counts = np.unique(stamps_ms // 1_000, return_counts=True)
    for second, count in zip(found.tolist(), counts.tolist(), strict=True):
        total = seconds.get(second, 0) + sign * count
        if total:
            seconds[second] = total
        else:
            del seconds[second]


def _frozen(elevation: ElevationMap) -> ElevationMap:
    for array in (elevation.first_stamp_ms, elevation.observers, elevation.elevation_dm):
        array.flags.writeable = False
    return elevation
