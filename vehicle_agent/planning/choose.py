"""The planner that a mission names."""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.grid import Grid
from vehicle_agent.mission.model import PlannerName
from vehicle_agent.planning.baselines.closest_frontier import ClosestFrontier
from vehicle_agent.planning.baselines.greedy import Greedy
from vehicle_agent.planning.cao import CaoParams
from vehicle_agent.planning.claims import Claims
from vehicle_agent.planning.exploration import CaoExplorer, Fcao
from vehicle_agent.planning.interface import Planner
from vehicle_agent.planning.tour_explorer import TourExplorer


def make_planner(
    name: PlannerName,
    grid: Grid,
    range_m: float,
    step_m: float,
    home_en_m: tuple[float, float] | None,
    rng: np.random.Generator,
) -> Planner:
    """Build the planner of that name for one vehicle.

    Parameters
    ----------
    range_m
        The vehicle's sensing distance, metres.
    step_m
        Longest way between two decisions, metres.
    home_en_m
        Where it returns to, east and north in ENU metres; None when it need not.
    """
    match name:
        case "tours":
            return TourExplorer(home_en_m, range_m)
        case "claims":
            return Claims(grid, range_m)
        case "fcao":
            return Fcao(CaoParams(step_m), grid, rng)
        case "cao":
            return CaoExplorer(CaoParams(step_m), rng)
        case "closest-frontier":
            return ClosestFrontier(grid)
        case "greedy":
            return Greedy(grid, range_m)
