"""Sensor models: what a sensor at a place sees of a surface."""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.grid import Grid, IndexArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.visibility import eye_in_cells, seen_cells


def visible_surface(grid: Grid, elevation_m: FloatArray, position_enu_m: Point, range_m: float) -> IndexArray:
    """Cells observed by an omnidirectional sensor: in line of sight and within range (Renzaglia 2020, section 3).

    Parameters
    ----------
    grid
        The cells.
    elevation_m : (columns, rows) float64, ENU z of the surface at cell centres; NaN cells are not seen.
    position_enu_m
        The sensor, ENU metres.
    range_m
        Sensing distance d_max, metres, measured in three dimensions.

    Returns
    -------
    (N,) int64 flat cell indices, increasing; none from a position that is not finite.
    """
    if not all(math.isfinite(coordinate) for coordinate in position_enu_m):
        return np.empty(0, dtype=np.int64)
    return seen_cells(np.ascontiguousarray(elevation_m), eye_in_cells(grid, position_enu_m), grid.cell_m, range_m)


def view(grid: Grid, elevation_m: FloatArray, position_enu_m: Point, range_m: float) -> BoolArray:
    """The same cells as a mask, (columns, rows) bool: O_t of Renzaglia 2020, section 3."""
    seen = np.zeros(grid.shape, dtype=np.bool_)
    seen.ravel()[visible_surface(grid, elevation_m, position_enu_m, range_m)] = True
    return seen
