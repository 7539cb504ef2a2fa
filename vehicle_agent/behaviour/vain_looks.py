"""What did not come into sight from where it should have: left alone for a while, and in the end for good."""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.voxel_evidence import ByteArray
from vehicle_agent.domain.voxels import UNKNOWN

LOOKED_AT_MOST = 2
"""A voxel that is not seen from where it should be so many times is left alone for good."""


class VainLooks:
    """One vehicle's.

    Attributes
    ----------
    out_of_sight : (U, V, W) bool, what is left alone now.
    """

    def __init__(self, shape: tuple[int, int, int]) -> None:
        self._looks = np.zeros(shape, dtype=np.uint8)
        self.out_of_sight: BoolArray = np.zeros(shape, dtype=np.bool_)

    def note(self, expected: IndexArray, states: ByteArray) -> None:
        """Leave alone what was expected, flat indices (N,), and is unknown in the states (U, V, W) yet."""
        vain = expected[states.ravel()[expected] == UNKNOWN]
        self._looks.ravel()[vain] = np.minimum(self._looks.ravel()[vain] + 1, LOOKED_AT_MOST)
        self.out_of_sight.ravel()[vain] = True

    def try_again(self) -> None:
        """Leave alone only what was looked for in vain often enough."""
        self.out_of_sight = self._looks >= LOOKED_AT_MOST
