"""Closest frontier: each vehicle on its own goes for the frontier point nearest to it (Yamauchi; Renzaglia sec. 7)."""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.grid import Grid
from vehicle_agent.planning.frontier_travel import go_for
from vehicle_agent.planning.frontiers import candidate_frontiers, map_frontiers
from vehicle_agent.planning.given_up import GivenUp
from vehicle_agent.planning.interface import Decision, Finished, Observation, Situation


class ClosestFrontier:
    """Goes for the nearest frontier point, chosen anew at every step."""

    def __init__(self, grid: Grid) -> None:
        self._given_up = GivenUp(grid)

    def tell(self, observation: Observation) -> None:
        """Nothing is learned from measurements beyond the map."""

    def ask(self, situation: Situation) -> Decision:
        grid = situation.team_map.grid
        frontier = self._given_up.without(map_frontiers(situation.team_map, situation.area_cells))
        candidates = candidate_frontiers(grid, frontier, block_cells=1)
        if len(candidates) == 0:
            return Finished("no frontier is left")
        distances_m = np.hypot(*(candidates.points_en_m - np.array(situation.position_enu_m[:2])).T)
        best = int(np.argmin(distances_m))
        east_m, north_m = candidates.points_en_m[best]
        return go_for(
            situation,
            (float(east_m), float(north_m)),
            int(candidates.cell_indices[best]),
            self._given_up,
            "the nearest",
        )
