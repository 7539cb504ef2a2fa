"""Explore first, then cover what was found: the switch that Renzaglia 2020, section 8, leaves open."""

from __future__ import annotations

from vehicle_agent.domain.frames import Point
from vehicle_agent.planning.interface import Decision, Finished, Observation, Planner, Situation, has_thought


class ExploreThenCover:
    """One vehicle's two tasks, one after the other; each vehicle switches by its own map.

    Parameters
    ----------
    explorer, coverer
        Who decides before and after.
    enough
        Share of the area's cells that are to be known before coverage begins; it begins as well when the explorer
        has nothing left that it could see.
    """

    def __init__(self, explorer: Planner, coverer: Planner, enough: float) -> None:
        self._explorer, self._coverer, self._enough = explorer, coverer, enough
        self.covers = False

    def tell(self, observation: Observation) -> None:
        (self._coverer if self.covers else self._explorer).tell(observation)

    def think(self, situation: Situation, place_enu_m: Point) -> bool:
        return has_thought(self._coverer if self.covers else self._explorer, situation, place_enu_m)

    def ask(self, situation: Situation) -> Decision:
        if not self.covers:
            unseen = int((situation.area_cells & ~situation.team_map.observed).sum())
            self.covers = unseen <= (1.0 - self._enough) * int(situation.area_cells.sum())
        if not self.covers:
            decision = self._explorer.ask(situation)
            if not isinstance(decision, Finished):
                return decision
            self.covers = True
        return self._coverer.ask(situation)
