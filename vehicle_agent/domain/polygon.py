"""Polygons in the plane: which points and which cells lie inside."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid

BoolArray = npt.NDArray[np.bool_]


def points_inside(points_en_m: FloatArray, polygon_en_m: FloatArray) -> BoolArray:
    """Tell which points lie inside a simple polygon (crossing number, even-odd rule).

    Parameters
    ----------
    points_en_m : (N, 2) float64, east and north in ENU metres.
    polygon_en_m : (V, 2) float64, corners in order, not closed.

    Returns
    -------
    (N,) bool.
    """
    east, north = points_en_m[:, 0], points_en_m[:, 1]
    inside = np.zeros(len(points_en_m), dtype=np.bool_)
    following = np.roll(polygon_en_m, -1, axis=0)
    for (x0, y0), (x1, y1) in zip(polygon_en_m, following, strict=True):
        if y0 == y1:
            continue
        crosses = (y0 > north) != (y1 > north)
        inside ^= crosses & (east < x0 + (north - y0) * (x1 - x0) / (y1 - y0))
    return inside


def distance_to_border_m(points_en_m: FloatArray, polygon_en_m: FloatArray) -> FloatArray:
    """Distance of each point to the polygon's border, metres: (N, 2), (V, 2) -> (N,) float64."""
    starts = polygon_en_m
    edges = np.roll(polygon_en_m, -1, axis=0) - starts
    lengths_squared = np.maximum(np.einsum("vi,vi->v", edges, edges), 1e-12)
    offsets = points_en_m[:, None, :] - starts[None, :, :]
    along = np.clip(np.einsum("nvi,vi->nv", offsets, edges) / lengths_squared, 0.0, 1.0)
    nearest = offsets - along[:, :, None] * edges[None, :, :]
    distances: FloatArray = np.sqrt(np.einsum("nvi,nvi->nv", nearest, nearest)).min(axis=1)
    return distances


def cells_inside(grid: Grid, polygon_en_m: FloatArray) -> BoolArray:
    """Tell which cells have their centre inside the polygon: (columns, rows) bool."""
    east, north = np.meshgrid(grid.centres_east_m(), grid.centres_north_m(), indexing="ij")
    return points_inside(np.column_stack((east.ravel(), north.ravel())), polygon_en_m).reshape(grid.shape)
