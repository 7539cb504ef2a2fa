"""Packed cells: nothing is lost on the way, and no bytes harm who unpacks them."""

from __future__ import annotations

import random
import struct
import tracemalloc
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from vehicle_agent.domain.elevation import CellObservations
from vehicle_agent.wire.cells import MAX_ELEVATION_DM, MAX_STAMP_MS, pack_cells, unpack_cells

CELLS = 70_000
HEADER = "<IIiQBBB"


@st.composite
def observations(draw: st.DrawFn, cells: int = CELLS) -> CellObservations:
    if draw(st.booleans()):  # a scan: runs of neighbours
        first = draw(st.integers(0, cells - 1))
        indices = np.arange(first, min(cells, first + draw(st.integers(1, 300))), dtype=np.int64)
    else:
        indices = np.array(sorted(draw(st.sets(st.integers(0, cells - 1), max_size=40))), dtype=np.int64)
    low, high = draw(st.sampled_from([(-MAX_ELEVATION_DM, MAX_ELEVATION_DM), (4_300, 4_500), (7, 7)]))
    start, spread = draw(st.sampled_from([(0, MAX_STAMP_MS), (1_767_225_600_000, 2_000), (MAX_STAMP_MS, 0), (0, 0)]))
    elevations = draw(hnp.arrays(np.int32, len(indices), elements=st.integers(low, high)))
    stamps = draw(hnp.arrays(np.int64, len(indices), elements=st.integers(start, start + spread)))
    return CellObservations(indices, elevations, stamps)


def same(a: CellObservations, b: CellObservations) -> bool:
    return (
        np.array_equal(a.cell_indices, b.cell_indices)
        and np.array_equal(a.elevations_dm, b.elevations_dm)
        and np.array_equal(a.stamps_ms, b.stamps_ms)
    )


def is_sound(cells: CellObservations, grid_cells: int) -> bool:
    """Tell whether observations are what `CellObservations` and a grid of so many cells promise."""
    return (
        len(cells) == len(cells.elevations_dm) == len(cells.stamps_ms)
        and cells.cell_indices.dtype == np.int64
        and cells.elevations_dm.dtype == np.int32
        and cells.stamps_ms.dtype == np.int64
        and bool(np.all(np.diff(cells.cell_indices) > 0))
        and bool(np.all((cells.cell_indices >= 0) & (cells.cell_indices < grid_cells)))
        and bool(np.all(np.abs(cells.elevations_dm.astype(np.int64)) <= MAX_ELEVATION_DM))
        and bool(np.all((cells.stamps_ms >= 0) & (cells.stamps_ms <= MAX_STAMP_MS)))
    )


@given(observations())
def test_round_trip(cells: CellObservations) -> None:
    unpacked = unpack_cells(pack_cells(cells), CELLS)
    assert unpacked is not None
    assert same(unpacked, cells)
    assert is_sound(unpacked, CELLS)


@given(observations())
def test_cells_outside_the_receivers_grid_are_refused(cells: CellObservations) -> None:
    if len(cells) == 0:
        return
    blob, last = pack_cells(cells), int(cells.cell_indices[-1])
    assert unpack_cells(blob, last) is None
    assert unpack_cells(blob, last + 1) is not None


@given(observations(), st.data())
def test_a_truncated_blob_is_refused(cells: CellObservations, data: st.DataObject) -> None:
    blob = pack_cells(cells)
    if len(blob) > 1:
        assert unpack_cells(blob[: data.draw(st.integers(1, len(blob) - 1))], CELLS) is None
    if blob:
        assert unpack_cells(blob + b"\0", CELLS) is None


@given(st.binary(max_size=200), st.integers(0, CELLS))
def test_random_bytes(data: bytes, grid_cells: int) -> None:
    for blob in (data, zlib.compress(data)):
        cells = unpack_cells(blob, grid_cells)
        assert cells is None or is_sound(cells, grid_cells)


@given(
    st.integers(0, 2**32 - 1) | st.integers(0, 5),
    st.integers(0, 2**32 - 1) | st.integers(0, CELLS),
    st.integers(-(2**31), 2**31 - 1) | st.integers(-MAX_ELEVATION_DM, MAX_ELEVATION_DM),
    st.integers(0, 2**64 - 1) | st.integers(MAX_STAMP_MS - 2, MAX_STAMP_MS + 2),
    st.lists(st.sampled_from([0, 1, 2, 3, 4, 8, 255]), min_size=3, max_size=3),
    st.binary(max_size=96) | st.integers(0, 96).map(lambda size: b"\xff" * size),
)
def test_forged_headers(count: int, first: int, elevation: int, stamp: int, widths: list[int], body: bytes) -> None:
    blob = zlib.compress(struct.pack(HEADER, count, first, elevation, stamp, *widths) + body)
    cells = unpack_cells(blob, CELLS)
    assert cells is None or is_sound(cells, CELLS)


