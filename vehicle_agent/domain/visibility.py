"""What places see of a surface, as compiled kernels: the cells themselves, or the place whose view weighs most.

Heights live at cell centres and are joined linearly along the grid lines that a ray crosses on its longer axis. An
unknown height (NaN) hides nothing: what nobody knows may still be seen. A ray is walked from the seen cell towards the
eye: where it is blocked, it is mostly blocked by ground nearby, and where it has come above all ground that is nearer
to the eye, it is decided.
"""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.grid import Grid, IndexArray
from vehicle_agent.domain.polygon import BoolArray

MOST_RINGS = 512
"""Ground farther from the eye, in cells, is not looked through for its highest point."""


def eyes_in_cells(grid: Grid, positions_enu_m: FloatArray) -> FloatArray:
    """Positions as the kernels take them: (N, 3) ENU metres -> (N, 3) cells (centres at whole numbers) and metres."""
    eyes = np.array(positions_enu_m, dtype=np.float64).reshape(-1, 3)
    eyes[:, 0] = (eyes[:, 0] - grid.west_m) / grid.cell_m - 0.5
    eyes[:, 1] = (eyes[:, 1] - grid.south_m) / grid.cell_m - 0.5
    return eyes


def eye_in_cells(grid: Grid, position_enu_m: Point) -> FloatArray:
    """One position as the kernels take it, quicker than as one of several: (3,) float64."""
    east_m, north_m, up_m = position_enu_m
    return np.array(((east_m - grid.west_m) / grid.cell_m - 0.5, (north_m - grid.south_m) / grid.cell_m - 0.5, up_m))


@compiled
def _raise_tops(elevation: FloatArray, u: float, v: float, tops: FloatArray) -> None:
    """Set `tops[d]` to the highest ground within d cells of an eye along either axis; the last one stands for more."""
    columns, rows = elevation.shape
    middle_column, middle_row, rings = math.floor(u + 0.5), math.floor(v + 0.5), len(tops) - 1
    tops[:] = -math.inf
    tops[rings] = math.inf
    for column in range(max(0, middle_column - rings + 1), min(columns, middle_column + rings)):
        for row in range(max(0, middle_row - rings + 1), min(rows, middle_row + rings)):
            ring = max(abs(column - middle_column), abs(row - middle_row))
            height = elevation[column, row]
            if height > tops[ring]:
                tops[ring] = height
    for ring in range(1, rings):
        tops[ring] = max(tops[ring], tops[ring - 1])


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
    tops: FloatArray,
) -> bool:
    """Tell whether the eye sees a cell's surface point; `line` runs along the ray's longer axis.

    `flat` is the surface as a vector; a step along either axis is its stride.
    """
    away = eye_line - line
    if away == 0.0:
        return True
    length = abs(away)
    steps = math.ceil(length - 1e-9) - 1
    room = lines - 1 - line if away > 0.0 else line
    steps = min(steps, room)
    inverse = 1.0 / length
    rise, slope = (eye_z - height) * inverse, (eye_other - other) * inverse
    stride = line_stride if away > 0.0 else -line_stride
    base = line * line_stride
    ray = height + 1e-9
    across = float(other)
    ring, last = int(length) + 1, len(tops) - 1
    for _ in range(steps):
        if min(ray, eye_z) > tops[min(ring, last)]:
            return True
        ring -= 1
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
    tops: FloatArray,
) -> bool:
    if abs(column - u) >= abs(row - v):
        return _is_seen(flat, rows, 1, columns, rows, column, row, height, u, v, z, tops)
    return _is_seen(flat, 1, rows, rows, columns, row, column, height, v, u, z, tops)


@compiled
def seen_cells(elevation: FloatArray, eye: FloatArray, cell_m: float, range_m: float) -> IndexArray:
    """Flat indices (increasing) of the known cells in range and in sight of an eye.

    Parameters
    ----------
    elevation : (columns, rows) float64, ENU z in metres, NaN where unknown.
    eye : (3,) float64, horizontal coordinates in cells (centres at whole numbers), height in metres.
    """
    columns, rows = elevation.shape
    flat = elevation.ravel()
    reach = range_m / cell_m
    u, v, z = eye[0], eye[1], eye[2]
    first_column, last_column = max(0, math.ceil(u - reach)), min(columns - 1, math.floor(u + reach))
    first_row, last_row = max(0, math.ceil(v - reach)), min(rows - 1, math.floor(v + reach))
    seen = np.empty(max(0, last_column - first_column + 1) * max(0, last_row - first_row + 1), dtype=np.int64)
    count = 0
    if len(seen) == 0:
        return seen
    tops = np.empty(int(min(reach, MOST_RINGS)) + 4)
    _raise_tops(elevation, u, v, tops)
    for column in range(first_column, last_column + 1):
        for row in range(first_row, last_row + 1):
            height = elevation[column, row]
            east, north, up = (column - u) * cell_m, (row - v) * cell_m, height - z
            in_range = east * east + north * north + up * up <= range_m * range_m  # never for an unknown cell
            if in_range and _sees(flat, columns, rows, u, v, z, column, row, height, tops):
                seen[count] = column * rows + row
                count += 1
    return seen[:count].copy()


