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
    corners = polygon_en_m.tolist()
    for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True):
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


def first_crossing(polygon_en_m: FloatArray) -> tuple[int, int] | None:
    """Indices of the first two edges that meet elsewhere than in their common corner; None for a simple polygon.

    Edge i runs from corner i to the next. Touching counts as meeting, and so does an edge that runs back along its
    predecessor.
    """
    starts, ends = polygon_en_m, np.roll(polygon_en_m, -1, axis=0)
    corners = len(starts)
    for i in range(corners):
        following = (i + 1) % corners
        back, forth = starts[i] - ends[i], ends[following] - ends[i]
        if back[0] * forth[1] == back[1] * forth[0] and np.dot(back, forth) > 0:
            return (i, following)
        others = np.arange(i + 2, corners - (i == 0))
        meeting = _segments_meet(starts[i], ends[i], starts[others], ends[others])
        if meeting.any():
            return (i, int(others[np.argmax(meeting)]))
    return None


def _segments_meet(start: FloatArray, end: FloatArray, starts: FloatArray, ends: FloatArray) -> BoolArray:
    """Tell which of N segments share a point with one segment: (2,), (2,), (N, 2), (N, 2) -> (N,) bool."""

    def side(a: FloatArray, b: FloatArray, point: FloatArray) -> FloatArray:
        cross: FloatArray = (b[..., 0] - a[..., 0]) * (point[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (
            point[..., 0] - a[..., 0]
        )
        return np.sign(cross)

    straddles = (side(start, end, starts) * side(start, end, ends) <= 0) & (
        side(starts, ends, start) * side(starts, ends, end) <= 0
    )
    # Segments on one line straddle each other always, so their bounding boxes decide.
    boxes_touch = np.all(
        (np.minimum(starts, ends) <= np.maximum(start, end)) & (np.maximum(starts, ends) >= np.minimum(start, end)),
        axis=1,
    )
    meet: BoolArray = straddles & boxes_touch
    return meet


def cells_inside(grid: Grid, polygon_en_m: FloatArray) -> BoolArray:
    """Tell which cells have their centre inside the polygon: (columns, rows) bool."""
    east, north = np.meshgrid(grid.centres_east_m(), grid.centres_north_m(), indexing="ij")
    return points_inside(np.column_stack((east.ravel(), north.ravel())), polygon_en_m).reshape(grid.shape)
