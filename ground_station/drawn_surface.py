"""The sea floor between the landmarks, as the station draws it while the map forms."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.landmark_atlas import LandmarkAtlas

FEWEST_LANDMARKS, MOST_LANDMARKS = 12, 250
"""Through fewer nothing is drawn; of more every n-th is left out, so that the screen stays quick."""
REDRAWN_AFTER = 1.1
"""Drawn anew when so many times as many landmarks are known as when it was drawn last."""
MOST_CELLS = 10_000
"""A larger map is shown by its landmarks alone."""


@dataclass(frozen=True, slots=True, eq=False)
class DrawnSurface:
    """A surface through landmarks.

    Attributes
    ----------
    elevation_m, sd_m
        (columns, rows) float64, ENU z and its standard deviation.
    landmarks
        How many were known.
    """

    elevation_m: FloatArray
    sd_m: FloatArray
    landmarks: int

    def typical_sd_m(self) -> float:
        """Root mean square of the standard deviations."""
        return float(np.sqrt(np.mean(self.sd_m**2)))


def redrawn(former: DrawnSurface | None, atlas: LandmarkAtlas) -> DrawnSurface | None:
    """The surface as it is drawn now: the former one until there is a good deal more to draw."""
    known = np.flatnonzero(np.isfinite(atlas.landmarks.heights_m))
    if len(known) < FEWEST_LANDMARKS or atlas.grid.cells > MOST_CELLS:
        return former
    if former is not None and len(known) < REDRAWN_AFTER * former.landmarks:
        return former
    from vehicle_agent.domain.relief import Relief  # its solvers load only where a team maps

    some = known[:: math.ceil(len(known) / MOST_LANDMARKS)]
    landmarks, places = atlas.landmarks, atlas.landmarks.layout.positions_en_m
    relief = Relief(places[some], landmarks.heights_m[some], landmarks.sd_m[some])
    shape = atlas.grid.shape
    return DrawnSurface(relief.heights_at(places).reshape(shape), relief.sds_at(places).reshape(shape), len(known))
