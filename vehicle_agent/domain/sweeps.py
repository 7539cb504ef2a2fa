"""How much unseen ground lies beside straight ways, as a compiled kernel."""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.elevation import UNOBSERVED_STAMP_MS, StampArray
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.polygon import BoolArray


@compiled
def unseen_beside(
    first_stamp_ms: StampArray, area_cells: BoolArray, start: FloatArray, ends: FloatArray, radius: float
) -> FloatArray:
    """Unobserved cells of the area within a radius of each straight way.

    Parameters
    ----------
    first_stamp_ms : (columns, rows) int64, as in an `ElevationMap`.
    area_cells : (columns, rows) bool.
    start : (2,) float64; ends : (N, 2) float64, in cells, cell centres at whole numbers.
    radius : in cells.

    Returns
    -------
    (N,) float64, numbers of cells.
    """
    counts = np.zeros(len(ends))
    columns, rows = first_stamp_ms.shape
    for index in range(len(ends)):
        du, dv = ends[index, 0] - start[0], ends[index, 1] - start[1]
        length_squared = du * du + dv * dv + 1e-12
        left = max(0, int(min(start[0], ends[index, 0]) - radius))
        right = min(columns - 1, int(max(start[0], ends[index, 0]) + radius) + 1)
        low = max(0, int(min(start[1], ends[index, 1]) - radius))
        high = min(rows - 1, int(max(start[1], ends[index, 1]) + radius) + 1)
        for column in range(left, right + 1):
            for row in range(low, high + 1):
                if first_stamp_ms[column, row] != UNOBSERVED_STAMP_MS or not area_cells[column, row]:
                    continue
                u, v = column - start[0], row - start[1]
                part = min(max((u * du + v * dv) / length_squared, 0.0), 1.0)
                if (u - part * du) ** 2 + (v - part * dv) ** 2 <= radius * radius:
                    counts[index] += 1.0
    return counts
