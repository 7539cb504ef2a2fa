"""A team's landmarks as a map of cells: one landmark at the centre of every cell of a grid."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.landmark_layout import LandmarkLayout, LandmarkParams
from vehicle_agent.domain.landmark_records import SEAL, LandmarkRecords
from vehicle_agent.domain.landmarks import LandmarkMap
from vehicle_agent.domain.polygon import BoolArray


class LandmarkAtlas:
    """A `TeamMap` made of landmarks.

    Attributes
    ----------
    grid
        Its cells; landmark ids are their flat indices.
    landmarks
        What is known of them.
    """

    def __init__(self, grid: Grid, params: LandmarkParams, vehicles: int, own_index: int) -> None:
        self.grid = grid
        self.landmarks = LandmarkMap(LandmarkLayout.at_cells(grid), params, vehicles, own_index)

    @property
    def observed(self) -> BoolArray:
        """(columns, rows) bool, cells whose landmark somebody has measured."""
        known: BoolArray = np.isfinite(self.landmarks.heights_m).reshape(self.grid.shape)
        return known

    @property
    def elevation_m(self) -> FloatArray:
        """(columns, rows) float64, ENU z; NaN where unknown."""
        return self.landmarks.heights_m.reshape(self.grid.shape)

    @property
    def sd_m(self) -> FloatArray:
        """(columns, rows) float64, standard deviation of the elevation; infinite where unknown."""
        return self.landmarks.sd_m.reshape(self.grid.shape)

    @property
    def accurate(self) -> BoolArray:
        """(columns, rows) bool, accurately estimated (Kapoutsis 2015, definition 2)."""
        return self.landmarks.accurate.reshape(self.grid.shape)

    def first_observer_share(self, observer: int, within: BoolArray | None = None) -> float:
        """Landmarks that a vehicle measured; one that several measured is shared among them."""
        records = self.landmarks.records()
        contributed = records[records.contributors != SEAL]
        shared = np.bincount(contributed.landmarks, minlength=self.grid.cells)
        own = contributed.landmarks[contributed.contributors == observer]
        if within is not None:
            own = own[within.ravel()[own]]
        return float((1.0 / shared[own]).sum())

    def merge(self, other: Self) -> None:
        """Join another atlas of the same grid and team."""
        self.landmarks.merge(other.landmarks.records())

    def copy(self) -> Self:
        known = self.landmarks
        twin = type(self)(self.grid, known.params, known.vehicles, known.own_index)
        twin.landmarks.merge(known.records())
        return twin

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Its records, from which `of_arrays` makes it anew, and what they amount to in every cell."""
        records = self.landmarks.records()
        return {
            "record_landmarks": records.landmarks,
            "record_contributors": records.contributors,
            "record_attempts": records.attempts,
            "record_heights": records.heights,
            "record_information": records.information,
            "landmark_elevation_m": self.elevation_m,
            "landmark_sd_m": self.sd_m,
            "landmark_accurate": self.accurate,
        }

    @classmethod
    def of_arrays(
        cls, grid: Grid, params: LandmarkParams, vehicles: int, arrays: Mapping[str, npt.NDArray[Any]]
    ) -> LandmarkAtlas:
        """An atlas from its arrays; KeyError when they are not those of one."""
        atlas = cls(grid, params, vehicles, 0)
        names = ("landmarks", "contributors", "attempts", "heights", "information")
        atlas.landmarks.merge(LandmarkRecords(*(arrays[f"record_{name}"].astype(np.int64) for name in names)))
        return atlas