@compiled
def mark_seen(elevation: FloatArray, eyes: FloatArray, cell_m: float, range_m: float) -> BoolArray:
    """Cells that at least one of the eyes sees: eyes (M, 3) -> (columns, rows) bool; what one sees costs others no ray.

    Parameters as for `seen_cells`.
    """
    columns, rows = elevation.shape
    flat = elevation.ravel()
    reach = range_m / cell_m
    seen = np.zeros((columns, rows), dtype=np.bool_)
    tops = np.empty(int(min(reach, MOST_RINGS)) + 4)
    for index in range(len(eyes)):
        u, v, z = eyes[index, 0], eyes[index, 1], eyes[index, 2]
        _raise_tops(elevation, u, v, tops)
        for column in range(max(0, math.ceil(u - reach)), min(columns - 1, math.floor(u + reach)) + 1):
            for row in range(max(0, math.ceil(v - reach)), min(rows - 1, math.floor(v + reach)) + 1):
                if seen[column, row]:
                    continue
                height = elevation[column, row]
                east, north, up = (column - u) * cell_m, (row - v) * cell_m, height - z
                in_range = east * east + north * north + up * up <= range_m * range_m
                if in_range and _sees(flat, columns, rows, u, v, z, column, row, height, tops):
                    seen[column, row] = True
    return seen


@compiled
def _in_range(
    elevation: FloatArray, eye: FloatArray, cell_m: float, range_m: float, weights: FloatArray, cells: IndexArray
) -> tuple[int, float]:
    """Write the flat indices of the cells of some weight in an eye's range to `cells`: how many, and their weight."""
    columns, rows = elevation.shape
    reach = range_m / cell_m
    u, v, z = eye[0], eye[1], eye[2]
    count, weight = 0, 0.0
    for column in range(max(0, math.ceil(u - reach)), min(columns - 1, math.floor(u + reach)) + 1):
        for row in range(max(0, math.ceil(v - reach)), min(rows - 1, math.floor(v + reach)) + 1):
            if weights[column, row] == 0.0:
                continue
            east, north, up = (column - u) * cell_m, (row - v) * cell_m, elevation[column, row] - z
            if east * east + north * north + up * up <= range_m * range_m:
                cells[count] = column * rows + row
                count += 1
                weight += weights[column, row]
    return count, weight


@compiled
def best_view(
    elevation: FloatArray,
    eyes: FloatArray,
    cell_m: float,
    range_m: float,
    weights: FloatArray,
    bonuses: FloatArray,
) -> tuple[int, float, float]:
    """Choose the eye whose view weighs most, its bonus added: the first of equals.

    No ray is cast for an eye that could not be chosen if it saw all that is left in its range.

    Parameters
    ----------
    eyes : (M, 3) float64, at least one; the other parameters as for `seen_cells`.
    weights : (columns, rows) float64, not negative; cells of no weight cost no ray.
    bonuses : (M,) float64.

    Returns
    -------
    the chosen eye's index, the weight of what it sees, and the weight of what the first eye sees.
    """
    columns, rows = elevation.shape
    flat, flat_weights = elevation.ravel(), weights.ravel()
    cells = np.empty(elevation.size, dtype=np.int64)
    tops = np.empty(int(min(range_m / cell_m, MOST_RINGS)) + 4)
    best, best_weight, first_weight, best_value = 0, 0.0, 0.0, -math.inf
    for index in range(len(eyes)):
        count, weight = _in_range(elevation, eyes[index], cell_m, range_m, weights, cells)
        if weight + bonuses[index] <= best_value:
            continue
        u, v, z = eyes[index, 0], eyes[index, 1], eyes[index, 2]
        _raise_tops(elevation, u, v, tops)
        for k in range(count):
            column, row = cells[k] // rows, cells[k] % rows
            if not _sees(flat, columns, rows, u, v, z, column, row, flat[cells[k]], tops):
                weight -= flat_weights[cells[k]]
                if weight + bonuses[index] <= best_value:
                    break
        if index == 0:
            first_weight = weight
        if weight + bonuses[index] > best_value:
            best, best_weight, best_value = index, weight, weight + bonuses[index]
    return best, best_weight, first_weight