def forge(
    gaps: list[int], zigzag: list[int], offsets: list[int], elevation: int = 0, stamp: int = 1_000, tail: bytes = b""
) -> bytes:
    """A blob with every column eight bytes wide, whatever the numbers mean."""
    body = struct.pack(f"<{len(gaps)}Q{len(zigzag)}Q{len(offsets)}Q", *gaps, *zigzag, *offsets)
    return zlib.compress(struct.pack(HEADER, len(offsets), 5, elevation, stamp, 8, 8, 8) + body + tail)


def test_a_forged_blob_without_a_fault_is_taken() -> None:
    cells = unpack_cells(forge([2], [3], [0, 9]), CELLS)
    assert cells is not None
    assert cells.cell_indices.tolist() == [5, 8]
    assert cells.elevations_dm.tolist() == [0, -2]
    assert cells.stamps_ms.tolist() == [1_000, 1_009]


@pytest.mark.parametrize(
    "blob",
    [
        forge([2], [3], [0, 9], tail=b"\0"),
        forge([2], [3], [0, 9], stamp=MAX_STAMP_MS + 1),
        forge([2], [3], [0, MAX_STAMP_MS - 999]),
        forge([2], [3], [0, 2**64 - 1]),
        forge([2], [3], [0, 9], elevation=MAX_ELEVATION_DM + 1),
        forge([2], [2 * MAX_ELEVATION_DM + 2], [0, 9]),
        forge([2], [2**64 - 1], [0, 9]),
        forge([2, 2], [2**64 - 1, 2**64 - 1], [0, 9, 9]),
        forge([2**64 - 1], [3], [0, 9]),
        forge([2**63], [3], [0, 9]),
        forge([2**63 - 1, 2**63 - 1], [3, 3], [0, 9, 9]),
        forge([CELLS], [3], [0, 9]),
    ],
    ids=[
        "tail", "late base", "late offset", "wrapping offset", "high base", "high step", "step to the lowest integer",
        "steps that wrap", "gap that repeats a cell", "negative gap", "gaps that wrap", "gap beyond the grid",
    ],
)  # fmt: skip
def test_one_fault_is_enough_to_be_refused(blob: bytes) -> None:
    assert unpack_cells(blob, CELLS) is None


def test_many_mutations_under_the_deflation() -> None:
    dice = random.Random(5)
    cells = CellObservations(
        np.arange(100, 400, dtype=np.int64),
        np.arange(4_300, 4_600, dtype=np.int32),
        1_767_225_600_000 + np.arange(300, dtype=np.int64) % 7,
    )
    raw = zlib.decompress(pack_cells(cells))
    accepted = 0
    for _ in range(5_000):
        forged = bytearray(raw)
        for _ in range(dice.randint(1, 4)):
            place = dice.randrange(struct.calcsize(HEADER) + 8) if dice.random() < 0.5 else dice.randrange(len(raw))
            forged[place] = dice.choice([0, 1, 127, 128, 255, dice.randrange(256)])
        if dice.random() < 0.2:
            del forged[dice.randrange(len(forged)) :]
        unpacked = unpack_cells(zlib.compress(bytes(forged), 1), CELLS)
        assert unpacked is None or is_sound(unpacked, CELLS)
        accepted += unpacked is not None
    assert accepted > 0


@pytest.mark.parametrize("head", [b"", struct.pack(HEADER, 4_000_000, 0, 0, 0, 0, 0, 0)])
def test_a_deflation_bomb_is_refused_before_it_unfolds(head: bytes) -> None:
    bomb = zlib.compress(head + bytes(50_000_000), 9)
    assert len(bomb) < 60_000
    tracemalloc.start()
    try:
        assert unpack_cells(bomb, CELLS) is None
        _, peak_bytes = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak_bytes < 10_000_000


def test_a_scan_is_packed_small() -> None:
    count = 900
    rng = np.random.default_rng(1)
    indices = np.concatenate([np.arange(30) + 200 * column for column in range(30)])
    cells = CellObservations(
        indices.astype(np.int64),
        (4_500 + np.cumsum(rng.integers(-30, 31, count))).astype(np.int32),
        np.full(count, 1_767_225_600_000, dtype=np.int64),
    )
    assert len(pack_cells(cells)) < 1.5 * count
