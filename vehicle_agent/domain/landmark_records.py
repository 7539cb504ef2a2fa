"""What is said of landmarks: records, and the whole numbers that order them (Kapoutsis 2015, section 3.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray

SEAL = -1
"""Contributor of a record that says: accurately estimated, by whomever."""
ACCURATE = 1024
"""Information of a landmark whose standard deviation is just the accurate one; information counts in these parts."""
QUANTA_PER_ACCURATE_SD = 8
"""Heights are whole quanta of this part of the accurate standard deviation."""
MAX_ATTEMPTS = 10_000
MAX_INFORMATION = 2**23 - 1
MAX_HEIGHT_QUANTA = 2**23 - 1

_HEIGHT_BITS, _INFORMATION_BITS = 24, 23
_HEIGHT_MASK, _INFORMATION_MASK = 2**_HEIGHT_BITS - 1, 2**_INFORMATION_BITS - 1
_HEIGHT_BASE = MAX_HEIGHT_QUANTA

Integers = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class LandmarkRecords:
    """What is said of landmarks: one row each, arrays of the same length, int64.

    Attributes
    ----------
    landmarks
        Ids.
    contributors
        Team index of who measured; `SEAL` for an accurately estimated landmark.
    attempts
        How often the contributor has measured it; 0 for a seal.
    heights
        The contributor's estimate (of all together, for a seal) in quanta of `LandmarkParams.quantum_m`, ENU z.
    information
        Inverse variance in parts of `ACCURATE` over the accurate variance; at least `ACCURATE` for a seal.
    """

    landmarks: Integers
    contributors: Integers
    attempts: Integers
    heights: Integers
    information: Integers

    def __len__(self) -> int:
        return len(self.landmarks)

    def __getitem__(self, rows: slice | IndexArray | BoolArray) -> LandmarkRecords:
        return LandmarkRecords(
            self.landmarks[rows],
            self.contributors[rows],
            self.attempts[rows],
            self.heights[rows],
            self.information[rows],
        )

    @classmethod
    def empty(cls) -> LandmarkRecords:
        return cls(*(np.empty(0, np.int64) for _ in range(5)))

    @classmethod
    def joined(cls, *parts: LandmarkRecords) -> LandmarkRecords:
        """All rows of all parts, in that order."""
        return cls(
            np.concatenate([part.landmarks for part in parts]),
            np.concatenate([part.contributors for part in parts]),
            np.concatenate([part.attempts for part in parts]),
            np.concatenate([part.heights for part in parts]),
            np.concatenate([part.information for part in parts]),
        )


def word_of(attempts: Integers, information: Integers, heights: Integers) -> Integers:
    """Records as one whole number each, attempts in its highest bits, then information and height: greater is later."""
    words: Integers = (
        (attempts << (_INFORMATION_BITS + _HEIGHT_BITS)) | (information << _HEIGHT_BITS) | (heights + _HEIGHT_BASE)
    )
    return words


def attempts_of(words: Integers) -> Integers:
    """Attempts of words of `word_of`."""
    attempts: Integers = words >> (_INFORMATION_BITS + _HEIGHT_BITS)
    return attempts


def information_of(words: Integers) -> Integers:
    """Information of words of `word_of`."""
    information: Integers = (words >> _HEIGHT_BITS) & _INFORMATION_MASK
    return information


def height_of(words: Integers) -> Integers:
    """Heights of words of `word_of`, in quanta."""
    heights: Integers = (words & _HEIGHT_MASK) - _HEIGHT_BASE
    return heights


def records_of(landmarks: Integers, contributors: Integers, words: Integers) -> LandmarkRecords:
    """Records of words of `word_of`, a landmark and a contributor for each."""
    return LandmarkRecords(landmarks, contributors, attempts_of(words), height_of(words), information_of(words))
