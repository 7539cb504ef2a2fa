"""The informed optimum of static coverage: what somebody gets who knows the terrain and places the whole team.

Centralised coordinate ascent from many starts: vehicle after vehicle is moved to the best of many places while the
others stay, until none gains; on a coarse map first, and the best few ends on the true map.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from missions.bench.coverage_run import CoverageTeam
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.visibility import best_view, eyes_in_cells, seen_cells


@dataclass(frozen=True, slots=True)
class AscentParams:
    """How hard the optimum is looked for.

    Attributes
    ----------
    starts
        Teams drawn at random, spread by a few Lloyd iterations.
    kept
        How many of their ends are refined on the true map.
    scales_m
        Standard deviations of tried places around the present one.
    per_scale
        Places tried of each.
    anywhere
        Places tried anywhere over the area.
    stale_rounds
        Rounds without gain after which a team stands.
    most_rounds
        Rounds at most.
    """

    starts: int = 12
    kept: int = 3
    scales_m: tuple[float, ...] = (0.5, 1.5, 4.0, 8.0)
    per_scale: int = 8
    anywhere: int = 16
    stale_rounds: int = 4
    most_rounds: int = 60


class _Surface:
    """A true surface at one resolution."""

    def __init__(self, grid: Grid, elevation_m: FloatArray, team: CoverageTeam, block: int) -> None:
        columns, rows = grid.columns // block, grid.rows // block
        trimmed = elevation_m[: columns * block, : rows * block]
        self.full_grid, self.full_m, self.team = grid, elevation_m, team
        self.grid = Grid(grid.west_m, grid.south_m, grid.cell_m * block, columns, rows)
        self.elevation_m = np.ascontiguousarray(trimmed.reshape(columns, block, rows, block).mean(axis=(1, 3)))

    def view(self, place: FloatArray) -> BoolArray:
        seen = np.zeros(self.grid.shape, dtype=np.bool_)
        eye = eyes_in_cells(self.grid, place)[0]
        seen.ravel()[seen_cells(self.elevation_m, eye, self.grid.cell_m, self.team.range_m)] = True
        return seen

    def best(self, places: FloatArray, unseen: BoolArray) -> int:
        """Which of the places sees most of what is unseen: the first of equals."""
        eyes = eyes_in_cells(self.grid, places)
        weights = unseen.astype(np.float64)
        best, _, _ = best_view(
            self.elevation_m, eyes, self.grid.cell_m, self.team.range_m, weights, np.zeros(len(places))
        )
        return best

    def admissible(self, places: FloatArray) -> FloatArray:
        """Places moved into the area and their height band; those where there is none left out."""
        grid, team = self.full_grid, self.team
        places[:, 0] = places[:, 0].clip(grid.west_m + 0.5 * grid.cell_m, grid.east_m - 0.5 * grid.cell_m)
        places[:, 1] = places[:, 1].clip(grid.south_m + 0.5 * grid.cell_m, grid.north_m - 0.5 * grid.cell_m)
        columns = ((places[:, 0] - grid.west_m) / grid.cell_m).astype(np.int64).clip(0, grid.columns - 1)
        rows = ((places[:, 1] - grid.south_m) / grid.cell_m).astype(np.int64).clip(0, grid.rows - 1)
        lowest_m = self.full_m[columns, rows] + team.min_above_m
        places[:, 2] = places[:, 2].clip(lowest_m, np.maximum(lowest_m, team.ceiling_m))
        kept: FloatArray = places[lowest_m <= team.ceiling_m]
        return kept


def informed_optimum(
    grid: Grid,
    elevation_m: FloatArray,
    team: CoverageTeam,
    vehicles: int,
    rng: np.random.Generator,
    params: AscentParams | None = None,
    more_starts: tuple[FloatArray, ...] = (),
) -> tuple[float, FloatArray]:
    """Best coverage found by an optimiser that knows the terrain.

    Parameters
    ----------
    elevation_m : (columns, rows) float64, the true surface.
    more_starts : (vehicles, 3) float64 each, ENU metres, to begin from besides the drawn ones.

    Returns
    -------
    share of the surface covered, and the places, (vehicles, 3) float64 ENU metres.
    """
    params = params or AscentParams()
    coarse, fine = _Surface(grid, elevation_m, team, 2), _Surface(grid, elevation_m, team, 1)
    begun = [_spread(coarse, vehicles, rng) for _ in range(params.starts)] + [start.copy() for start in more_starts]
    ended = sorted((_ascend(coarse, places, params, rng) for places in begun), key=lambda end: -end[0])
    refined = [_ascend(fine, places, params, rng) for _, places in ended[: params.kept]]
    return max(refined, key=lambda end: end[0])


def _spread(surface: _Surface, vehicles: int, rng: np.random.Generator) -> FloatArray:
    """A random team after a few Lloyd iterations in the plane."""
    grid = surface.full_grid
    lows, highs = (grid.west_m, grid.south_m), (grid.east_m, grid.north_m)
    samples = rng.uniform(lows, highs, (2_000, 2))
    places = np.full((vehicles, 3), 0.0)
    places[:, :2] = rng.uniform(lows, highs, (vehicles, 2))
    for _ in range(int(rng.integers(0, 10))):
        nearest = ((samples[:, None, :] - places[None, :, :2]) ** 2).sum(axis=2).argmin(axis=1)
        for index in np.unique(nearest):
            places[index, :2] = samples[nearest == index].mean(axis=0)
    columns, rows = (
        ((places[:, axis] - lows[axis]) / grid.cell_m).astype(np.int64).clip(0, grid.shape[axis] - 1) for axis in (0, 1)
    )
    lowest_m = surface.team.min_above_m
    above_m = rng.uniform(lowest_m, max(lowest_m, 0.5 * surface.team.range_m), vehicles)
    places[:, 2] = surface.full_m[columns, rows] + above_m
    return places


def _ascend(
    surface: _Surface, start: FloatArray, params: AscentParams, rng: np.random.Generator
) -> tuple[float, FloatArray]:
    places = start.copy()
    views = [surface.view(place) for place in places]
    watchers = np.sum(views, axis=0)
    covered, stale = int(np.count_nonzero(watchers)), 0
    for _ in range(params.most_rounds):
        for index in rng.permutation(len(places)):
            watchers -= views[index]
            others = np.delete(places, index, axis=0)
            choices = _choices(surface, places[index], others, params, rng)
            if (best := surface.best(choices, watchers == 0)) != 0:
                places[index] = choices[best]
                views[index] = surface.view(places[index])
            watchers += views[index]
        now = int(np.count_nonzero(watchers))
        stale = stale + 1 if now <= covered else 0
        covered = now
        if stale >= params.stale_rounds or covered == watchers.size:
            break
    return covered / watchers.size, places


def _choices(
    surface: _Surface, place: FloatArray, others: FloatArray, params: AscentParams, rng: np.random.Generator
) -> FloatArray:
    """The present place first, then admissible places around it and anywhere: (M, 3)."""
    team, grid = surface.team, surface.full_grid
    around = [place + rng.standard_normal((params.per_scale, 3)) * (s, s, 0.5 * s) for s in params.scales_m]
    anywhere = rng.uniform(
        (grid.west_m, grid.south_m, 0.0), (grid.east_m, grid.north_m, team.ceiling_m), (params.anywhere, 3)
    )
    anywhere[::2, 2] = 0.0  # every other as low as it may be
    choices = surface.admissible(np.concatenate([*around, anywhere]))
    apart = np.linalg.norm(choices[:, None, :] - others[None, :, :], axis=2)
    apart_enough = (apart >= team.separation_m).all(axis=1) if len(others) else np.ones(len(choices), dtype=np.bool_)
    return np.vstack((place[None, :], choices[apart_enough]))
