"""FCAO: local stochastic optimisation with frontiers as the way out of its dead ends (Renzaglia 2020, algorithm 1)."""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.grid import Grid
from vehicle_agent.planning.baselines.closest_frontier import ClosestFrontier
from vehicle_agent.planning.cao import Cao, CaoParams
from vehicle_agent.planning.frontiers import map_frontiers
from vehicle_agent.planning.interface import Decision, Finished, Observation, Situation, Wait, Waypoint


class CaoExplorer:
    """CAO on the exploration objective J_E (eq. 5) alone; stuck in its local optima as the paper says."""

    def __init__(self, params: CaoParams, rng: np.random.Generator) -> None:
        self._cao = Cao(params, rng)

    def tell(self, observation: Observation) -> None:
        self._cao.tell(observation.position_enu_m, observation.objective)

    def ask(self, situation: Situation) -> Decision:
        if not map_frontiers(situation.team_map, situation.area_cells).any():
            return Finished("no frontier is left")
        return self.step(situation)

    def step(self, situation: Situation) -> Decision:
        """One step of CAO, without asking whether anything is left."""
        here = situation.position_enu_m
        end = self._cao.ask(here, lambda ends: situation.constraints.admissible(here, ends))
        return (
            Wait("no admissible perturbation") if end is None else Waypoint(end, "local optimum of what was measured")
        )


class Fcao:
    """CAO until the objective ceases to grow, then to the closest frontier, then CAO again."""

    def __init__(self, params: CaoParams, grid: Grid, rng: np.random.Generator) -> None:
        self._local = CaoExplorer(params, rng)
        self._frontier = ClosestFrontier(grid)
        self._last_objective: float | None = None
        self._escaping = False

    def tell(self, observation: Observation) -> None:
        """Algorithm 1: leave CAO when J_E(t) = J_E(t - 1), come back to it when it grows again."""
        self._local.tell(observation)
        if self._last_objective is not None:
            self._escaping = observation.objective <= self._last_objective
        self._last_objective = observation.objective

    def ask(self, situation: Situation) -> Decision:
        if not self._escaping:
            decision = self._local.step(situation)
            if isinstance(decision, Waypoint):
                return decision
        return self._frontier.ask(situation)
