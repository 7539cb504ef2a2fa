"""A range image as a small blob.

Layout before deflation (little endian): rays u32, stamp u64 (ms), sensor 3 x f64 (ENU m), unit f64 (m), then for each
ray a u16: its range in units, + 32768 where it returned.
"""

from __future__ import annotations

import math
import struct
import zlib

import numpy as np

from vehicle_agent.domain.range_image import RangeImage
from vehicle_agent.wire.cells import MAX_STAMP_MS

_HEADER = struct.Struct("<IQdddd")
_RETURNED = 32_768
FASTEST = 1
"""Deflation level: scans stay on their vehicle, where time is dearer than bytes."""


def pack_ranges(image: RangeImage) -> bytes:
    """Pack a range image; ranges are rounded to 1 / 32767 of the longest."""
    unit = max(float(image.ranges_m.max(initial=0.0)), 1e-3) / (_RETURNED - 1)
    counts = np.rint(image.ranges_m / unit).astype(np.uint16) + np.where(image.returned, _RETURNED, 0).astype(np.uint16)
    header = _HEADER.pack(len(image), image.stamp_ms, *image.sensor_enu_m, unit)
    return zlib.compress(header + counts.astype("<u2").tobytes(), FASTEST)


def unpack_ranges(blob: bytes, rays: int) -> RangeImage | None:
    """Unpack a range image of so many rays; None when it is not one. Never raises."""
    size = _HEADER.size + 2 * rays
    try:
        inflater = zlib.decompressobj()
        raw = inflater.decompress(blob, size + 1)
        count, stamp_ms, east_m, north_m, up_m, unit = _HEADER.unpack_from(raw)
    except (zlib.error, struct.error):
        return None
    if count != rays or len(raw) != size or stamp_ms > MAX_STAMP_MS:
        return None
    if not all(map(math.isfinite, (east_m, north_m, up_m))) or not 0.0 < unit < 1.0:
        return None
    counts = np.frombuffer(raw, dtype="<u2", count=rays, offset=_HEADER.size)
    ranges = (counts % _RETURNED * unit).astype(np.float32)
    return RangeImage((east_m, north_m, up_m), ranges, counts >= _RETURNED, stamp_ms)
