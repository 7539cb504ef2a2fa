"""Static coverage by CAO (Renzaglia 2020, sections 3 and 4): every vehicle climbs its share of what the team sees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.elevation import ElevationMap
from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.sensing import view
from vehicle_agent.planning.cao import Cao, CaoParams
from vehicle_agent.planning.interface import Decision, Observation, Situation, Wait, Waypoint


def coverage_share(own_view: BoolArray, teammates_views: Sequence[BoolArray]) -> float:
    """J_C of one vehicle: the cells that it sees, each divided by the number of vehicles that see it (eq. 1).

    Parameters
    ----------
    own_view, teammates_views : (columns, rows) bool each, what each vehicle sees now (O_t).
    """
    watchers = np.zeros(own_view.shape, dtype=np.int64)  # |mu_t(s)|, eq. 2
    for seen in (own_view, *teammates_views):
        watchers += seen
    return float((1.0 / watchers[own_view]).sum())


def coverage_objective(
    team_map: ElevationMap,
    area_cells: BoolArray,
    position_enu_m: Point,
    range_m: float,
    teammates: Sequence[tuple[Point, float]],
) -> float:
    """J_C of one vehicle by the team's map: it holds all that anybody sees, so nobody needs to send views.

    Parameters
    ----------
    teammates
        Where each is, and how far it sees.
    """
    elevation_m = team_map.elevation_m
    views = [
        view(team_map.grid, elevation_m, place, reach_m) & area_cells
        for place, reach_m in [(position_enu_m, range_m), *teammates]
    ]
    return coverage_share(views[0], views[1:])


@dataclass(frozen=True, slots=True)
class StepSchedule:
    """The decreasing step alpha_t = first_m / (1 + t / half_life) ** decay.

    With `decay` in (1/2, 1] it satisfies eq. 11: it falls to 0, its sum diverges, the sum of its squares converges.

    Attributes
    ----------
    first_m
        alpha_0.
    half_life
        Decisions until the step has begun to fall in earnest (at decay 1: is halved).
    decay
        Exponent.
    """

    first_m: float
    half_life: float = 60.0
    decay: float = 0.7

    def __post_init__(self) -> None:
        if not (self.first_m > 0.0 and self.half_life > 0.0):
            raise ValueError("first_m and half_life must be positive")
        if not 0.5 < self.decay <= 1.0:
            raise ValueError("decay must lie in (0.5, 1]: else the step does not satisfy eq. 11")

    def step_m(self, decision: int) -> float:
        """alpha_t, metres; `decision` counts from 0."""
        return float(self.first_m / (1.0 + decision / self.half_life) ** self.decay)


class CaoCoverage:
    """CAO on the coverage objective J_C (eq. 1).

    Parameters
    ----------
    measures_itself
        Work J_C out from the team's map and the teammates' positions; else it is what `tell` says.
    """

    def __init__(
        self,
        params: CaoParams,
        rng: np.random.Generator,
        schedule: StepSchedule | None = None,
        measures_itself: bool = False,
    ) -> None:
        self._cao = Cao(params, rng)
        self._schedule = schedule or StepSchedule(params.step_m)
        self._measures_itself = measures_itself
        self._decisions = 0

    def tell(self, observation: Observation) -> None:
        if not self._measures_itself:
            self._cao.tell(observation.position_enu_m, observation.objective)

    def ask(self, situation: Situation) -> Decision:
        step_m = self._schedule.step_m(self._decisions)
        self._decisions += 1
        here = situation.position_enu_m
        if self._measures_itself:
            places = [(mate.position_enu_m, situation.range_m) for mate in situation.teammates]
            known = situation.team_map
            self._cao.tell(here, coverage_objective(known, situation.area_cells, here, situation.range_m, places))
        end = self._cao.ask(here, lambda ends: situation.constraints.admissible(here, ends), step_m)
        if end is None:
            return Wait("no admissible perturbation")
        return Waypoint(end, f"local optimum of what was measured, step {step_m:.2f} m")
