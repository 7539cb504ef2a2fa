"""Centralised greedy: clusters of frontiers assigned one by one, nearest pair first (Renzaglia 2020, section 7).

Every vehicle that holds the same map and positions computes the same assignment, so a team can run it without a
server; with a map or positions that lag behind, assignments may clash, which a central node would not let happen.
"""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid
from vehicle_agent.planning.frontier_travel import go_for
from vehicle_agent.planning.frontiers import candidate_frontiers, map_frontiers
from vehicle_agent.planning.given_up import GivenUp
from vehicle_agent.planning.interface import Decision, Finished, Observation, Situation


def assign_nearest_pairs(vehicles_en_m: FloatArray, clusters_en_m: FloatArray) -> list[int]:
    """Cluster of each vehicle: repeatedly the nearest free pair; clusters are shared only when they run out.

    Parameters
    ----------
    vehicles_en_m : (N, 2) float64; clusters_en_m : (K, 2) float64 with K >= 1, ENU metres.
    """
    distances = np.linalg.norm(vehicles_en_m[:, None, :] - clusters_en_m[None, :, :], axis=2)
    assigned = [int(np.argmin(row)) for row in distances]
    free = distances.copy()
    for _ in range(min(free.shape)):
        vehicle, cluster = np.unravel_index(int(np.argmin(free)), free.shape)
        assigned[int(vehicle)] = int(cluster)
        free[vehicle, :] = np.inf
        free[:, cluster] = np.inf
    return assigned


class Greedy:
    """One vehicle's part of the centralised assignment."""

    def __init__(self, grid: Grid, range_m: float) -> None:
        self._given_up = GivenUp(grid)
        self._block_cells = max(1, round(range_m / grid.cell_m))

    def tell(self, observation: Observation) -> None:
        """Nothing is learned from measurements beyond the map."""

    def ask(self, situation: Situation) -> Decision:
        grid = situation.team_map.grid
        frontier = self._given_up.without(map_frontiers(situation.team_map, situation.area_cells))
        clusters = candidate_frontiers(grid, frontier, self._block_cells)
        if len(clusters) == 0:
            return Finished("no frontier is left")
        team = sorted(
            [(situation.index, situation.position_enu_m), *((t.index, t.position_enu_m) for t in situation.teammates)]
        )
        assigned = assign_nearest_pairs(np.array([position[:2] for _, position in team]), clusters.points_en_m)
        mine = assigned[[index for index, _ in team].index(situation.index)]
        east_m, north_m = clusters.points_en_m[mine]
        return go_for(
            situation, (float(east_m), float(north_m)), int(clusters.cell_indices[mine]), self._given_up, "assigned"
        )
