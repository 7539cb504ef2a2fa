"""Ground as far as it is known or expected, in blocks: how high it is, and how long a way low above it is."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray


class ExpectedGround(NamedTuple):
    """Heights of blocks, and how much of their slopes they do not show.

    Attributes
    ----------
    heights : (columns, rows) float64, in widths of a block.
    doubt : (columns, rows) float64 in [0, 1], share of the mean square of slopes that heights do not show.
    slope_squared : mean square of the slope of known ground along any one direction.
    stretch : how much longer a way is on average than it is in the map.
    """

    heights: FloatArray
    doubt: FloatArray
    slope_squared: float
    stretch: float


def level_ground(shape: tuple[int, int]) -> ExpectedGround:
    """Ground of which nothing is known."""
    return ExpectedGround(np.zeros(shape), np.ones(shape), 0.0, 1.0)


@compiled
def height_at(heights: FloatArray, u: float, v: float) -> float:
    """Height between block centres, linear in both directions; beside the ground as at its edge."""
    columns, rows = heights.shape
    u, v = min(max(u, 0.0), columns - 1.0), min(max(v, 0.0), rows - 1.0)
    column, row = min(int(u), max(columns - 2, 0)), min(int(v), max(rows - 2, 0))
    east, north = min(column + 1, columns - 1), min(row + 1, rows - 1)
    part_u, part_v = u - column, v - row
    southern = heights[column, row] + part_u * (heights[east, row] - heights[column, row])
    northern = heights[column, north] + part_u * (heights[east, north] - heights[column, north])
    between: float = southern + part_v * (northern - southern)
    return between


@compiled
def flown_length(ground: ExpectedGround, one: FloatArray, other: FloatArray) -> float:
    """How long the straight way between two places is along the ground, by what a way in the map takes on average.

    Parameters
    ----------
    one, other : (2,) float64, in blocks, block centres at whole numbers.
    """
    du, dv = other[0] - one[0], other[1] - one[1]
    flat = math.sqrt(du * du + dv * dv)
    columns, rows = ground.doubt.shape
    pieces = max(1, int(flat + 0.5))
    length, before = 0.0, height_at(ground.heights, one[0], one[1])
    for piece in range(1, pieces + 1):
        u, v = one[0] + piece / pieces * du, one[1] + piece / pieces * dv
        up = height_at(ground.heights, u, v)
        column, row = min(max(int(u + 0.5), 0), columns - 1), min(max(int(v + 0.5), 0), rows - 1)
        unknown = ground.doubt[column, row] * ground.slope_squared
        length += math.sqrt((flat / pieces) ** 2 * (1.0 + unknown) + (up - before) ** 2)
        before = up
    return length / ground.stretch
