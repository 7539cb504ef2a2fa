"""How high ground may be that a sensor did not see: the free space of its clear rays tells what they hide."""

from __future__ import annotations

import math

from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray

MARGIN_M = 0.3
"""Between cells the ground may rise over the straight line by so much."""


@compiled
def guess_hidden_ground(
    elevation: FloatArray,
    u: float,
    v: float,
    z: float,
    cell_m: float,
    range_m: float,
    guess_m: FloatArray,
) -> None:
    """Lower the guesses of how high cells are that an omnidirectional sensor had near it and did not see.

    Ground that reached above the shadow of the known ground before it, and into the sensor's range, would have been
    seen. Ground above its range would not: a guess is good for planning ahead, while what is flown next must be checked
    against the newest map.

    Parameters
    ----------
    elevation : (columns, rows) float64, ENU z in metres, NaN where unknown, what the sensor sees now included.
    u, v, z : the sensor in cells (centres at whole numbers) and metres.
    cell_m, range_m : metres.
    guess_m : (columns, rows) float64, ENU z that unknown cells hardly exceed, infinite where nothing tells; written to.
    """
    columns, rows = elevation.shape
    reach = range_m / cell_m
    for column in range(max(0, math.ceil(u - reach)), min(columns - 1, math.floor(u + reach)) + 1):
        for row in range(max(0, math.ceil(v - reach)), min(rows - 1, math.floor(v + reach)) + 1):
            away = math.hypot(column - u, row - v)
            if not math.isnan(elevation[column, row]) or away >= reach:
                continue
            rise = -math.inf
            for half in range(1, int(2.0 * away)):
                part = 0.5 * half / away
                c, r = round(u + part * (column - u)), round(v + part * (row - v))
                if 0 <= c < columns and 0 <= r < rows and not math.isnan(elevation[c, r]):
                    rise = max(rise, 2.0 * (elevation[c, r] - z) / half)
            lowest_in_range = z - math.sqrt(range_m * range_m - (away * cell_m) ** 2)
            free_from = max(z + rise * away, lowest_in_range) + MARGIN_M
            guess_m[column, row] = min(guess_m[column, row], free_from)
