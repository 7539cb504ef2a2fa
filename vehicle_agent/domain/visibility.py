"""How much of a surface many places see: the counts that coverage planning compares, as compiled kernels.

The sight is that of `vehicle_agent.domain.rays`, walked from the seen cell towards the eye: a ray that rises on that
way is decided as soon as it is above everything, one that is blocked is mostly blocked by ground nearby.
"""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.polygon import BoolArray


def eyes_in_cells(grid: Grid, positions_enu_m: FloatArray) -> FloatArray:
    """Positions as the kernels take them: (N, 3) ENU metres -> (N, 3) cells (centres at whole numbers) and metres."""
    eyes = np.array(positions_enu_m, dtype=np.float64).reshape(-1, 3)
    eyes[:, 0] = (eyes[:, 0] - grid.west_m) / grid.cell_m - 0.5
    eyes[:, 1] = (eyes[:, 1] - grid.south_m) / grid.cell_m - 0.5
    return eyes


def view(grid: Grid, elevation_m: FloatArray, position_enu_m: Point, range_m: float) -> BoolArray:
    """Cells that an omnidirectional sensor sees, (columns, rows) bool: O_t of Renzaglia 2020, section 3.

    The same cells as `vehicle_agent.domain.sensing.visible_surface`.
    """
    seen = np.zeros(grid.shape, dtype=np.bool_)
    if all(math.isfinite(coordinate) for coordinate in position_enu_m):
        eye = eyes_in_cells(grid, np.array(position_enu_m))[0]
        mark_view(np.ascontiguousarray(elevation_m), eye, grid.cell_m, range_m, highest(elevation_m), seen)
    return seen


def highest(elevation_m: FloatArray) -> float:
    """Highest known elevation, metres; minus infinity where nothing is known."""
    known = elevation_m[~np.isnan(elevation_m)]
    return float(known.max()) if len(known) else -math.inf


@compiled
def _is_seen(
    flat: FloatArray,
    line_stride: int,
    other_stride: int,
    lines: int,
    others: int,
    line: int,
    other: int,
    height: float,
    eye_line: float,
    eye_other: float,
    eye_z: float,
    top: float,
) -> bool:
    """Tell whether the eye sees a cell's surface point; `line` runs along the ray's longer axis.

    `flat` is the surface as a vector; a step along either axis is its stride. Nothing rises above `top`.
    """
    away = eye_line - line
    if away == 0.0:
        return True
    length = abs(away)
    steps = math.ceil(length - 1e-9) - 1
    room = lines - 1 - line if away > 0.0 else line
    steps = min(steps, room)
    rise = (eye_z - height) / length
    if rise > 0.0:
        steps = min(steps, int(max(top - height, 0.0) / rise) + 1)
    slope = (eye_other - other) / length
    stride = line_stride if away > 0.0 else -line_stride
    base = line * line_stride
    ray = height + 1e-9
    across = float(other)
    for _ in range(steps):
        base += stride
        ray += rise
        across += slope
        low = int(across)
        if low >= others - 1:
            ground = flat[base + (others - 1) * other_stride]
        else:
            part = across - low
            here, there = flat[base + low * other_stride], flat[base + (low + 1) * other_stride]
            if part < 1e-9:
                ground = here
            elif part > 1.0 - 1e-9:
                ground = there
            else:
                ground = here + part * (there - here)
        if ground > ray:
            return False
    return True


@compiled
def _sees(
    flat: FloatArray,
    columns: int,
    rows: int,
    u: float,
    v: float,
    z: float,
    column: int,
    row: int,
    height: float,
    top: float,
) -> bool:
    if abs(column - u) >= abs(row - v):
        return _is_seen(flat, rows, 1, columns, rows, column, row, height, u, v, z, top)
    return _is_seen(flat, 1, rows, rows, columns, row, column, height, v, u, z, top)


@compiled
def mark_view(
    elevation: FloatArray, eye: FloatArray, cell_m: float, range_m: float, top: float, seen: BoolArray
) -> int:
    """Set `seen` for every known cell in range and in sight of an eye; return how many there are.

    Parameters
    ----------
    elevation : (columns, rows) float64, ENU z in metres, NaN where unknown.
    eye : (3,) float64, horizontal coordinates in cells (centres at whole numbers), height in metres.
    top : highest elevation, metres.
    seen : (columns, rows) bool, written to.
    """
    columns, rows = elevation.shape
    flat = elevation.ravel()
    reach = range_m / cell_m
    u, v, z = eye[0], eye[1], eye[2]
    count = 0
    for column in range(max(0, math.ceil(u - reach)), min(columns - 1, math.floor(u + reach)) + 1):
        for row in range(max(0, math.ceil(v - reach)), min(rows - 1, math.floor(v + reach)) + 1):
            height = elevation[column, row]
            east, north, up = (column - u) * cell_m, (row - v) * cell_m, height - z
            in_range = east * east + north * north + up * up <= range_m * range_m  # never for an unknown cell
            if in_range and _sees(flat, columns, rows, u, v, z, column, row, height, top):
                seen[column, row] = True
                count += 1
    return count


@compiled
def weigh_views(
    elevation: FloatArray, eyes: FloatArray, cell_m: float, range_m: float, top: float, weights: FloatArray
) -> FloatArray:
    """Sum of `weights` over the cells that each eye sees: eyes (M, 3) -> (M,) float64.

    Parameters as for `mark_view`; `weights` is (columns, rows) float64, and cells of no weight cost no ray.
    """
    columns, rows = elevation.shape
    flat = elevation.ravel()
    reach = range_m / cell_m
    sums = np.zeros(len(eyes))
    for index in range(len(eyes)):
        u, v, z = eyes[index, 0], eyes[index, 1], eyes[index, 2]
        for column in range(max(0, math.ceil(u - reach)), min(columns - 1, math.floor(u + reach)) + 1):
            for row in range(max(0, math.ceil(v - reach)), min(rows - 1, math.floor(v + reach)) + 1):
                weight = weights[column, row]
                if weight == 0.0:
                    continue
                height = elevation[column, row]
                east, north, up = (column - u) * cell_m, (row - v) * cell_m, height - z
                in_range = east * east + north * north + up * up <= range_m * range_m
                if in_range and _sees(flat, columns, rows, u, v, z, column, row, height, top):
                    sums[index] += weight
    return sums
