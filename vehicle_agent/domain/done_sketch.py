"""A few bytes that say which landmarks around a place are done: much less than their heights, and enough to leave them.

A sketch names a landmark and has one bit for each of those nearest to it, the landmark itself among them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.landmarks import LandmarkLayout
from vehicle_agent.domain.polygon import BoolArray

SKETCH_BYTES = 6
"""Of bits: with the landmark's id a sketch takes as much as a record of one landmark."""


@dataclass(frozen=True, slots=True)
class DoneSketch:
    """What is done around a landmark.

    Attributes
    ----------
    centre
        Id of the landmark.
    bits
        `SKETCH_BYTES` bytes, the most significant bit of the first for the lowest id of those that are nearest.
    """

    centre: int
    bits: bytes


class SketchBook:
    """Makes and reads sketches of one layout; everybody with the same layout reads the same."""

    def __init__(self, layout: LandmarkLayout) -> None:
        self._layout = layout
        self._around: dict[int, IndexArray] = {}

    def centre_at(self, east_m: float, north_m: float) -> int:
        """The landmark nearest to a place."""
        places = self._layout.positions_en_m
        return int(np.argmin((places[:, 0] - east_m) ** 2 + (places[:, 1] - north_m) ** 2))

    def around(self, centre: int) -> IndexArray:
        """Ids that a sketch around a landmark speaks of, increasing."""
        found = self._around.get(centre)
        if found is None:
            offsets = (self._layout.positions_en_m - self._layout.positions_en_m[centre]) / self._layout.spacing_m
            away = np.rint(1e3 * np.hypot(offsets[:, 0], offsets[:, 1]))  # so that rounding decides no order
            found = np.sort(np.argsort(away, kind="stable")[: 8 * SKETCH_BYTES])
            self._around[centre] = found
        return found

    def sketch(self, done: BoolArray, centre: int) -> DoneSketch:
        """What of the landmarks around one is done, from (N,) bool."""
        marked = np.zeros(8 * SKETCH_BYTES, dtype=np.bool_)
        around = self.around(centre)
        marked[: len(around)] = done[around]
        return DoneSketch(centre, np.packbits(marked).tobytes())

    def done_in(self, sketch: DoneSketch) -> IndexArray:
        """Ids that a sketch calls done; none when it cannot be of this layout."""
        if not 0 <= sketch.centre < len(self._layout) or len(sketch.bits) != SKETCH_BYTES:
            return np.empty(0, np.int64)
        around = self.around(sketch.centre)
        marked = np.unpackbits(np.frombuffer(sketch.bits, dtype=np.uint8))[: len(around)]
        return around[marked > 0]
