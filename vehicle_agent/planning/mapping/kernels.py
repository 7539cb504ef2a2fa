"""Compiles the kernels of mapping missions once and keeps the result in the cache."""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.landmark_layout import LandmarkLayout, LandmarkParams
from vehicle_agent.domain.landmarks import LandmarkMap
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.range_sensing import RangeSensor
from vehicle_agent.planning.interface import Teammate
from vehicle_agent.planning.mapping.infill import telling_track
from vehicle_agent.planning.mapping.interface import HeightBand, MappingSituation


def warm_up() -> None:
    """Call the kernels of surveys with the types they are used with."""
    nodes = np.array([[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]])
    telling_track(np.zeros(2), nodes, np.ones(4), np.ones(4), 10.0, 1.0, 1.5, 1)


def warm_up_viewpoints() -> None:
    """The same for those of the planner of viewpoints, by asking it in a puddle."""
    from vehicle_agent.planning.mapping.default import ViewpointPlanner  # its kernels load only where used

    params = LandmarkParams(accurate_sd_m=0.2, best_sd_m=0.01, lowest_m=-20.0, highest_m=0.0)
    landmarks = LandmarkMap(LandmarkLayout.at_cells(Grid(0.0, 0.0, 2.5, 8, 8)), params, 2, 0)
    landmarks.observe(np.arange(4), np.full(4, -10.0), np.full(4, 0.5))

    def everywhere(ends_enu_m: np.ndarray) -> BoolArray:
        return np.ones(len(ends_enu_m), dtype=np.bool_)

    sensor, band = RangeSensor(30.0, 0.01, 1.25), HeightBand(1.0, -2.0, -2.0)
    mates = (Teammate(1, (15.0, 15.0, -3.0)),)
    planner = ViewpointPlanner(2)
    for east_m in (3.0, 6.0):
        planner.ask(MappingSituation(0, (east_m, 3.0, -2.0), landmarks, sensor, band, 10.0, everywhere, mates))


if __name__ == "__main__":
    warm_up()
