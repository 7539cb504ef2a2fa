"""Where a coverage team starts: spread by a Voronoi tessellation, at random, or all in a corner."""

from __future__ import annotations

from typing import Literal

import numpy as np

from missions.bench.coverage_run import MARGIN_M, CoverageTeam
from vehicle_agent.domain.clearance import ground_heights
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid
from vehicle_agent.planning.cvt import ApproximateSurface, TessellationParams, tessellate

Start = Literal["cvt", "random", "corner"]
STARTS: tuple[Start, ...] = ("cvt", "random", "corner")
LATTICE_M = 4.0
KNOWN_POINTS = 30
ATTEMPTS = 1_000


def draw_start(
    kind: Start, grid: Grid, elevation_m: FloatArray, team: CoverageTeam, vehicles: int, rng: np.random.Generator
) -> FloatArray:
    """Admissible places over the true surface for a whole team: (vehicles, 3) float64, ENU metres.

    Raises
    ------
    ValueError
        When so many vehicles find no room at the team's separation.
    """
    match kind:
        case "cvt":
            wanted = _tessellated(grid, elevation_m, team, vehicles, rng)
        case "random":
            margin_m = 0.5 * grid.cell_m
            lows = (grid.west_m + margin_m, grid.south_m + margin_m)
            wanted = np.full((vehicles, 3), -np.inf)
            wanted[:, :2] = rng.uniform(lows, (grid.east_m - margin_m, grid.north_m - margin_m), (vehicles, 2))
        case "corner":
            wanted = _lattice(grid, vehicles)
    return _admitted(wanted, grid, elevation_m, team, rng)


def known_points(grid: Grid, elevation_m: FloatArray, rng: np.random.Generator) -> FloatArray:
    """The few points of the surface that are known beforehand: (30, 3) float64, ENU metres."""
    cells = rng.choice(grid.cells, KNOWN_POINTS, replace=False)
    return np.column_stack((grid.centres_of(cells), elevation_m.ravel()[cells]))


def _tessellated(
    grid: Grid, elevation_m: FloatArray, team: CoverageTeam, vehicles: int, rng: np.random.Generator
) -> FloatArray:
    """Generators of the constrained CVT, lifted to the lowest height that the approximate surface allows."""
    area = (grid.west_m, grid.south_m, grid.east_m, grid.north_m)
    surface = ApproximateSurface(known_points(grid, elevation_m, rng), area)
    lift = np.array((0.0, 0.0, team.min_above_m))
    lifted: FloatArray = tessellate(surface, vehicles, TessellationParams(), rng) + lift
    return lifted


def _lattice(grid: Grid, vehicles: int) -> FloatArray:
    """The south-western corner's points of a lattice, nearest first, at the lowest height."""
    steps = range(int(min(grid.columns, grid.rows) * grid.cell_m / LATTICE_M))
    spots = sorted(((i, j) for i in steps for j in steps), key=lambda spot: (max(spot), spot))[:vehicles]
    if len(spots) < vehicles:
        raise ValueError(f"{vehicles} vehicles do not fit on the start's lattice of {LATTICE_M:g} m; take fewer")
    places = np.full((vehicles, 3), -np.inf)
    places[:, :2] = np.array((grid.west_m, grid.south_m)) + LATTICE_M * (np.array(spots) + 0.5)
    return places


def _admitted(
    wanted: FloatArray, grid: Grid, elevation_m: FloatArray, team: CoverageTeam, rng: np.random.Generator
) -> FloatArray:
    """Each place moved to the nearest admissible one: raised where it is too low, aside where it would be too high."""
    middles = np.column_stack(
        (grid.centres_of(np.arange(grid.cells)), elevation_m.ravel() + team.min_above_m + MARGIN_M)
    )
    middles = middles[middles[:, 2] <= team.ceiling_m - MARGIN_M]
    places: list[FloatArray] = []
    for place in wanted:
        here = place.copy()
        for _ in range(ATTEMPTS):
            here = _raised(here, grid, elevation_m, team.min_above_m + MARGIN_M)
            if not here[2] <= team.ceiling_m - MARGIN_M:  # also where there is no ground
                here = middles[int(np.argmin(np.linalg.norm(middles[:, :2] - here[:2], axis=1)))].copy()
            if all(np.linalg.norm(here - other) >= team.separation_m for other in places):
                break
            here[:2] = place[:2] + rng.normal(0.0, 2.0 * team.separation_m, 2)
            here[2] = place[2]
        else:
            raise ValueError(f"{len(wanted)} vehicles find no room {team.separation_m:g} m apart; take fewer")
        places.append(here)
    return np.array(places)


def _raised(place: FloatArray, grid: Grid, elevation_m: FloatArray, min_above_m: float) -> FloatArray:
    """The place, not below its least height above the true ground; its height is NaN outside the area."""
    ground_m = float(ground_heights(elevation_m, grid.west_m, grid.south_m, grid.cell_m, place[None, :])[0])
    lowest_m = ground_m + min_above_m
    return np.array((place[0], place[1], lowest_m if not place[2] >= lowest_m else place[2]))
