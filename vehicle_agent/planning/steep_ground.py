"""How steep ground is: over steep ground a vehicle that keeps low gets on slower and sees less far in the map."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray

LIKE_ITS_NEIGHBOURS = 1.0
"""Unknown ground is taken to be as steep as what is known within about so many sensing ranges of it."""
DOUBT = 0.05
"""Weight of the mean of all known ground beside that of neighbours: far from what is known, it is all there is."""


def ground_steepness(
    surface_m: FloatArray, columns: IndexArray, rows: IndexArray, block_m: FloatArray, range_m: float
) -> FloatArray:
    """Area of each block's surface by its area in the map, over the mean of the same in all blocks that are known.

    Parameters
    ----------
    surface_m : (C, R) float64, ENU z of the ground, NaN where unknown.
    columns, rows : (M,) and (N,) int64, of the cells in the middle of the blocks.
    block_m : (2,) float64, size of a block.
    range_m : sensing range.

    Returns
    -------
    (M, N) float64; ones where nothing is known.
    """
    heights = surface_m[np.ix_(columns, rows)]
    if min(heights.shape) < 2:
        return np.ones(heights.shape)
    east, north = np.gradient(heights, *block_m)
    steepness = np.sqrt(1.0 + east**2 + north**2)
    known = np.isfinite(steepness)
    if not known.any():
        return np.ones(heights.shape)
    mean = steepness[known].mean()
    widths = LIKE_ITS_NEIGHBOURS * range_m / block_m
    beside = gaussian_filter(known.astype(np.float64), widths, mode="constant")
    sums = gaussian_filter(np.where(known, steepness, 0.0), widths, mode="constant")
    guessed = (sums + DOUBT * mean) / (beside + DOUBT)
    relative: FloatArray = np.where(known, steepness, guessed) / mean
    return relative
