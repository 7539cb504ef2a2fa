"""Landmarks: heights of a surface at known places, estimated by weighted least squares (Kapoutsis 2015, section 3).

Per landmark the map keeps what every contributor measured so far, as one record of that contributor's running sums,
and, once anybody estimated it accurately, one seal. A join keeps the greatest record of each contributor and the
greatest seal; so merging is commutative, associative and idempotent, and repetition, loss and disorder neither count a
measurement twice nor lose what a later record tells. Sums are whole numbers: equal records give equal maps, to the bit.
"""

from __future__ import annotations

import math
import zlib
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.landmark_belief import LandmarkBelief
from vehicle_agent.domain.landmark_layout import LandmarkLayout, LandmarkParams
from vehicle_agent.domain.landmark_records import (
    ACCURATE,
    MAX_INFORMATION,
    SEAL,
    Integers,
    LandmarkRecords,
    attempts_of,
    height_of,
    information_of,
    records_of,
    word_of,
)
from vehicle_agent.domain.polygon import BoolArray


@dataclass(frozen=True, slots=True)
class Merged:
    """What a merge did.

    Attributes
    ----------
    changed
        Ids of landmarks of which the map knows more now, increasing.
    sealed
        Those of them that became accurately estimated, increasing.
    dropped
        Records refused, by reason: `unknown landmark`, `unknown contributor`, `impossible attempts`,
        `impossible height`, `too confident`.
    """

    changed: IndexArray
    sealed: IndexArray
    dropped: Counter[str] = field(default_factory=Counter)


