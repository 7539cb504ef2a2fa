"""How rough ground is from place to place, told at two scales.

What soundings add to those before them tells it at the distance between them. The map that they draw tells it at ten
metres, by how much it bends. Ground that is rough at one scale tends to be so at the other (the power law of sea
floors; Goff and Jordan 1988), and what either tells is uncertain in its own way, so their weighted geometric mean tells
more than each.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import gaussian_filter

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.relief import Relief
from vehicle_agent.domain.roughness_field import RoughnessField

BENDS_OVER_M = 10.0
"""The map's heights are compared over this distance to both sides."""
ALIKE_WITHIN_M = 9.0
"""Standard deviation of the Gaussian over which bends tell how rough a place is."""
WEAKEST_BEND = 0.02
"""Bend of a place over that on the whole, at least."""
BENDS_COUNT = 0.3
"""Share of the bends in the mean; a map drawn from few lines bends little where nobody looked."""


def roughness_at_nodes(
    relief: Relief, nodes_en_m: FloatArray, shape: tuple[int, int], edges_m: tuple[float, float]
) -> FloatArray:
    """How rough the ground is at nodes, up to a factor common to all: (M,) float64, positive, no unit.

    Parameters
    ----------
    nodes_en_m : (M, 2), a lattice of `shape`, the second index running fastest, its nodes `edges_m` apart.
    """
    bends = bends_of(relief.heights_at(nodes_en_m).reshape(shape), edges_m).ravel()
    field = RoughnessField(relief.places_en_m, relief.heights_m, relief.sds_m, relief.rough_m, nodes_en_m)
    bent = np.log(np.maximum(bends, WEAKEST_BEND))
    roughness: FloatArray = np.exp((1.0 - BENDS_COUNT) * field.logs_at(nodes_en_m) + BENDS_COUNT * bent)
    return roughness


def bends_of(heights_m: FloatArray, edges_m: tuple[float, float]) -> FloatArray:
    """How much a surface bends around each place, over how much it does on the whole: same shape, no unit."""
    squares = np.zeros_like(heights_m)
    for axis, edge_m in enumerate(edges_m):
        away = min(max(1, round(BENDS_OVER_M / edge_m)), heights_m.shape[axis] - 1)
        wide = [(away, away) if side == axis else (0, 0) for side in (0, 1)]
        wider = np.moveaxis(np.pad(heights_m, wide, "reflect", reflect_type="odd"), axis, 0)
        both_sides = np.moveaxis(wider[: -2 * away] + wider[2 * away :], 0, axis)
        squares += (both_sides - 2.0 * heights_m) ** 2
    near: FloatArray = gaussian_filter(squares, [ALIKE_WITHIN_M / edge_m for edge_m in edges_m], mode="nearest")
    whole = float(near.mean())
    return np.sqrt(near / whole) if whole > 0.0 and math.isfinite(whole) else np.ones_like(heights_m)
