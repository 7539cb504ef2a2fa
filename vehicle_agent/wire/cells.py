"""Observed cells as a small blob: sorted indices as gaps, elevations and stamps as differences, deflated.

Layout before deflation (little endian): count u32, first index u32, base elevation i32 (dm), base stamp u64 (ms), three
width codes u8 (bytes per item: 0 means all zero, else 1, 2, 4 or 8), then gaps - 1 (unsigned), zigzag elevation
differences and stamp offsets from the base, each as plain arrays of its width.
"""

from __future__ import annotations

import struct
import zlib

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.elevation import CellObservations

_HEADER = struct.Struct("<IIiQBBB")
_WIDTHS = (1, 2, 4, 8)
MAX_CELLS = 4_000_000
MAX_ELEVATION_DM = 250_000
"""25 km: beyond what any datum and any ground or sea floor make; also the bound on what a liar can claim."""
MAX_STAMP_MS = 2**53


def pack_cells(observations: CellObservations) -> bytes:
    """Pack observations; `cell_indices` must be strictly increasing (as `CellObservations` promises)."""
    count = len(observations)
    if count == 0:
        return b""
    indices = observations.cell_indices.astype(np.int64)
    elevations = observations.elevations_dm.astype(np.int64)
    stamps = observations.stamps_ms.astype(np.int64)
    steps = np.diff(elevations)
    columns = (
        (np.diff(indices) - 1).astype(np.uint64),
        ((steps << 1) ^ (steps >> 63)).astype(np.uint64),
        (stamps - stamps.min()).astype(np.uint64),
    )
    widths = [_width(column) for column in columns]
    header = _HEADER.pack(count, int(indices[0]), int(elevations[0]), int(stamps.min()), *widths)
    body = b"".join(
        column.astype(f"<u{width}").tobytes() if width else b"" for column, width in zip(columns, widths, strict=True)
    )
    return zlib.compress(header + body, 6)


def unpack_cells(blob: bytes, grid_cells: int) -> CellObservations | None:
    """Unpack a blob for a grid of `grid_cells` cells; None when it is not a valid blob. Never raises."""
    if not blob:
        return CellObservations(np.empty(0, np.int64), np.empty(0, np.int32), np.empty(0, np.int64))
    limit = _HEADER.size + 24 * min(grid_cells, MAX_CELLS)
    try:
        inflater = zlib.decompressobj()
        raw = inflater.decompress(blob, limit)
        if not inflater.eof or inflater.unused_data:
            return None
        count, first_index, base_elevation, base_stamp, *widths = _HEADER.unpack_from(raw)
    except (zlib.error, struct.error):
        return None
    if not 0 < count <= min(grid_cells, MAX_CELLS) or base_stamp > MAX_STAMP_MS:
        return None
    columns = []
    offset = _HEADER.size
    for width, items in zip(widths, (count - 1, count - 1, count), strict=True):
        if width not in (0, *_WIDTHS) or offset + width * items > len(raw):
            return None
        column = (
            np.frombuffer(raw, dtype=f"<u{width}", count=items, offset=offset).astype(np.uint64)
            if width
            else np.zeros(items, dtype=np.uint64)
        )
        columns.append(column)
        offset += width * items
    if offset != len(raw):
        return None
    gaps, zigzag, stamp_offsets = columns
    if (
        np.any(gaps >= grid_cells)
        or np.any(zigzag > 4 * MAX_ELEVATION_DM)
        or np.any(stamp_offsets > MAX_STAMP_MS - base_stamp)
    ):
        return None
    indices = np.cumsum(np.concatenate(([first_index], gaps.astype(np.int64) + 1)))
    steps = (zigzag >> np.uint64(1)).astype(np.int64) ^ -(zigzag & np.uint64(1)).astype(np.int64)
    elevations = np.cumsum(np.concatenate(([base_elevation], steps)))
    stamps = base_stamp + stamp_offsets.astype(np.int64)
    if indices[-1] >= grid_cells or np.any(np.abs(elevations) > MAX_ELEVATION_DM):
        return None
    return CellObservations(indices, elevations.astype(np.int32), stamps)


def _width(column: npt.NDArray[np.uint64]) -> int:
    if len(column) == 0:
        return 0
    largest = int(column.max())
    if largest == 0:
        return 0
    return next(width for width in _WIDTHS if largest < 1 << (8 * width))
