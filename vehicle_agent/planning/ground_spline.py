"""What unknown ground is expected to look like from the known ground beside it: slopes and curvature go on, and fade.

A spline with tension, as Mitasova and Mitas 1993 draw terrain with: heights are known where they were measured, and
elsewhere such that the sum of squared third differences is least, together with squared second and first differences
weighed so that what goes on beyond known ground fades within about one sensing range.
"""

from __future__ import annotations

import math

import numpy as np
from scipy import sparse
from scipy.ndimage import distance_transform_edt
from scipy.sparse.linalg import splu

from vehicle_agent.domain.expected_ground import ExpectedGround, level_ground
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.polygon import BoolArray

ORDER = 3
"""Of the differences that are kept small."""
DOUBT_WITHIN = 1.8
"""So many sensing ranges from known ground, most of a slope is unknown.

Of the Jacksboro ridge's slopes the spline leaves 3, 7, 14, 22 and 41 per cent of their mean square unknown at 0.25,
0.5, 0.75, 1 and 1.6 ranges of 160 m, of the exploration bench's hills half of that.
"""
FAR = 5.0
"""Farther than so many sensing ranges from known ground, heights are taken to be the mean of what is known."""
LEAST_KNOWN = 9
"""With fewer blocks known, nothing is expected."""


class GroundSpline:
    """Expects heights of blocks, each time for as many columns and rows as are given.

    Parameters
    ----------
    range_blocks
        The sensing range, in blocks.
    """

    def __init__(self, range_blocks: float) -> None:
        self._range_blocks = range_blocks
        self._stiffness = sparse.csr_matrix((0, 0))
        self._shape = (0, 0)

    def expect(self, heights: FloatArray) -> ExpectedGround:
        """Ground by what is known of it.

        Parameters
        ----------
        heights : (C, R) float64, in widths of a block, NaN where unknown.
        """
        known = np.isfinite(heights)
        if np.count_nonzero(known) < LEAST_KNOWN:
            return level_ground(heights.shape)
        away = distance_transform_edt(~known) / self._range_blocks
        doubt = 1.0 - np.exp(-((away / DOUBT_WITHIN) ** 2))
        slope_squared = _mean_square_of_slopes(heights) / 2.0
        expected = self._smoothest(heights, known, (away < FAR) & ~known)
        squares = _squared_slopes(expected) + 2.0 * slope_squared * doubt
        return ExpectedGround(expected, doubt, slope_squared, float(np.sqrt(1.0 + squares).mean()))

    def _smoothest(self, heights: FloatArray, known: BoolArray, near: BoolArray) -> FloatArray:
        """Heights of all blocks: what is near known ground as the spline has it."""
        level = heights[known].mean()
        offsets = np.where(known, heights - level, 0.0).ravel()
        if near.any():
            stiffness, sought = self._stiffness_of(heights.shape), np.flatnonzero(near)
            rows = stiffness[sought]
            solver = splu(
                rows[:, sought].tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}
            )  # no pivoting: it is positive definite
            offsets[sought] = solver.solve(-(rows @ offsets))
        smoothest: FloatArray = offsets.reshape(heights.shape) + level
        return smoothest

    def _stiffness_of(self, shape: tuple[int, int]) -> sparse.csr_matrix:
        """The matrix of the weighed sum of squared differences of all orders, kept until the shape changes."""
        if shape != self._shape:
            squares = [[_squared_differences(size, order) for order in range(ORDER + 1)] for size in shape]
            self._shape, self._stiffness = (
                shape,
                sparse.csr_matrix(
                    sum(
                        math.comb(order, across)
                        * self._range_blocks ** (-2.0 * (ORDER - order))
                        * sparse.kron(squares[0][across], squares[1][order - across])
                        for order in range(1, ORDER + 1)
                        for across in range(order + 1)
                    )
                ),
            )
        return self._stiffness


def _squared_differences(size: int, order: int) -> sparse.csr_matrix:
    """The matrix of the sum of squared differences of one order along so many blocks: (size, size)."""
    if order >= size:
        return sparse.csr_matrix((size, size))
    binomials = [(-1.0) ** place * math.comb(order, place) for place in range(order + 1)]
    differences = sparse.diags(binomials, list(range(order + 1)), shape=(size - order, size))
    return sparse.csr_matrix(differences.T @ differences)


def _squared_slopes(heights: FloatArray) -> FloatArray:
    """(C, R) float64, NaN where a neighbour is unknown."""
    squares = np.zeros(heights.shape)
    for axis in range(2):
        if heights.shape[axis] > 1:
            squares += np.gradient(heights, axis=axis) ** 2
    return squares


def _mean_square_of_slopes(heights: FloatArray) -> float:
    squares = _squared_slopes(heights)
    known = np.isfinite(squares)
    return float(squares[known].mean()) if known.any() else 0.0
