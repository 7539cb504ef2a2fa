"""Records of landmarks as a small blob: runs of one contributor, ids as gaps, everything in as few bytes as it needs.

A run is: contributor + 1 (0 for seals), number of records, then per record the id's distance from the run's previous id
(from 0 for the first), the height's difference from the previous height, attempts (left out in runs of seals), and
information; all as base-128 numbers, least significant part first, signed ones zigzagged. A record of a seen landmark
mostly takes six bytes.
"""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.landmark_records import (
    MAX_ATTEMPTS,
    MAX_HEIGHT_QUANTA,
    MAX_INFORMATION,
    SEAL,
    LandmarkRecords,
)

MAX_RECORDS = 4_096
"""In one blob."""
MAX_LANDMARKS = 2**24
MAX_CONTRIBUTORS = 64
_LONGEST = 5
"""Bytes of the longest number that can be said."""


def pack_landmarks(records: LandmarkRecords) -> bytes:
    """Pack records, sorted by contributor and id; ValueError when there are more than `MAX_RECORDS`."""
    if len(records) > MAX_RECORDS:
        raise ValueError(f"one blob tells at most {MAX_RECORDS} landmarks; tell them in parts")
    records = records[np.lexsort((records.landmarks, records.contributors))]
    blob = bytearray()
    owners, starts, counts = np.unique(records.contributors, return_index=True, return_counts=True)
    for owner, start, count in zip(owners.tolist(), starts.tolist(), counts.tolist(), strict=True):
        _append(blob, owner + 1)
        _append(blob, count)
        run = records[slice(start, start + count)]
        landmark = height = 0
        for ahead, up, attempts, information in zip(
            run.landmarks.tolist(), run.heights.tolist(), run.attempts.tolist(), run.information.tolist(), strict=True
        ):
            _append(blob, ahead - landmark)
            _append(blob, _zigzag(up - height))
            landmark, height = ahead, up
            if owner != SEAL:
                _append(blob, attempts)
            _append(blob, information)
    return bytes(blob)


def unpack_landmarks(blob: bytes) -> LandmarkRecords | None:
    """Unpack a blob; None when it is not a valid one. Never raises, and never makes more than `MAX_RECORDS` rows.

    What it returns is well formed; whether it can be true is for `LandmarkMap.merge` to say.
    """
    reader = _Reader(blob)
    rows: list[tuple[int, int, int, int, int]] = []
    while not reader.at_end:
        owner, count = reader.number() - 1, reader.number()
        if reader.failed or owner >= MAX_CONTRIBUTORS or not 1 <= count <= MAX_RECORDS - len(rows):
            return None
        landmark = height = 0
        for _ in range(count):
            landmark += reader.number()
            height += _unzigzag(reader.number())
            attempts = 0 if owner == SEAL else reader.number()
            information = reader.number()
            if reader.failed or not (
                landmark < MAX_LANDMARKS
                and abs(height) <= MAX_HEIGHT_QUANTA
                and attempts <= MAX_ATTEMPTS
                and information <= MAX_INFORMATION
            ):
                return None
            rows.append((landmark, owner, attempts, height, information))
    if not rows:
        return LandmarkRecords.empty()
    return LandmarkRecords(*np.array(rows, dtype=np.int64).T.copy())


class _Reader:
    """Reads numbers one after the other; once one is cut short or too long, it has failed and reads zeros."""

    def __init__(self, blob: bytes) -> None:
        self._blob, self._at = blob, 0
        self.failed = False

    @property
    def at_end(self) -> bool:
        return self._at >= len(self._blob)

    def number(self) -> int:
        value = 0
        for place in range(_LONGEST):
            if self.failed or self.at_end:
                break
            part = self._blob[self._at]
            self._at += 1
            value |= (part & 127) << (7 * place)
            if part < 128:
                return value
        self.failed = True
        return 0


def _append(blob: bytearray, number: int) -> None:
    while number > 127:
        blob.append(128 | (number & 127))
        number >>= 7
    blob.append(number)


def _zigzag(number: int) -> int:
    return 2 * number if number >= 0 else -2 * number - 1


def _unzigzag(number: int) -> int:
    return number >> 1 if number % 2 == 0 else -((number + 1) >> 1)
