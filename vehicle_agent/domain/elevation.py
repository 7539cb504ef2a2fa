"""The elevation map of a team: what is observed, who saw it first, how high it is; and how two maps merge.

Per cell the map keeps the earliest observation. Merging takes the earlier of two observations and, where both are
of the same instant, shares the honour (Renzaglia eq. 4: e(s) is a set) and keeps the lower elevation, so that merging
is commutative, associative and idempotent whatever it is fed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid, IndexArray
from vehicle_agent.domain.polygon import BoolArray

UNOBSERVED_STAMP_MS = int(np.iinfo(np.int64).max)
"""The stamp of a cell that nobody has observed: later than any observation."""
NO_ELEVATION_DM = int(np.iinfo(np.int32).max)
MAX_OBSERVERS = 64
"""Observers are bits of one 64-bit word per cell."""
_ARRAYS = ("first_stamp_ms", "observers", "elevation_dm")

StampArray = npt.NDArray[np.int64]
ElevationArray = npt.NDArray[np.int32]


@dataclass(frozen=True, slots=True)
class CellObservations:
    """Cells that one vehicle observed: what a sensor delivers and what a map delta carries.

    Attributes
    ----------
    cell_indices
        (N,) int64, flat indices into the grid, strictly increasing.
    elevations_dm
        (N,) int32, elevation of the cell's surface above the datum, decimetres (ENU z).
    stamps_ms
        (N,) int64, when each was observed, milliseconds of the vehicles' Unix time (GPS time).
    """

    cell_indices: IndexArray
    elevations_dm: ElevationArray
    stamps_ms: StampArray

    def __len__(self) -> int:
        return len(self.cell_indices)


class ElevationMap:
    """Earliest observation of every cell of a grid, mergeable in any order.

    Attributes
    ----------
    grid
        The cells.
    first_stamp_ms
        (columns, rows) int64, Unix time of the first observation; `UNOBSERVED_STAMP_MS` where there is none.
    observers
        (columns, rows) uint64, bit i set when the vehicle with team index i is among the first observers e(s).
    elevation_dm
        (columns, rows) int32, ENU z of the surface in decimetres; `NO_ELEVATION_DM` where unobserved.
    observed_cells
        How many cells are observed; it only grows, and tells `observed_since` how much of the map is known already.
    """

    __slots__ = ("_in_order", "elevation_dm", "first_stamp_ms", "grid", "observed_cells", "observers")

    def __init__(self, grid: Grid) -> None:
        self.grid = grid
        self.first_stamp_ms: StampArray = np.full(grid.shape, UNOBSERVED_STAMP_MS, dtype=np.int64)
        self.observers: npt.NDArray[np.uint64] = np.zeros(grid.shape, dtype=np.uint64)
        self.elevation_dm: ElevationArray = np.full(grid.shape, NO_ELEVATION_DM, dtype=np.int32)
        self.observed_cells = 0
        self._in_order: IndexArray = np.empty(grid.cells, dtype=np.int64)

    @property
    def observed(self) -> BoolArray:
        """(columns, rows) bool, E_t(S) of Renzaglia eq. 3."""
        observed: BoolArray = self.first_stamp_ms != UNOBSERVED_STAMP_MS
        return observed

    def observed_in(self, cells: tuple[slice, slice]) -> BoolArray:
        """The part of `observed` in a window of columns and rows, without looking at the rest."""
        observed: BoolArray = self.first_stamp_ms[cells] != UNOBSERVED_STAMP_MS
        return observed

    def observed_since(self, cells: int) -> IndexArray:
        """Flat indices of those that became observed after the first so many: (N,) int64, each cell once, to read."""
        return self._in_order[cells : self.observed_cells]

    @property
    def elevation_m(self) -> FloatArray:
        """(columns, rows) float64, ENU z of the surface in metres, NaN where unobserved."""
        return np.where(self.observed, self.elevation_dm * 0.1, np.nan)

    def elevation_where(self, columns: IndexArray, rows: IndexArray) -> FloatArray:
        """The part of `elevation_m` where columns and rows cross, (C, R), without looking at the rest."""
        cells = np.ix_(columns, rows)
        return np.where(self.first_stamp_ms[cells] != UNOBSERVED_STAMP_MS, self.elevation_dm[cells] * 0.1, np.nan)

    def observe(self, observer_index: int, observations: CellObservations) -> CellObservations:
        """Fold one vehicle's observations in and return those that changed the map (new, earlier or tied cells).

        Raises ValueError when the observer's index or a cell index lies outside the team or the grid, when the indices
        do not increase, or when a stamp is the one that means unobserved.
        """
        if not 0 <= observer_index < MAX_OBSERVERS:
            raise ValueError(f"observer index {observer_index} is outside 0..{MAX_OBSERVERS - 1}")
        indices = observations.cell_indices
        if len(indices) == 0:
            return observations
        if indices[0] < 0 or indices[-1] >= self.grid.cells:
            raise ValueError(f"cell index {indices[0]} or {indices[-1]} is outside a grid of {self.grid.cells} cells")
        if np.any(indices[1:] <= indices[:-1]):
            raise ValueError("cell indices must be strictly increasing")
        if observations.stamps_ms.max() >= UNOBSERVED_STAMP_MS:
            raise ValueError("a stamp is later than any observation can be")
        bits = np.full(len(indices), 1 << observer_index, dtype=np.uint64)
        changed = self._fold(indices, observations.stamps_ms, bits, observations.elevations_dm)
        return CellObservations(indices[changed], observations.elevations_dm[changed], observations.stamps_ms[changed])

    def merge(self, other: ElevationMap) -> None:
        """Join another map into this one; the grids must be equal, or ValueError."""
        if other.grid != self.grid:
            raise ValueError("maps of different grids do not merge")
        indices = np.flatnonzero(other.observed.ravel())
        self._fold(
            indices,
            other.first_stamp_ms.ravel()[indices],
            other.observers.ravel()[indices],
            other.elevation_dm.ravel()[indices],
        )

    def _fold(
        self, indices: IndexArray, stamps_ms: StampArray, bits: npt.NDArray[np.uint64], elevations_dm: ElevationArray
    ) -> BoolArray:
        stamps, observers, elevations = self.first_stamp_ms.ravel(), self.observers.ravel(), self.elevation_dm.ravel()
        mine = stamps[indices]
        earlier = stamps_ms < mine
        tied = stamps_ms == mine
        joined_bits = np.where(tied, observers[indices] | bits, bits)
        joined_elevations = np.where(tied, np.minimum(elevations[indices], elevations_dm), elevations_dm)
        changed: BoolArray = earlier | (
            tied & ((joined_bits != observers[indices]) | (joined_elevations != elevations[indices]))
        )
        self._note_observed(indices[mine == UNOBSERVED_STAMP_MS])
        where = indices[changed]
        stamps[where] = stamps_ms[changed]
        observers[where] = joined_bits[changed]
        elevations[where] = joined_elevations[changed]
        return changed

    def _note_observed(self, indices: IndexArray) -> None:
        self._in_order[self.observed_cells : self.observed_cells + len(indices)] = indices
        self.observed_cells += len(indices)

    def first_observer_share(self, observer_index: int, within: BoolArray | None = None) -> float:
        """J_E of one vehicle: cells it saw first, each divided by its number of first observers (Renzaglia eq. 5)."""
        bit = np.uint64(1 << observer_index)
        mine = (self.observers & bit) != 0
        if within is not None:
            mine &= within
        return float(np.sum(1.0 / np.bitwise_count(self.observers[mine])))

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Everything in it as named arrays, for `of_arrays`."""
        return {name: getattr(self, name) for name in _ARRAYS}

    @classmethod
    def of_arrays(cls, grid: Grid, arrays: Mapping[str, npt.NDArray[Any]]) -> ElevationMap:
        """A map from its arrays; KeyError or ValueError when they are not those of a map on this grid."""
        loaded = cls(grid)
        for name in _ARRAYS:
            getattr(loaded, name)[...] = arrays[name]
        loaded._note_observed(np.flatnonzero(loaded.observed))
        return loaded

    def copy(self) -> ElevationMap:
        duplicate = ElevationMap(self.grid)
        duplicate.first_stamp_ms[...] = self.first_stamp_ms
        duplicate.observers[...] = self.observers
        duplicate.elevation_dm[...] = self.elevation_dm
        duplicate._note_observed(self.observed_since(0))
        return duplicate

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ElevationMap):
            return NotImplemented
        return (
            self.grid == other.grid
            and np.array_equal(self.first_stamp_ms, other.first_stamp_ms)
            and np.array_equal(self.observers, other.observers)
            and np.array_equal(self.elevation_dm, other.elevation_dm)
        )

    __hash__ = None  # type: ignore[assignment]
