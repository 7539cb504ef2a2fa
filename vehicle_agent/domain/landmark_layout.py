"""What a team knows of its landmarks beforehand: where they stand, and what counts as knowing their heights."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.landmark_records import (
    ACCURATE,
    MAX_ATTEMPTS,
    MAX_HEIGHT_QUANTA,
    MAX_INFORMATION,
    QUANTA_PER_ACCURATE_SD,
)
from vehicle_agent.domain.polygon import BoolArray


@dataclass(frozen=True, slots=True)
class LandmarkLayout:
    """Where the landmarks stand: the (x_l, y_l) of section 3.1, known to all before the mission.

    Attributes
    ----------
    positions_en_m
        (N, 2) float64, east and north in ENU metres; a landmark's id is its row.
    spacing_m
        Typical distance between neighbours.
    """

    positions_en_m: FloatArray
    spacing_m: float

    def __post_init__(self) -> None:
        if self.positions_en_m.ndim != 2 or self.positions_en_m.shape[1] != 2 or len(self.positions_en_m) == 0:
            raise ValueError("a layout needs at least one landmark, as (N, 2) east and north")
        if not np.isfinite(self.positions_en_m).all():
            raise ValueError("landmarks stand at finite places")
        if not (self.spacing_m > 0 and math.isfinite(self.spacing_m)):
            raise ValueError("spacing_m must be positive")

    @classmethod
    def at_cells(cls, grid: Grid, cells: BoolArray | None = None) -> LandmarkLayout:
        """A landmark at the centre of every cell (or of those marked), in the order of flat indices."""
        indices = np.arange(grid.cells) if cells is None else np.flatnonzero(cells)
        return cls(grid.centres_of(indices.astype(np.int64)), grid.cell_m)

    def __len__(self) -> int:
        return len(self.positions_en_m)


@dataclass(frozen=True, slots=True)
class LandmarkParams:
    """What counts as accurately estimated, and what can be believed.

    Attributes
    ----------
    accurate_sd_m
        A landmark is accurately estimated when its standard deviation is at most this (definition 2).
    best_sd_m
        No single measurement is better: the sensor's own limit, which no message may claim to beat.
    lowest_m, highest_m
        ENU z between which every landmark's height lies.
    attempts_limit
        A landmark that was measured so often without becoming accurate is given up (footnote 3).
    """

    accurate_sd_m: float
    best_sd_m: float
    lowest_m: float
    highest_m: float
    attempts_limit: int = 200

    def __post_init__(self) -> None:
        if not (self.accurate_sd_m > 0 and math.isfinite(self.accurate_sd_m)):
            raise ValueError("accurate_sd_m must be positive")
        if not (self.best_sd_m > 0 and math.isfinite(self.best_sd_m)):
            raise ValueError("best_sd_m must be positive")
        if not -math.inf < self.lowest_m < self.highest_m < math.inf:
            raise ValueError("lowest_m must be below highest_m")
        if not 1 <= self.attempts_limit <= MAX_ATTEMPTS:
            raise ValueError(f"attempts_limit must be from 1 to {MAX_ATTEMPTS}")
        if max(abs(self.lowest_m), abs(self.highest_m)) / self.quantum_m >= MAX_HEIGHT_QUANTA:
            raise ValueError("accurate_sd_m is too small for heights from lowest_m to highest_m")

    @property
    def quantum_m(self) -> float:
        """What heights are told in, metres."""
        return self.accurate_sd_m / QUANTA_PER_ACCURATE_SD

    @property
    def best_information(self) -> int:
        """Most that one measurement can add, in parts of `ACCURATE`."""
        return min(math.ceil(ACCURATE * (self.accurate_sd_m / self.best_sd_m) ** 2), MAX_INFORMATION // 128)
