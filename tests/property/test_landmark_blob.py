"""Packed records of landmarks: nothing is lost on the way, few bytes each, and no bytes harm who unpacks them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.domain.landmark_records import (
    MAX_ATTEMPTS,
    MAX_HEIGHT_QUANTA,
    MAX_INFORMATION,
    SEAL,
    LandmarkRecords,
)
from vehicle_agent.wire.landmark_blob import (
    MAX_CONTRIBUTORS,
    MAX_LANDMARKS,
    MAX_RECORDS,
    pack_landmarks,
    unpack_landmarks,
)

Row = tuple[int, int, int, int, int]


@st.composite
def rows(draw: st.DrawFn) -> Row:
    owner = draw(st.integers(SEAL, MAX_CONTRIBUTORS - 1))
    attempts = 0 if owner == SEAL else draw(st.integers(0, MAX_ATTEMPTS))
    landmark, height = (
        draw(st.integers(0, MAX_LANDMARKS - 1)),
        draw(st.integers(-MAX_HEIGHT_QUANTA, MAX_HEIGHT_QUANTA)),
    )
    return (landmark, owner, attempts, height, draw(st.integers(0, MAX_INFORMATION)))


def records_of(said: list[Row]) -> LandmarkRecords:
    return LandmarkRecords(*np.array(said, dtype=np.int64).reshape(-1, 5).T.copy())


def rows_of(records: LandmarkRecords) -> list[Row]:
    columns = (records.landmarks, records.contributors, records.attempts, records.heights, records.information)
    return list(zip(*(column.tolist() for column in columns), strict=True))


@given(st.lists(rows(), max_size=60))
def test_round_trip(said: list[Row]) -> None:
    unpacked = unpack_landmarks(pack_landmarks(records_of(said)))
    assert unpacked is not None
    assert sorted(rows_of(unpacked)) == sorted(said)


@given(st.binary(max_size=200))
def test_any_bytes_are_refused_or_well_formed(blob: bytes) -> None:
    unpacked = unpack_landmarks(blob)
    if unpacked is not None:
        assert len(unpacked) <= MAX_RECORDS
        assert np.all((unpacked.landmarks >= 0) & (unpacked.landmarks < MAX_LANDMARKS))
        assert np.all((unpacked.contributors >= SEAL) & (unpacked.contributors < MAX_CONTRIBUTORS))
        assert np.all(np.abs(unpacked.heights) <= MAX_HEIGHT_QUANTA)
        assert np.all((unpacked.attempts >= 0) & (unpacked.attempts <= MAX_ATTEMPTS))
        assert np.all((unpacked.information >= 0) & (unpacked.information <= MAX_INFORMATION))


@given(st.lists(rows(), min_size=1, max_size=20), st.data())
def test_a_truncated_blob_is_refused_or_shorter(said: list[Row], data: st.DataObject) -> None:
    blob = pack_landmarks(records_of(said))
    unpacked = unpack_landmarks(blob[: data.draw(st.integers(0, len(blob) - 1))])
    assert unpacked is None or len(unpacked) < len(said)


def test_neighbouring_landmarks_take_few_bytes() -> None:
    count = 25
    ids = np.arange(5_000, 5_000 + count)
    records = LandmarkRecords(
        ids, np.full(count, 1), np.full(count, 7), 400 + (ids % 9), np.where(ids % 2 == 0, 900, 1_500)
    )
    assert len(pack_landmarks(records)) <= 6 * count + 4


def test_a_claim_of_more_records_than_allowed_is_refused_at_once() -> None:
    assert unpack_landmarks(bytes([1, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F])) is None
    too_many = records_of([(0, 0, 1, 0, 1)] * (MAX_RECORDS + 1))
    with pytest.raises(ValueError, match="parts"):
        pack_landmarks(too_many)
