"""Exploration by lanes and by tours when what there is to see changes: sectors and forbidden ground come and go."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vehicle_agent.domain.elevation import ElevationMap
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.planning.constraints import Constraints
from vehicle_agent.planning.interface import Situation, Waypoint
from vehicle_agent.planning.lane_explorer import LaneExplorer
from vehicle_agent.planning.team_lanes import LanesParams
from vehicle_agent.planning.tour_explorer import TourExplorer

GRID = Grid(0.0, 0.0, 2.0, 50, 40)
RANGE_M = 16.0
WHOLE = np.ones(GRID.shape, dtype=bool)
SECTOR = WHOLE & (np.arange(GRID.columns) > 42)[:, None] & (np.arange(GRID.rows) > 32)
CONSTRAINTS = Constraints(GRID, np.zeros(GRID.shape), 3.0, 20.0, 4.0)


def seen(area_cells: BoolArray) -> Situation:
    return Situation(0, (5.0, 5.0, 5.0), ElevationMap(GRID), area_cells, RANGE_M, CONSTRAINTS)


def test_tours_lead_through_an_area_that_grows() -> None:
    tours = TourExplorer(None, RANGE_M)
    decision = tours.ask(seen(SECTOR))
    for _ in range(3):  # the first leg is flown to its end
        assert isinstance(decision, Waypoint)
        decision = tours.ask(replace(seen(WHOLE), position_enu_m=decision.position_enu_m))
    assert isinstance(decision, Waypoint)
    assert decision.tour is not None
    assert len(decision.tour.patches) > 10


def test_a_sector_is_no_part_of_the_plan_for_the_team() -> None:
    lanes = LaneExplorer(None, TourExplorer(None, RANGE_M), LanesParams(first_trials=2_000, trials=200))
    before, alone, after = (lanes.ask(seen(area)) for area in (WHOLE, SECTOR, WHOLE))
    assert isinstance(before, Waypoint)
    assert isinstance(alone, Waypoint)
    assert isinstance(after, Waypoint)
    assert (before.lanes is None, alone.lanes is None, after.lanes is None) == (False, True, False)
    assert alone.goal_enu_m is not None
    assert SECTOR[GRID.cell_of(*alone.goal_enu_m[:2])]
