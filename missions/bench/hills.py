"""Random hills: mixtures of Gaussians, the environments of Renzaglia 2020 sections 6.3 and 7."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid

FOOT = 9.0
"""Standard deviations beyond which a Gaussian is lost in rounding."""


@dataclass(frozen=True, slots=True)
class HillsParams:
    """What the hills of one bench are drawn from.

    Attributes
    ----------
    side_m
        Edge of the square area.
    cell_m
        Edge of a cell.
    peaks
        Number of Gaussians, centres uniform over the area.
    height_m
        Lowest and highest peak.
    sigma_m
        Standard deviation of each.
    """

    side_m: float = 100.0
    cell_m: float = 1.0
    peaks: int = 8
    height_m: tuple[float, float] = (10.0, 30.0)
    sigma_m: float = 10.0

    @property
    def grid(self) -> Grid:
        return Grid.over(0.0, 0.0, self.side_m, self.side_m, self.cell_m)


def draw_hills(params: HillsParams, rng: np.random.Generator) -> FloatArray:
    """One environment: (columns, rows) float64, ENU z of the surface in metres."""
    grid = params.grid
    east, north = np.meshgrid(grid.centres_east_m(), grid.centres_north_m(), indexing="ij")
    surface: FloatArray = np.zeros(grid.shape)
    for _ in range(params.peaks):
        centre = rng.uniform(0.0, params.side_m, 2)
        height = rng.uniform(*params.height_m)
        low = np.maximum(0, (centre - FOOT * params.sigma_m) // params.cell_m).astype(int)
        high = ((centre + FOOT * params.sigma_m) // params.cell_m).astype(int) + 1
        near = (slice(low[0], high[0]), slice(low[1], high[1]))
        away_squared = (east[near] - centre[0]) ** 2 + (north[near] - centre[1]) ** 2
        surface[near] += height * np.exp(-away_squared / (2.0 * params.sigma_m**2))
    return surface
