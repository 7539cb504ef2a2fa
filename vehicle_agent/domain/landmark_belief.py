"""Which records of landmarks can be true: what cannot is dropped and counted before it reaches a map."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.landmark_layout import LandmarkParams
from vehicle_agent.domain.landmark_records import ACCURATE, MAX_ATTEMPTS, SEAL, LandmarkRecords
from vehicle_agent.domain.polygon import BoolArray


@dataclass(frozen=True, slots=True)
class LandmarkBelief:
    """Judges what teammates say.

    Attributes
    ----------
    landmarks, vehicles
        How many there are.
    params
        What the sensors can tell at best.
    """

    landmarks: int
    vehicles: int
    params: LandmarkParams

    def sifted(self, records: LandmarkRecords, dropped: Counter[str]) -> LandmarkRecords:
        """The records that can be true; of the others `dropped` counts the reasons."""
        for reason, possible in (
            ("unknown landmark", self.is_known),
            ("unknown contributor", self.is_of_team),
            ("impossible attempts", self._was_attempted),
            ("impossible height", self._is_within),
            ("too confident", self._is_attainable),
        ):
            good = possible(records)
            if not good.all():
                dropped[reason] += int(np.count_nonzero(~good))
                records = records[good]
        return records

    def is_known(self, records: LandmarkRecords) -> BoolArray:
        """(N,) bool, records of landmarks that exist."""
        known: BoolArray = (records.landmarks >= 0) & (records.landmarks < self.landmarks)
        return known

    def is_of_team(self, records: LandmarkRecords) -> BoolArray:
        """(N,) bool, records of contributors that exist, and seals."""
        ours: BoolArray = (records.contributors >= SEAL) & (records.contributors < self.vehicles)
        return ours

    def _was_attempted(self, records: LandmarkRecords) -> BoolArray:
        within = (records.attempts >= 1) & (records.attempts <= self.params.attempts_limit)
        return np.where(records.contributors == SEAL, records.attempts == 0, within)

    def _is_within(self, records: LandmarkRecords) -> BoolArray:
        low, high = (height / self.params.quantum_m for height in (self.params.lowest_m, self.params.highest_m))
        within: BoolArray = (records.heights >= low - 1) & (records.heights <= high + 1)
        return within

    def _is_attainable(self, records: LandmarkRecords) -> BoolArray:
        """A contributor stops when a landmark is accurate, so that it exceeds that by one measurement at most."""
        one = self.params.best_information
        most = np.minimum(np.clip(records.attempts, 0, MAX_ATTEMPTS) * one, ACCURATE + one)
        told = (records.information >= 0) & (records.information <= most)
        sealed = (records.information >= ACCURATE) & (records.information <= self.vehicles * (ACCURATE + one))
        return np.where(records.contributors == SEAL, sealed, told)
