"""Voxel evidence as a small blob: sorted indices as gaps, a byte of counts each, stamps of first hits, deflated.

Layout before deflation (little endian): count u32, stamped u32, first index u32, base stamp u64 (ms), two width codes
u8 (bytes per item: 0 means all zero, else 1, 2, 4 or 8), then gaps - 1 (count - 1 items), counts (one byte each:
misses + 8 x hits, + 128 where a stamp follows) and stamp offsets from the base (stamped items).
"""

from __future__ import annotations

import struct
import zlib

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.elevation import UNOBSERVED_STAMP_MS
from vehicle_agent.domain.voxel_evidence import HIT_STEP, MAX_HITS, MAX_MISSES, VoxelEvidence
from vehicle_agent.wire.cells import MAX_STAMP_MS

_HEADER = struct.Struct("<IIIQBB")
_WIDTHS = (1, 2, 4, 8)
_STAMPED = 128
MAX_VOXELS_TOLD = 1_000_000
"""In one blob; 17 MB unpacked at most."""


def pack_voxels(evidence: VoxelEvidence) -> bytes:
    """Pack evidence; `voxel_indices` must be strictly increasing (as `VoxelEvidence` promises)."""
    count = len(evidence)
    if count == 0:
        return b""
    if count > MAX_VOXELS_TOLD:
        raise ValueError(f"one blob tells at most {MAX_VOXELS_TOLD} voxels; tell them in parts")
    indices = evidence.voxel_indices.astype(np.int64)
    stamped = evidence.stamps_ms != UNOBSERVED_STAMP_MS
    stamps = evidence.stamps_ms[stamped]
    base = int(stamps.min()) if len(stamps) else 0
    gaps, offsets = (np.diff(indices) - 1).astype(np.uint64), (stamps - base).astype(np.uint64)
    counts = evidence.misses + HIT_STEP * evidence.hits + np.where(stamped, _STAMPED, 0)
    widths = (_width(gaps), _width(offsets))
    header = _HEADER.pack(count, len(stamps), int(indices[0]), base, *widths)
    return zlib.compress(
        header + _bytes(gaps, widths[0]) + counts.astype(np.uint8).tobytes() + _bytes(offsets, widths[1]), 6
    )


def unpack_voxels(blob: bytes, grid_voxels: int) -> VoxelEvidence | None:
    """Unpack a blob for a grid of so many voxels; None when it is not a valid blob. Never raises."""
    if not blob:
        empty = np.empty(0, np.uint8)
        return VoxelEvidence(np.empty(0, np.int64), empty, empty, np.empty(0, np.int64))
    most = min(grid_voxels, MAX_VOXELS_TOLD)
    try:
        inflater = zlib.decompressobj()
        raw = inflater.decompress(blob, _HEADER.size + 17 * most)
        if not inflater.eof or inflater.unused_data:
            return None
        count, stamped, first, base, *widths = _HEADER.unpack_from(raw)
    except (zlib.error, struct.error):
        return None
    if not 0 < count <= most or stamped > count or base > MAX_STAMP_MS or not set(widths) <= {0, *_WIDTHS}:
        return None
    if len(raw) != _HEADER.size + widths[0] * (count - 1) + count + widths[1] * stamped:
        return None
    at = _HEADER.size
    gaps = _items(raw, at, widths[0], count - 1)
    at += widths[0] * (count - 1)
    counts = np.frombuffer(raw, dtype=np.uint8, count=count, offset=at)
    offsets = _items(raw, at + count, widths[1], stamped)
    if np.any(gaps >= grid_voxels) or np.any(offsets > MAX_STAMP_MS - base):
        return None
    indices = np.cumsum(np.concatenate(([first], gaps.astype(np.int64) + 1)))
    has_stamp = counts >= _STAMPED
    hits, misses = counts % _STAMPED // HIT_STEP, counts % HIT_STEP
    if (
        indices[-1] >= grid_voxels
        or int(has_stamp.sum()) != stamped
        or np.any(has_stamp & (hits == 0))
        or np.any(hits > MAX_HITS)
        or np.any(misses > MAX_MISSES)
        or np.any(counts % _STAMPED == 0)
    ):
        return None
    stamps = np.full(count, UNOBSERVED_STAMP_MS, dtype=np.int64)
    stamps[has_stamp] = base + offsets.astype(np.int64)
    return VoxelEvidence(indices, hits.astype(np.uint8), misses.astype(np.uint8), stamps)


def _width(items: npt.NDArray[np.uint64]) -> int:
    largest = int(items.max(initial=0))
    return 0 if largest == 0 else next(width for width in _WIDTHS if largest < 1 << (8 * width))


def _bytes(items: npt.NDArray[np.uint64], width: int) -> bytes:
    return items.astype(f"<u{width}").tobytes() if width else b""


def _items(raw: bytes, offset: int, width: int, count: int) -> npt.NDArray[np.uint64]:
    if width == 0:
        return np.zeros(count, dtype=np.uint64)
    return np.frombuffer(raw, dtype=f"<u{width}", count=count, offset=offset).astype(np.uint64)
