"""Claims: decentralised exploration in which vehicles leave a frontier to whoever is better placed for it.

Every vehicle weighs the frontiers of the team's map by what lies unseen around them, by how far they are, and by how
many teammates are nearer (the rank of MinPos, Bautin, Simonin, Charpillet 2012), takes the best and says so. Ground
around a teammate's claim counts as that teammate's unless this vehicle is nearer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid
from vehicle_agent.planning.frontier_travel import go_for
from vehicle_agent.planning.frontiers import FrontierCandidates, candidate_frontiers, map_frontiers, unknown_around
from vehicle_agent.planning.given_up import GivenUp
from vehicle_agent.planning.interface import Decision, Finished, Observation, Situation


@dataclass(frozen=True, slots=True)
class ClaimsParams:
    """How frontiers are weighed; lengths in units of the sensing range.

    Attributes
    ----------
    gain_weight
        How much further a vehicle goes for a frontier with a whole sensor footprint of unseen ground around it.
    rank_weight
        How much nearer a frontier must be for each teammate that is nearer to it.
    claim_radius
        Around a teammate's goal, what counts as the teammate's.
    claim_weight
        How much nearer a frontier inside a teammate's claim must be.
    persistence
        How much nearer another frontier must be to change the goal for it.
    """

    gain_weight: float = 1.5
    rank_weight: float = 1.0
    claim_radius: float = 1.2
    claim_weight: float = 3.0
    persistence: float = 0.5


class Claims:
    """One vehicle's choice among the frontiers of the team's map."""

    def __init__(self, grid: Grid, range_m: float, params: ClaimsParams | None = None) -> None:
        self._params = params or ClaimsParams()
        self._range_m = range_m
        self._block_cells = max(1, round(0.5 * range_m / grid.cell_m))
        self._given_up = GivenUp(grid)
        self._goal_en_m: FloatArray | None = None

    def tell(self, observation: Observation) -> None:
        """Nothing is learned from measurements beyond the map."""

    def ask(self, situation: Situation) -> Decision:
        grid = situation.team_map.grid
        frontier = self._given_up.without(map_frontiers(situation.team_map, situation.area_cells))
        candidates = candidate_frontiers(grid, frontier, self._block_cells)
        if len(candidates) == 0:
            return Finished("no frontier is left")
        costs, ranks, claimed = self._weigh(situation, candidates)
        best = int(np.argmin(costs))
        remark = (
            "claimed by a nearer teammate, but nothing better is left"
            if claimed[best]
            else "nobody is nearer"
            if ranks[best] == 0
            else f"{ranks[best]:.0f} nearer but busy elsewhere"
        )
        self._goal_en_m = candidates.points_en_m[best]
        east_m, north_m = candidates.points_en_m[best]
        return go_for(
            situation, (float(east_m), float(north_m)), int(candidates.cell_indices[best]), self._given_up, remark
        )

    def _weigh(self, situation: Situation, candidates: FrontierCandidates) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Cost of every candidate in sensing ranges, how many teammates are nearer, and which are claimed by them."""
        params, range_m = self._params, self._range_m
        points = candidates.points_en_m
        unknown = situation.area_cells & ~situation.team_map.observed
        half_width_m = 0.7 * range_m
        footprint_cells = (2.0 * half_width_m / situation.team_map.grid.cell_m) ** 2
        gains = unknown_around(unknown, situation.team_map.grid, points, half_width_m) / footprint_cells
        distances = np.hypot(*(points - np.array(situation.position_enu_m[:2])).T) / range_m
        ranks = np.zeros(len(points))
        claimed = np.zeros(len(points))
        for teammate in situation.teammates:
            theirs = np.hypot(*(points - np.array(teammate.position_enu_m[:2])).T) / range_m
            ranks += theirs < distances
            if teammate.goal_enu_m is not None:
                beside = np.hypot(*(points - np.array(teammate.goal_enu_m[:2])).T) / range_m
                via_goal = teammate.goal_cost_m / range_m + beside
                claimed = np.maximum(claimed, (beside < params.claim_radius) & (via_goal < distances))
        costs = distances - params.gain_weight * np.sqrt(gains)
        costs += params.rank_weight * ranks + params.claim_weight * claimed
        if self._goal_en_m is not None:
            near_old_goal = np.hypot(*(points - self._goal_en_m).T) < 0.5 * range_m
            costs -= params.persistence * near_old_goal
        return costs, ranks, claimed
