"""Voxel blobs lose nothing, and forged ones are refused without raising."""

from __future__ import annotations

import zlib

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_agent.domain.elevation import UNOBSERVED_STAMP_MS
from vehicle_agent.domain.voxel_evidence import VoxelEvidence
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.domain.voxels import VoxelMap
from vehicle_agent.wire.voxel_blob import pack_voxels, unpack_voxels

GRID = VoxelGrid(0.0, 0.0, 0.0, 1.0, 40, 30, 20)


@st.composite
def evidence(draw: st.DrawFn) -> VoxelEvidence:
    indices = sorted(draw(st.sets(st.integers(0, GRID.voxels - 1), max_size=30)))
    counts = [draw(st.tuples(st.integers(0, 4), st.integers(0, 5)).filter(any)) for _ in indices]
    stamps = [
        draw(st.just(UNOBSERVED_STAMP_MS) | st.integers(0, 2**53)) if hits else UNOBSERVED_STAMP_MS
        for hits, _ in counts
    ]
    return VoxelEvidence(
        np.array(indices, dtype=np.int64),
        np.array([hits for hits, _ in counts], dtype=np.uint8),
        np.array([misses for _, misses in counts], dtype=np.uint8),
        np.array(stamps, dtype=np.int64),
    )


@settings(deadline=None)
@given(evidence())
def test_what_is_packed_comes_back(told: VoxelEvidence) -> None:
    heard = unpack_voxels(pack_voxels(told), GRID.voxels)
    assert heard is not None
    for name in ("voxel_indices", "hits", "misses", "stamps_ms"):
        assert getattr(heard, name).tolist() == getattr(told, name).tolist()
        assert getattr(heard, name).dtype == getattr(told, name).dtype


@settings(deadline=None)
@given(st.binary(max_size=300) | st.binary(max_size=300).map(zlib.compress))
def test_noise_is_refused_or_a_map_can_take_it(noise: bytes) -> None:
    heard = unpack_voxels(noise, GRID.voxels)
    if heard is not None:
        assert all(0 <= index < GRID.voxels for index in heard.voxel_indices.tolist())
        VoxelMap(GRID).observe(0, heard)


@settings(deadline=None)
@given(evidence(), st.data())
def test_a_forged_byte_is_refused_or_harmless(told: VoxelEvidence, data: st.DataObject) -> None:
    raw = bytearray(zlib.decompress(pack_voxels(told))) if len(told) else bytearray(b"x")
    raw[data.draw(st.integers(0, len(raw) - 1))] = data.draw(st.integers(0, 255))
    heard = unpack_voxels(zlib.compress(bytes(raw)), GRID.voxels)
    if heard is not None:
        VoxelMap(GRID).observe(0, heard)
    assert unpack_voxels(pack_voxels(told), max(1, int(told.voxel_indices[-1])) if len(told) else 1) is None or (
        len(told) == 0 or told.voxel_indices[-1] == 0
    )


def test_a_blob_that_inflates_beyond_the_grid_is_refused() -> None:
    assert unpack_voxels(zlib.compress(b"\0" * 50_000_000), GRID.voxels) is None
