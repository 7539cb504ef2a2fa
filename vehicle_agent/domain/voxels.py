"""The voxel map of a team: what is free, what is surface, who saw it first; and how two maps merge.

Each contributor (a vehicle) counts, per voxel, scans that hit it and scans that crossed it. Counts only grow and stop
growing where log odds would be clamped, so that merging is the larger of two counts: commutative, associative and
idempotent. A voxel's log odds are the sum over contributors. Of surface voxels the map keeps the earliest hit and its
observers, by the same rule as the elevation map (Renzaglia 2020 eq. 4).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.elevation import MAX_OBSERVERS, UNOBSERVED_STAMP_MS, StampArray
from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.voxel_evidence import (
    HIT_STEP,
    MAX_HITS,
    MAX_MISSES,
    ByteArray,
    VoxelEvidence,
    is_occupied,
)
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.domain.voxel_kernels import (
    BLOCK,
    BLOCK_VOXELS,
    CountArray,
    add_evidence,
    blocks_in_box,
    draw_rays,
    fold_marks,
    fold_stamps,
    slots_with,
    voxels_of_block,
)

UNKNOWN, FREE, OCCUPIED = 0, 1, 2
"""States of a voxel."""
HIT_LOG_ODDS, MISS_LOG_ODDS = 0.85, -0.4
"""Of one scan; probabilities 0.7 and 0.4, as in OctoMap (Hornung 2013)."""
Scalar = TypeVar("Scalar", bound=np.generic)
MAX_RANGE_VOXELS = 250.0
MAX_BLOCKS = 200_000
"""100 million voxels: 100 MB for each contributor that has seen them all."""


class VoxelMap:
    """Evidence of every contributor over a voxel grid, in blocks of 512 voxels that exist once something is known.

    Attributes
    ----------
    grid
        The voxels.
    refused_voxels
        How often a voxel was left out because the map holds `max_blocks` blocks already.
    """

    def __init__(self, grid: VoxelGrid, max_blocks: int = MAX_BLOCKS) -> None:
        if max_blocks < 1:
            raise ValueError("max_blocks must be at least 1")
        self.grid = grid
        self.refused_voxels = 0
        self._max_blocks = max_blocks
        self._shape = np.array(grid.shape, dtype=np.int64)
        self._blocks = -(-self._shape // BLOCK)
        self._slots = np.full(int(np.prod(self._blocks)), -1, dtype=np.int32)
        self._block_ids = np.empty(0, dtype=np.int64)
        self._evidence: dict[int, ByteArray] = {}
        self._untold: dict[int, ByteArray] = {}
        self._surface_slots = np.empty(0, dtype=np.int32)
        self._surface_stamps_ms: StampArray = np.empty((0, BLOCK_VOXELS), dtype=np.int64)
        self._surface_observers = np.empty((0, BLOCK_VOXELS), dtype=np.uint64)
        self._surfaces = 0
        self._marks: ByteArray = np.zeros(0, dtype=np.uint8)

    @property
    def blocks(self) -> int:
        """Number of blocks of which something is known."""
        return len(self._block_ids)

    @property
    def memory_bytes(self) -> int:
        """Size of the map's arrays."""
        arrays: list[npt.NDArray[Any]] = [
            self._slots,
            self._block_ids,
            self._surface_slots,
            self._surface_stamps_ms,
            self._surface_observers,
        ]
        arrays += [*self._evidence.values(), *self._untold.values(), self._marks]
        return sum(array.nbytes for array in arrays)

    def insert(
        self,
        contributor: int,
        sensor_enu_m: Point,
        ends_enu_m: FloatArray,
        max_range_m: float,
        stamp_ms: int,
        returned: BoolArray | None = None,
    ) -> None:
        """Add one scan: each ray's voxels were crossed, and its last voxel was hit.

        Parameters
        ----------
        ends_enu_m : (N, 3) float64, where the rays end, ENU metres.
        max_range_m : rays are followed so far; a longer one hits nothing.
        returned : (N,) bool; a ray that did not return crossed its last voxel too. All returned when left out.

        Raises ValueError for a contributor outside the team, points that are not finite, and a range of no or of more
        than MAX_RANGE_VOXELS voxels.
        """
        check_contributor(contributor)
        voxel_m = self.grid.voxel_m
        max_range = max_range_m / voxel_m
        if not 0.0 < max_range <= MAX_RANGE_VOXELS:
            raise ValueError(f"a scan's range must be positive and at most {MAX_RANGE_VOXELS:g} voxels")
        sensor = (np.asarray(sensor_enu_m, dtype=np.float64) - self.grid.corner_enu_m) / voxel_m
        ends = (np.asarray(ends_enu_m, dtype=np.float64).reshape(-1, 3) - self.grid.corner_enu_m) / voxel_m
        if not (np.isfinite(sensor).all() and np.isfinite(ends).all() and np.abs(sensor).max() < 1e9):
            raise ValueError("a scan's points must be finite")
        if returned is None:
            returned = np.ones(len(ends), dtype=np.bool_)
        box = _box_around(sensor, max_range)
        size = int(np.prod(box[3:]))
        if len(self._marks) < size:
            self._marks = np.zeros(size, dtype=np.uint8)
        marks = self._marks[:size]
        draw_rays(marks, box, sensor, ends, returned, max_range)
        self._give_slots(np.flatnonzero(blocks_in_box(marks, box, self._blocks)))
        evidence, untold = self._counts_of(contributor)
        hits, lost = fold_marks(marks, box, self._shape, self._slots, self._blocks, evidence, untold, len(ends))
        self.refused_voxels += lost
        stamps = np.full(len(hits), stamp_ms, dtype=np.int64)
        self._fold_stamps(hits, stamps, np.full(len(hits), 1 << contributor, dtype=np.uint64))

    def take_untold(self, contributor: int) -> VoxelEvidence:
        """Evidence of a contributor that grew since the last call: the next delta to tell."""
        if contributor not in self._untold:
            return _NOTHING
        untold = self._untold[contributor]
        chosen = untold != 0
        untold[chosen] = 0
        return self._evidence_where(contributor, chosen)

    def evidence_of(self, contributor: int) -> VoxelEvidence:
        """Everything that a contributor is known to have seen."""
        if contributor not in self._evidence:
            return _NOTHING
        return self._evidence_where(contributor, self._evidence[contributor] != 0)

    @property
    def contributors(self) -> tuple[int, ...]:
        return tuple(sorted(self._evidence))

    def observe(self, contributor: int, told: VoxelEvidence) -> None:
        """Fold in what a contributor told: the larger counts and the earlier first hits stay.

        Raises ValueError for what `VoxelEvidence` rules out.
        """
        check_contributor(contributor)
        if len(told) == 0:
            return
        indices = told.voxel_indices
        if indices[0] < 0 or indices[-1] >= self.grid.voxels or np.any(indices[1:] <= indices[:-1]):
            raise ValueError("voxel indices must be strictly increasing and inside the grid")
        if told.hits.max() > MAX_HITS or told.misses.max() > MAX_MISSES:
            raise ValueError("a voxel counts more scans than a contributor may say")
        first = told.stamps_ms != UNOBSERVED_STAMP_MS
        if np.any(first & (told.hits == 0)):
            raise ValueError("a voxel has a first hit only when it was hit")
        slots, local = self._places(indices)
        kept = slots >= 0
        self.refused_voxels += int(len(kept) - kept.sum())
        where = (slots[kept], local[kept])
        evidence, _ = self._counts_of(contributor)
        mine = evidence[where]
        hits = np.maximum(mine // HIT_STEP, told.hits[kept])
        evidence[where] = hits * HIT_STEP + np.maximum(mine % HIT_STEP, told.misses[kept])
        bits = np.full(int(first.sum()), 1 << contributor, dtype=np.uint64)
        self._fold_stamps(indices[first], told.stamps_ms[first], bits)

    def merge(self, other: VoxelMap) -> None:
        """Join another map into this one; the grids must be equal, or ValueError."""
        if other.grid != self.grid:
            raise ValueError("maps of different grids do not merge")
        for contributor in other.contributors:
            counts = other.evidence_of(contributor)
            slots, local = self._places(counts.voxel_indices)
            kept = slots >= 0
            where = (slots[kept], local[kept])
            evidence, _ = self._counts_of(contributor)
            hits = np.maximum(evidence[where] // HIT_STEP, counts.hits[kept])
            evidence[where] = hits * HIT_STEP + np.maximum(evidence[where] % HIT_STEP, counts.misses[kept])
        surface, stamps, observers = other.surface()
        self._places(surface)
        self._fold_stamps(surface, stamps, observers)

    def surface(self) -> tuple[IndexArray, StampArray, npt.NDArray[np.uint64]]:
        """Voxels ever hit, by flat index and increasing; their first stamps; their first observers as bits."""
        slots = np.flatnonzero(self._surface_slots >= 0)
        rows = self._surface_slots[slots]
        voxels = self._voxels_of(slots)
        stamps, observers = self._surface_stamps_ms[rows], self._surface_observers[rows]
        hit = stamps != UNOBSERVED_STAMP_MS
        order = np.argsort(voxels[hit])
        return voxels[hit][order], stamps[hit][order], observers[hit][order]

    @property
    def observed(self) -> BoolArray:
        """(columns, rows, layers) bool, the surface that is known by now: occupied voxels."""
        observed: BoolArray = self.states() == OCCUPIED
        return observed

    def first_observer_share(self, observer: int, within: BoolArray | None = None) -> float:
        """J_E of one vehicle: occupied voxels it hit first, each divided by its first observers (Renzaglia eq. 5).

        `within` is (columns, rows, layers) bool, or (columns, rows) for whole columns; everywhere when left out.
        """
        voxels, _, observers = self.surface()
        mine = (observers & np.uint64(1 << observer)) != 0
        counted = self.observed
        if within is not None:
            counted &= within if within.ndim == 3 else within[:, :, None]
        mine &= counted.ravel()[voxels]
        return float(np.sum(1.0 / np.bitwise_count(observers[mine])))

    def log_odds(self) -> npt.NDArray[np.float32]:
        """(columns, rows, layers) float32, sum over contributors; 0 also where nothing is known."""
        hits, misses = self._counts()
        odds = np.float32(HIT_LOG_ODDS) * hits + np.float32(MISS_LOG_ODDS) * misses
        return odds.reshape(self.grid.shape).astype(np.float32)

    def states(self) -> ByteArray:
        """(columns, rows, layers) uint8: UNKNOWN, FREE, or OCCUPIED where log odds are positive."""
        hits, misses = self._counts()
        states = np.where(is_occupied(hits, misses), OCCUPIED, FREE).astype(np.uint8)
        states[(hits == 0) & (misses == 0)] = UNKNOWN
        return states.reshape(self.grid.shape)

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Everything in it as named arrays, for `of_arrays`."""
        kept: dict[str, npt.NDArray[Any]] = {"contributors": np.array(self.contributors, dtype=np.int64)}
        for contributor in self.contributors:
            told = self.evidence_of(contributor)
            for name in _ARRAYS:
                kept[f"{name}_{contributor}"] = getattr(told, name)
        return kept

    @classmethod
    def of_arrays(cls, grid: VoxelGrid, arrays: Mapping[str, npt.NDArray[Any]]) -> VoxelMap:
        """A map from its arrays; KeyError or ValueError when they are not those of a map on this grid."""
        loaded = cls(grid)
        for contributor in arrays["contributors"].tolist():
            indices, hits, misses, stamps = (arrays[f"{name}_{contributor}"] for name in _ARRAYS)
            loaded.observe(contributor, VoxelEvidence(indices, hits, misses, stamps))
        return loaded

    def copy(self) -> VoxelMap:
        duplicate = VoxelMap(self.grid, self._max_blocks)
        duplicate.merge(self)
        return duplicate

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, VoxelMap):
            return NotImplemented
        if self.grid != other.grid:
            return False
        pairs: list[tuple[npt.NDArray[Any], npt.NDArray[Any]]] = list(zip(self.surface(), other.surface(), strict=True))
        for contributor in {*self.contributors, *other.contributors}:
            mine, theirs = self.evidence_of(contributor), other.evidence_of(contributor)
            pairs += [(mine.voxel_indices, theirs.voxel_indices), (mine.hits, theirs.hits)]
            pairs += [(mine.misses, theirs.misses)]
        return all(np.array_equal(mine, theirs) for mine, theirs in pairs)

    __hash__ = None  # type: ignore[assignment]

    def _counts(self) -> tuple[CountArray, CountArray]:
        """Hits and misses of all contributors: (voxels,) uint16 each."""
        hits, misses = np.zeros(self.grid.voxels, dtype=np.uint16), np.zeros(self.grid.voxels, dtype=np.uint16)
        for evidence in self._evidence.values():
            add_evidence(hits, misses, self._block_ids, evidence, self._shape, self._blocks)
        return hits, misses

    def _give_slots(self, block_ids: IndexArray) -> None:
        """Make sure that the map holds these blocks, as far as it may."""
        new = block_ids[self._slots[block_ids] < 0][: self._max_blocks - self.blocks]
        if len(new) == 0:
            return
        self._slots[new] = np.arange(self.blocks, self.blocks + len(new), dtype=np.int32)
        self._block_ids = np.concatenate((self._block_ids, new))
        if self.blocks > len(self._surface_slots):
            self._surface_slots = _grown(self._surface_slots, self.blocks, -1)

    def _counts_of(self, contributor: int) -> tuple[ByteArray, ByteArray]:
        """A contributor's evidence and what of it is untold: (slots or more, BLOCK_VOXELS) uint8 each."""
        for counts in (self._evidence, self._untold):
            held = counts.get(contributor, np.zeros((0, BLOCK_VOXELS), dtype=np.uint8))
            counts[contributor] = _grown(held, self.blocks, 0) if len(held) < self.blocks else held
        return self._evidence[contributor], self._untold[contributor]

    def _places(self, voxels: IndexArray) -> tuple[IndexArray, IndexArray]:
        """Slot (-1 when the map is full) and place in the block of voxels; makes the blocks they need."""
        column, row, layer = np.unravel_index(voxels, self.grid.shape)
        _, rows, layers = self._blocks
        block = ((column // BLOCK) * rows + row // BLOCK) * layers + layer // BLOCK
        self._give_slots(np.unique(block))
        local = ((column % BLOCK) * BLOCK + row % BLOCK) * BLOCK + layer % BLOCK
        return self._slots[block].astype(np.int64), local

    def _fold_stamps(self, voxels: IndexArray, stamps_ms: StampArray, bits: npt.NDArray[np.uint64]) -> None:
        if len(voxels) == 0:
            return
        needed = np.flatnonzero(slots_with(voxels, self._shape, self._blocks, self._slots, self.blocks))
        new = needed[self._surface_slots[needed] < 0]
        if len(new):
            self._surface_slots[new] = np.arange(self._surfaces, self._surfaces + len(new), dtype=np.int32)
            self._surfaces += len(new)
            if self._surfaces > len(self._surface_stamps_ms):
                stamps = _grown(self._surface_stamps_ms, self._surfaces, UNOBSERVED_STAMP_MS)
                self._surface_stamps_ms = stamps
                self._surface_observers = _grown(self._surface_observers, self._surfaces, 0)
        fold_stamps(
            voxels, stamps_ms, bits, self._shape, self._blocks, self._slots, self._surface_slots,
            self._surface_stamps_ms, self._surface_observers,
        )  # fmt: skip

    def _voxels_of(self, slots: IndexArray) -> IndexArray:
        """Flat indices of the voxels of some slots: (S, BLOCK_VOXELS) int64, -1 outside the grid."""
        voxels = np.empty((len(slots), BLOCK_VOXELS), dtype=np.int64)
        for place, slot in enumerate(slots):
            voxels[place] = voxels_of_block(int(self._block_ids[slot]), self._shape, self._blocks)
        return voxels

    def _evidence_where(self, contributor: int, chosen: BoolArray) -> VoxelEvidence:
        slots = np.flatnonzero(chosen.any(axis=1))
        picked = chosen[slots]
        voxels = self._voxels_of(slots)[picked]
        values = self._evidence[contributor][slots][picked]
        order = np.argsort(voxels)
        hits = values[order] // HIT_STEP
        return VoxelEvidence(
            voxels[order], hits, values[order] % HIT_STEP, self._first_stamps(contributor, slots, picked)[order]
        )

    def _first_stamps(self, observer: int, slots: IndexArray, picked: BoolArray) -> StampArray:
        """Stamps of the picked voxels of some slots where an observer is among the first; else UNOBSERVED_STAMP_MS."""
        stamps = np.full(picked.shape, UNOBSERVED_STAMP_MS, dtype=np.int64)
        rows = self._surface_slots[slots]
        held = rows >= 0
        first = (self._surface_observers[rows[held]] & np.uint64(1 << observer)) != 0
        stamps[held] = np.where(first, self._surface_stamps_ms[rows[held]], UNOBSERVED_STAMP_MS)
        return stamps[picked]


_ARRAYS = ("voxel_indices", "hits", "misses", "stamps_ms")
_NOTHING = VoxelEvidence(
    np.empty(0, np.int64), np.empty(0, np.uint8), np.empty(0, np.uint8), np.empty(0, dtype=np.int64)
)


def newly_decided(news: VoxelEvidence, told: ByteArray) -> VoxelEvidence:
    """Of a contributor's evidence what makes voxels free or occupied that were told otherwise or not at all.

    Parameters
    ----------
    told : (voxels,) uint8, the states that were told; brought up to date.
    """
    states = decided_states(news)
    changed = told[news.voxel_indices] != states
    told[news.voxel_indices] = states
    return news.chosen(changed)


def decided_states(evidence: VoxelEvidence) -> ByteArray:
    """FREE or OCCUPIED by this evidence alone: (N,) uint8."""
    return np.where(is_occupied(evidence.hits, evidence.misses), OCCUPIED, FREE).astype(np.uint8)


def check_contributor(contributor: int) -> None:
    """Raise ValueError for a contributor that has no bit among the observers."""
    if not 0 <= contributor < MAX_OBSERVERS:
        raise ValueError(f"contributor {contributor} is outside 0..{MAX_OBSERVERS - 1}")


def _box_around(sensor: FloatArray, max_range: float) -> IndexArray:
    """Lowest voxel and size of the box that holds every ray from a sensor, aligned to blocks: (6,) int64."""
    reach = math.ceil(max_range) + 1
    centre = np.floor(sensor).astype(np.int64)
    low = (centre - reach) // BLOCK * BLOCK
    high = -(-(centre + reach + 1) // BLOCK) * BLOCK
    return np.concatenate((low, high - low))


def _grown(held: npt.NDArray[Scalar], needed: int, fill: int) -> npt.NDArray[Scalar]:
    """A longer array with the same beginning: room for twice what is needed now."""
    longer = np.full((2 * needed, *held.shape[1:]), fill, dtype=held.dtype)
    longer[: len(held)] = held
    return longer
