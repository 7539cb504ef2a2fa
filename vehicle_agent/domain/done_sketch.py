"""A few bytes that say what is done around a place: much less than landmarks' heights, and enough to leave them.

Landmarks lie in square patches. A sketch names a patch and has one bit for each of those nearest to it, itself among
them: whether all landmarks of that patch are done.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.landmark_layout import LandmarkLayout
from vehicle_agent.domain.polygon import BoolArray

SKETCH_BYTES = 6
"""Of bits: with the patch's number a sketch takes about as much as a record of one landmark."""


@dataclass(frozen=True, slots=True)
class DoneSketch:
    """What is done around a place.

    Attributes
    ----------
    centre
        Number of the patch there.
    bits
        `SKETCH_BYTES` bytes, the most significant bit of the first for the lowest of the numbers that are nearest.
    """

    centre: int
    bits: bytes


class SketchBook:
    """Makes and reads sketches of one layout; all that have the same layout and patches read the same.

    Parameters
    ----------
    patch_m
        Edge of the patches; a landmark each when this is not above the landmarks' spacing.
    """

    def __init__(self, layout: LandmarkLayout, patch_m: float) -> None:
        places = layout.positions_en_m
        low, extent = places.min(axis=0), np.ptp(places, axis=0)
        if patch_m <= layout.spacing_m:
            self._patch_of = np.arange(len(layout), dtype=np.int64)
        else:
            columns, rows = (max(1, math.ceil(side / patch_m)) for side in extent)
            at = np.minimum(((places - low) / patch_m).astype(np.int64), [columns - 1, rows - 1])
            _, self._patch_of = np.unique(at[:, 0] * rows + at[:, 1], return_inverse=True)
        self._sizes = np.bincount(self._patch_of)
        sums = [np.bincount(self._patch_of, places[:, axis]) for axis in (0, 1)]
        self._centres_en_m = np.column_stack(sums) / self._sizes[:, None]
        self._edge_m = max(patch_m, layout.spacing_m)
        self._around: dict[int, IndexArray] = {}

    def centre_at(self, east_m: float, north_m: float) -> int:
        """The patch nearest to a place."""
        centres = self._centres_en_m
        return int(np.argmin((centres[:, 0] - east_m) ** 2 + (centres[:, 1] - north_m) ** 2))

    def sketch(self, done: BoolArray, centre: int) -> DoneSketch:
        """What around a patch is done, from (N,) bool."""
        marked = np.zeros(8 * SKETCH_BYTES, dtype=np.bool_)
        around = self._patches_around(centre)
        whole = np.bincount(self._patch_of[done], minlength=len(self._sizes)) == self._sizes
        marked[: len(around)] = whole[around]
        return DoneSketch(centre, np.packbits(marked).tobytes())

    def is_readable(self, sketch: DoneSketch) -> bool:
        """Whether a sketch can be of this layout."""
        return 0 <= sketch.centre < len(self._sizes) and len(sketch.bits) == SKETCH_BYTES

    def landmarks_in(self, sketch: DoneSketch) -> IndexArray:
        """Ids of landmarks that a sketch calls done, increasing; none when it cannot be of this layout."""
        if not self.is_readable(sketch):
            return np.empty(0, np.int64)
        around = self._patches_around(sketch.centre)
        marked = np.unpackbits(np.frombuffer(sketch.bits, dtype=np.uint8))[: len(around)]
        called = np.zeros(len(self._sizes), dtype=np.bool_)
        called[around[marked > 0]] = True
        return np.flatnonzero(called[self._patch_of])

    def _patches_around(self, centre: int) -> IndexArray:
        """Numbers of the patches that a sketch speaks of, increasing."""
        found = self._around.get(centre)
        if found is None:
            offsets = (self._centres_en_m - self._centres_en_m[centre]) / self._edge_m
            away = np.rint(1e3 * np.hypot(offsets[:, 0], offsets[:, 1]))  # so that rounding decides no order
            found = np.sort(np.argsort(away, kind="stable")[: 8 * SKETCH_BYTES])
            self._around[centre] = found
        return found
