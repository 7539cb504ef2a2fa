"""Monomials for local fits of objectives, as compiled kernels."""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray

CUBIC_MONOMIALS = 20
"""x^u y^v z^w with u + v + w <= 3."""


@compiled
def cubic_monomials(points: FloatArray) -> FloatArray:
    """All monomials up to the third degree of each point: (N, 3) -> (N, 20)."""
    monomials = np.empty((len(points), CUBIC_MONOMIALS))
    for index in range(len(points)):
        x, y, z = points[index, 0], points[index, 1], points[index, 2]
        column = 0
        power_x = 1.0
        for u in range(4):
            power_y = power_x
            for v in range(4 - u):
                power_z = power_y
                for _ in range(4 - u - v):
                    monomials[index, column] = power_z
                    column += 1
                    power_z *= z
                power_y *= y
            power_x *= x
    return monomials