class LandmarkMap:
    """What one vehicle knows of all landmarks: measured by itself or told by teammates.

    Attributes
    ----------
    layout, params
        As given.
    own_index
        This vehicle's team index.
    heights_m
        (N,) float64, ENU z of each landmark as estimated; NaN where nobody known to this vehicle measured it.
    sd_m
        (N,) float64, standard deviation of `heights_m`; infinite where nothing is known.
    accurate
        (N,) bool, accurately estimated (A^L of definition 2): once True, always True.
    attempts
        (N,) int64, measurements known of.

    All arrays are kept up to date in place: copy what must not change.

    >>> layout = LandmarkLayout(np.array([[0.0, 0.0], [1.0, 0.0]]), 1.0)
    >>> params = LandmarkParams(accurate_sd_m=0.1, best_sd_m=0.05, lowest_m=-10.0, highest_m=10.0)
    >>> mine, theirs = (LandmarkMap(layout, params, vehicles=2, own_index=index) for index in range(2))
    >>> for _ in range(4):
    ...     sealed = mine.observe(np.array([1]), np.array([2.5]), np.array([0.2]))
    >>> bool(mine.accurate[1]), float(mine.heights_m[1])
    (True, 2.5)
    >>> merged = theirs.merge(mine.records())
    >>> theirs == mine, theirs.merge(mine.records()).changed.size
    (True, 0)
    """

    def __init__(self, layout: LandmarkLayout, params: LandmarkParams, vehicles: int, own_index: int) -> None:
        if not 0 <= own_index < vehicles <= 64:
            raise ValueError(f"vehicle {own_index} is not one of a team of {vehicles}, at most 64")
        self.layout, self.params, self.own_index = layout, params, own_index
        count = len(layout)
        self._belief = LandmarkBelief(count, vehicles, params)
        self.heights_m: FloatArray = np.full(count, np.nan)
        self.sd_m: FloatArray = np.full(count, np.inf)
        self.accurate: BoolArray = np.zeros(count, dtype=np.bool_)
        self.attempts: Integers = np.zeros(count, dtype=np.int64)
        # A record is one whole number (attempts, information, height from its highest bits on): greater is later.
        self._contributed: Integers = np.zeros((vehicles, count), dtype=np.int64)
        self._seals: Integers = np.zeros(count, dtype=np.int64)
        self._own_information: FloatArray = np.zeros(count)
        self._own_height_m: FloatArray = np.zeros(count)

    @property
    def vehicles(self) -> int:
        """Size of the team."""
        return len(self._contributed)

    @property
    def given_up(self) -> BoolArray:
        """(N,) bool: measured up to the limit of attempts and still not accurate (footnote 3)."""
        given_up: BoolArray = ~self.accurate & (self.attempts >= self.params.attempts_limit)
        return given_up

    @property
    def open(self) -> BoolArray:
        """(N,) bool: neither accurate nor given up, so still worth a measurement."""
        worthwhile: BoolArray = ~self.accurate & (self.attempts < self.params.attempts_limit)
        return worthwhile

    @property
    def information(self) -> FloatArray:
        """(N,) float64, inverse variance over that of an accurate landmark: 1 and more is accurate, 0 unknown."""
        share: FloatArray = (self.params.accurate_sd_m / self.sd_m) ** 2
        return share

    @property
    def own_information(self) -> FloatArray:
        """(N,) float64, the part of `information` that this vehicle measured itself."""
        return self._own_information

    def observe(self, landmarks: IndexArray, heights_m: FloatArray, sds_m: FloatArray) -> IndexArray:
        """Fold this vehicle's own measurements in; those of landmarks that are not open change nothing.

        Parameters
        ----------
        landmarks : (M,) int64, distinct ids; heights_m, sds_m : (M,) float64, ENU z as measured and its standard
            deviation (made no better than the sensor's limit). Rows not finite or negative count as attempts only.

        Returns
        -------
        Ids that became accurately estimated, in the order given. Raises ValueError when an id is unknown or repeated.
        """
        ids = np.asarray(landmarks, dtype=np.int64)
        if len(ids) == 0:
            return ids
        if ids.min() < 0 or ids.max() >= len(self.layout) or len(np.unique(ids)) != len(ids):
            raise ValueError("landmarks measured must be distinct ids of the layout")
        worthwhile = ~self.accurate[ids] & (self.attempts[ids] < self.params.attempts_limit)
        ids, heights, sds = ids[worthwhile], heights_m[worthwhile], sds_m[worthwhile]
        good = np.isfinite(heights) & np.isfinite(sds) & (sds >= 0.0)
        most = self.params.best_information / ACCURATE
        limited = np.fmax(sds, self.params.accurate_sd_m / math.sqrt(most))
        gained = np.where(good, (self.params.accurate_sd_m / limited) ** 2, 0.0)
        total = self._own_information[ids] + gained
        before = self._own_height_m[ids]
        share = np.divide(gained, total, out=np.zeros_like(total), where=total > 0)
        step = share * np.where(good, heights - before, 0.0)
        self._own_information[ids] = total
        self._own_height_m[ids] = np.clip(before + step, self.params.lowest_m, self.params.highest_m)
        attempts = attempts_of(self._contributed[self.own_index, ids]) + 1
        whole = np.minimum(np.floor(total * ACCURATE).astype(np.int64), MAX_INFORMATION)
        quanta = np.rint(self._own_height_m[ids] / self.params.quantum_m).astype(np.int64)
        self._contributed[self.own_index, ids] = word_of(attempts, whole, quanta)
        return self._refresh(ids)

    def merge(self, records: LandmarkRecords) -> Merged:
        """Join what a teammate says; impossible records are dropped and counted, never raised."""
        dropped: Counter[str] = Counter()
        records = self._belief.sifted(records, dropped)
        if len(records) == 0:
            return Merged(np.empty(0, np.int64), np.empty(0, np.int64), dropped)
        words = word_of(records.attempts, records.information, records.heights)
        sealing = records.contributors == SEAL
        ids, owners = records.landmarks, records.contributors
        newer = np.where(
            sealing,
            words > self._seals[ids],
            words > self._contributed[np.where(sealing, 0, owners), ids],
        )
        changed = np.unique(ids[newer])
        np.maximum.at(self._seals, ids[newer & sealing], words[newer & sealing])
        told = newer & ~sealing
        np.maximum.at(self._contributed, (owners[told], ids[told]), words[told])
        self._adopt(np.unique(ids[told & (owners == self.own_index)]))
        return Merged(changed, self._refresh(changed), dropped)

    def gain_of(self, records: LandmarkRecords) -> FloatArray:
        """What each record would add: (N,) float64, information as in `information`, at most 1, and 1 more for a seal.

        Nothing (0) where the landmark is accurate already, and for records of landmarks or contributors unknown.
        """
        gain = np.zeros(len(records))
        rows = np.flatnonzero(self._belief.is_known(records) & self._belief.is_of_team(records))
        rows = rows[~self.accurate[records.landmarks[rows]]]
        ids, owners = records.landmarks[rows], records.contributors[rows]
        sealing = owners == SEAL
        before = information_of(self._contributed[np.where(sealing, 0, owners), ids])
        more = (records.information[rows] - before) / ACCURATE
        gain[rows] = np.where(sealing, 2.0 - np.minimum(self.information[ids], 1.0), np.clip(more, 0.0, 1.0))
        return gain

    def records(self, landmarks: IndexArray | None = None) -> LandmarkRecords:
        """Everything known, of all landmarks or of some: what a repair sends. Seals come first."""
        ids = np.arange(len(self.layout)) if landmarks is None else np.asarray(landmarks, dtype=np.int64)
        owners, rows = np.nonzero(self._contributed[:, ids])
        told = records_of(ids[rows], owners.astype(np.int64), self._contributed[owners, ids[rows]])
        return LandmarkRecords.joined(self.seals(ids), told)

    def seals(self, landmarks: IndexArray) -> LandmarkRecords:
        """Seals of those of the landmarks that are accurately estimated, in the order given."""
        ids = landmarks[self.accurate[landmarks]]
        return records_of(ids, np.full(len(ids), SEAL, dtype=np.int64), self._seals[ids])

    def own_records(self, landmarks: IndexArray) -> LandmarkRecords:
        """What this vehicle itself measured of those of the landmarks that it measured, in the order given."""
        ids = landmarks[self._contributed[self.own_index, landmarks] != 0]
        return records_of(ids, np.full(len(ids), self.own_index, np.int64), self._contributed[self.own_index, ids])

    def digest(self, blocks: int) -> tuple[int, ...]:
        """A checksum per block of landmarks (see `block_of`): maps of equal digests have equal estimates.

        What was measured of a landmark before it became accurate counts no more, and is told no more.
        """
        return tuple(self._checksum(self.block_of(block, blocks)) for block in range(blocks))

    def block_of(self, block: int, blocks: int) -> IndexArray:
        """Ids of one of so many blocks of landmarks."""
        edges = np.linspace(0, len(self.layout), blocks + 1).astype(int)
        return np.arange(edges[block], edges[block + 1], dtype=np.int64)

    def _checksum(self, ids: IndexArray) -> int:
        waiting = np.where(self.accurate[ids], 0, self._contributed[:, ids])
        return zlib.crc32(self._seals[ids].tobytes(), zlib.crc32(waiting.tobytes()))

    def __eq__(self, other: object) -> bool:
        """Whether both know the same, whoever they are."""
        if not isinstance(other, LandmarkMap):
            return NotImplemented
        return np.array_equal(self._contributed, other._contributed) and np.array_equal(self._seals, other._seals)

    __hash__ = None  # type: ignore[assignment]

    def _adopt(self, ids: IndexArray) -> None:
        """Continue own sums that a teammate remembers better: those of before a restart."""
        words = self._contributed[self.own_index, ids]
        self._own_information[ids] = information_of(words) / ACCURATE
        self._own_height_m[ids] = height_of(words) * self.params.quantum_m

    def _refresh(self, ids: IndexArray) -> IndexArray:
        """Bring the arrays of some landmarks up to date; return those that became accurate."""
        words = self._contributed[:, ids]
        information, heights = information_of(words), height_of(words)
        self.attempts[ids] = attempts_of(words).sum(axis=0)
        total = information.sum(axis=0)
        mean = np.rint((information * heights).sum(axis=0) / np.maximum(total, 1)).astype(np.int64)
        due = (total >= ACCURATE) & (self._seals[ids] == 0)
        self._seals[ids[due]] = word_of(np.zeros(int(due.sum()), np.int64), total[due], mean[due])
        seals = self._seals[ids]
        sealed = seals != 0
        total = np.where(sealed, information_of(seals), total)
        mean = np.where(sealed, height_of(seals), mean)
        known = total > 0
        self.heights_m[ids] = np.where(known, mean * self.params.quantum_m, np.nan)
        with np.errstate(divide="ignore"):
            self.sd_m[ids] = np.where(known, self.params.accurate_sd_m * np.sqrt(ACCURATE / total), np.inf)
        new = sealed & ~self.accurate[ids]
        self.accurate[ids[new]] = True
        newly: IndexArray = ids[new]
        return newly
