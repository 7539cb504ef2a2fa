"""The unseen ground by patches, each about as wide as a sensor sweeps, and where to stop to see all of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.elevation import ElevationMap
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid, IndexArray
from vehicle_agent.domain.patch_sums import sum_unseen, take_off
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.stops import choose_stops


@dataclass(frozen=True, slots=True)
class Stops:
    """Where to go to see the ground that is unseen.

    Attributes
    ----------
    numbers : (S,) int64, number of each stop's patch in the division, ascending.
    places_en_m : (S, 2) float64, east and north in ENU metres.
    unseen : (S,) int64, unseen cells that each shows.
    """

    numbers: IndexArray
    places_en_m: FloatArray
    unseen: npt.NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.numbers)


class PatchDivision:
    """Divides a grid into equal rectangles of at most a given width.

    The whole grid, so that patches have the same numbers for all vehicles, whichever part each has to see.

    Parameters
    ----------
    grid
        The cells.
    width_m
        Widest that a patch may be, metres; patches are wider where there would be more than `most` of them.

    Attributes
    ----------
    corner_en_m : (2,) float64, south-western corner of the first patch, ENU metres.
    across, along : (columns,) and (rows,) int64; the sum of both is the number of a cell's patch.
    """

    def __init__(self, grid: Grid, width_m: float, most: int = 400) -> None:
        self.grid = grid
        spans = grid.shape
        while True:
            cells_wide = max(1.0, width_m / grid.cell_m)
            self.shape = (max(1, int(np.ceil(spans[0] / cells_wide))), max(1, int(np.ceil(spans[1] / cells_wide))))
            if self.shape[0] * self.shape[1] <= most:
                break
            width_m *= 1.25
        self.size_cells = (spans[0] / self.shape[0], spans[1] / self.shape[1])
        across, along = (
            np.arange(cells, dtype=np.int64) * parts // cells for cells, parts in zip(spans, self.shape, strict=True)
        )
        self.across: IndexArray = across * self.shape[1]
        self.along: IndexArray = along
        self.corner_en_m: FloatArray = np.array((grid.west_m, grid.south_m))

    def middle_cells(self) -> tuple[IndexArray, IndexArray]:
        """Columns and rows of the cells in the middle of the patches: (patches across,) and (patches along,) int64."""
        columns, rows = (
            (2 * np.arange(parts) + 1) * cells // (2 * parts)
            for cells, parts in zip(self.grid.shape, self.shape, strict=True)
        )
        return columns, rows

    def cells_of(self, number: int) -> tuple[slice, slice]:
        """Columns and rows of a patch."""
        across, along = divmod(number, self.shape[1])
        return tuple(  # type: ignore[return-value]
            slice(-(-place * cells // parts), -(-(place + 1) * cells // parts))
            for cells, parts, place in zip(self.grid.shape, self.shape, (across, along), strict=True)
        )


class UnseenPatches:
    """Keeps count of unseen cells by patch: what is new in the map is taken off, the rest is not looked at again.

    Parameters
    ----------
    division
        Of the grid into patches.
    """

    def __init__(self, division: PatchDivision) -> None:
        self._division = division
        self._sums: IndexArray = np.zeros((division.shape[0] * division.shape[1], 3), dtype=np.int64)
        self._marks: IndexArray = np.zeros(division.grid.shape, dtype=np.int64)
        self._mark = 0
        self._map: ElevationMap | None = None
        self._area: BoolArray | None = None
        self._known_cells = 0

    def follow(self, team_map: ElevationMap, area_cells: BoolArray) -> None:
        """Take in what was observed since the last call; count anew for another map or another area."""
        across, along = self._division.across, self._division.along
        if self._map is team_map and self._area is area_cells:
            take_off(self._sums, team_map.observed_since(self._known_cells), area_cells, across, along)
        else:
            self._map, self._area = team_map, area_cells
            sum_unseen(self._sums, team_map.first_stamp_ms, area_cells, across, along)
        self._known_cells = team_map.observed_cells

    def unseen_in(self, patch: int) -> int:
        """Number of unseen cells of a patch."""
        return int(self._sums[patch, 0])

    def in_all(self) -> int:
        """Number of unseen cells."""
        return int(self._sums[:, 0].sum())

    def by_place(self) -> FloatArray:
        """Number of unseen cells of each patch: (patches across, patches along) float64."""
        return self._sums[:, 0].reshape(self._division.shape).astype(np.float64)

    def stops(self, given_up: set[int], radius_m: float, remnant_cells: float, beside_m: float) -> Stops:
        """Places from which all that is unseen is seen, at most one in each patch.

        Parameters
        ----------
        given_up : patches that nobody is to stop in.
        radius_m : how far is seen from a stop.
        remnant_cells, beside_m : a patch with fewer unseen cells has no stop where another is nearer than that.
        """
        assert self._map is not None, "follow a map first"
        assert self._area is not None
        grid = self._division.grid
        wanted = self._sums[:, 0] > 0
        wanted[list(given_up)] = False
        self._mark += 1
        numbers, places, unseen = choose_stops(
            self._map.first_stamp_ms, self._area, self._division.across, self._division.along, self._sums, wanted,
            self._marks, self._mark, radius_m / grid.cell_m, remnant_cells, beside_m / grid.cell_m,
        )  # fmt: skip
        order = np.argsort(numbers)
        places_en_m = (places[order] + 0.5) * grid.cell_m + (grid.west_m, grid.south_m)
        return Stops(numbers[order], places_en_m, unseen[order])

    def any_left(self, given_up: set[int]) -> bool:
        """Tell whether a patch that is not given up holds unseen cells."""
        return any(int(number) not in given_up for number in np.flatnonzero(self._sums[:, 0]))
