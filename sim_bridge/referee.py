"""Watches the truth: separation in the air and the fence, as no agent can see them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.polygon import BoolArray, points_inside

FENCE_PERIOD_S = 0.2


@dataclass(slots=True)
class Referee:
    """What went wrong so far.

    Attributes
    ----------
    fence_en_m
        (V, 2) float64, corners of the area.
    min_separation_m
        Smallest distance between two vehicles that were both in the air; infinite when there never were two.
    fence_breaches
        How often a vehicle in the air left the area.
    outside_s
        Vehicle seconds spent outside in the air.
    """

    fence_en_m: FloatArray
    min_separation_m: float = math.inf
    fence_breaches: int = 0
    outside_s: float = 0.0
    _outside: BoolArray = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    _unchecked_s: float = 0.0

    def observe(self, position_enu_m: FloatArray, airborne: BoolArray, dt_s: float) -> None:
        """Look at one instant: (N, 3) positions, (N,) who is in the air."""
        flying = position_enu_m[airborne]
        if len(flying) > 1:
            offsets = flying[:, None, :] - flying[None, :, :]
            squares = np.einsum("ijk,ijk->ij", offsets, offsets)
            np.fill_diagonal(squares, np.inf)
            self.min_separation_m = min(self.min_separation_m, math.sqrt(float(squares.min())))
        self._unchecked_s += dt_s
        if self._unchecked_s < FENCE_PERIOD_S - 1e-9:
            return
        if len(self._outside) != len(airborne):
            self._outside = np.zeros(len(airborne), dtype=np.bool_)
        outside = airborne & ~points_inside(position_enu_m[:, :2], self.fence_en_m)
        self.fence_breaches += int(np.count_nonzero(outside & ~self._outside))
        self.outside_s += self._unchecked_s * int(np.count_nonzero(outside))
        self._outside = outside
        self._unchecked_s = 0.0
