"""Line of sight over a height field, as compiled kernels.

Heights live at cell centres and are joined linearly along the grid lines that a ray crosses on its longer axis. An
unknown height (NaN) hides nothing: what nobody knows may still be seen.
"""

from __future__ import annotations

import math

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray


@compiled
def _height_on_line(elevation: FloatArray, line: int, across: float, along_columns: bool) -> float:
    """Height where a ray crosses grid line `line` at fractional position `across` on the other axis."""
    size = elevation.shape[1] if along_columns else elevation.shape[0]
    low = min(max(math.floor(across), 0), size - 1)
    high = min(low + 1, size - 1)
    part = min(max(across - low, 0.0), 1.0)
    if part < 1e-9:  # on a cell's centre its neighbour does not matter, known or not
        high = low
    elif part > 1.0 - 1e-9:
        low = high
    if along_columns:
        return float((1.0 - part) * elevation[line, low] + part * elevation[line, high])
    return float((1.0 - part) * elevation[low, line] + part * elevation[high, line])


@compiled
def sight_is_clear(elevation: FloatArray, u0: float, v0: float, z0: float, u1: float, v1: float, z1: float) -> bool:
    """Tell whether the straight line between two points stays above the surface, end points left out.

    Horizontal coordinates are in cells with cell centres at whole numbers, heights in metres.
    """
    du, dv = u1 - u0, v1 - v0
    along_columns = abs(du) >= abs(dv)
    start, step = (u0, du) if along_columns else (v0, dv)
    end = start + step
    if step == 0.0:
        return True
    limit = (elevation.shape[0] if along_columns else elevation.shape[1]) - 1
    first = math.floor(start) + 1 if step > 0 else math.ceil(start) - 1
    direction = 1 if step > 0 else -1
    line = int(first)
    while (line - end) * direction < -1e-9:
        if 0 <= line <= limit:
            t = (line - start) / step
            across = v0 + t * dv if along_columns else u0 + t * du
            if _height_on_line(elevation, line, across, along_columns) > z0 + t * (z1 - z0) + 1e-9:
                return False
        line += direction
    return True


@compiled
def visible_cells(elevation: FloatArray, u0: float, v0: float, z0: float, cell_m: float, range_m: float) -> IndexArray:
    """Flat indices (increasing) of cells whose surface point at the centre is in range and in line of sight.

    `u0`, `v0` are the eye in cells (centres at whole numbers), `z0` its height in metres; unknown cells are not seen.
    """
    columns, rows = elevation.shape
    reach = range_m / cell_m
    low_column, high_column = max(0, math.ceil(u0 - reach)), min(columns - 1, math.floor(u0 + reach))
    low_row, high_row = max(0, math.ceil(v0 - reach)), min(rows - 1, math.floor(v0 + reach))
    room = max(0, high_column - low_column + 1) * max(0, high_row - low_row + 1)
    seen = np.empty(room, dtype=np.int64)
    count = 0
    for column in range(low_column, high_column + 1):
        for row in range(low_row, high_row + 1):
            height = elevation[column, row]
            if math.isnan(height):
                continue
            east, north, up = (column - u0) * cell_m, (row - v0) * cell_m, height - z0
            if east * east + north * north + up * up > range_m * range_m:
                continue
            if sight_is_clear(elevation, u0, v0, z0, float(column), float(row), height):
                seen[count] = column * rows + row
                count += 1
    return seen[:count].copy()
