"""The planner that a mission names."""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.grid import Grid
from vehicle_agent.mission.tasks import DEFAULT_PLANNER, CoverTask, ExploreTask, PlannerName
from vehicle_agent.planning.baselines.closest_frontier import ClosestFrontier
from vehicle_agent.planning.baselines.greedy import Greedy
from vehicle_agent.planning.cao import CaoParams
from vehicle_agent.planning.claims import Claims
from vehicle_agent.planning.coverage import CaoCoverage
from vehicle_agent.planning.exploration import CaoExplorer, Fcao
from vehicle_agent.planning.explore_then_cover import ExploreThenCover
from vehicle_agent.planning.interface import Planner
from vehicle_agent.planning.lane_explorer import LaneExplorer
from vehicle_agent.planning.spread_first import SpreadFirst
from vehicle_agent.planning.stations import Stations, StationsParams
from vehicle_agent.planning.tour_explorer import TourExplorer


def make_task_planner(
    task: ExploreTask | CoverTask,
    enough: float,
    grid: Grid,
    range_m: float,
    home_en_m: tuple[float, float] | None,
    rng: np.random.Generator,
    first_place_enu_m: Point | None = None,
) -> Planner:
    """Build the planner of a mission's task for one vehicle.

    Parameters
    ----------
    enough
        Share of the area to be seen where exploration comes before coverage.
    grid, range_m, home_en_m, rng
        As for `make_planner`.
    first_place_enu_m
        Where the vehicle begins to cover; None for where it is then.
    """
    if isinstance(task, ExploreTask):
        return make_planner(task.planner or DEFAULT_PLANNER, grid, range_m, task.step_m, home_en_m, rng)
    coverer: Planner
    match task.planner:
        case "stations":
            coverer = Stations(rng, StationsParams(hold=max(1, round(task.hold_s))))
        case "cao":
            coverer = CaoCoverage(CaoParams(task.step_m), rng, measures_itself=True)
    if first_place_enu_m is not None:
        coverer = SpreadFirst(first_place_enu_m, coverer)
    if not task.explore_first:
        return coverer
    return ExploreThenCover(make_planner("tours", grid, range_m, task.step_m, home_en_m, rng), coverer, enough)


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
        case "lanes":
            return LaneExplorer(home_en_m, TourExplorer(home_en_m, range_m))
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
