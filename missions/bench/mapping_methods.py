"""The methods that the mapping bench compares, each as what moves a whole team by one step."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from missions.bench.mapping_kernels import try_out
from missions.bench.mapping_radio import Exchange, NeededExchange, PaperExchange
from missions.bench.mapping_run import Mover, Team, point, timed
from missions.bench.mapping_world import Setup, World
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.landmarks import LandmarkMap
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.planning.interface import Waypoint
from vehicle_agent.planning.mapping.cao_mapping import MappingCao, MappingCaoParams
from vehicle_agent.planning.mapping.default import ViewpointPlanner
from vehicle_agent.planning.mapping.exchange import ExchangeParams
from vehicle_agent.planning.mapping.interface import HeightBand, MappingSituation
from vehicle_agent.planning.mapping.objective import TERMS, Objective, ObjectiveParams, Outlook
from vehicle_agent.planning.mapping.osarses import Osarses

DEFAULT = "default"
CAO = "cao-faithful"
TRIALS = {"osarses-0": 0, "osarses-5": 5, "osarses-50": 50}
METHODS = (CAO, DEFAULT, *TRIALS)
CAO_NEARNESS, OSARSES_NEARNESS = 0.03, 0.7
"""K_2 as served each best, over K_1 for one vehicle: a linear fit climbs counts better than sums of distances."""
URGENT_WITHIN = 2.0 / 3.0
"""Of the visibility threshold: what lies so far from a listener is 1/e as urgent to tell it as what lies under it."""
ABLATION_TRIALS = 50
ABLATION = {f"ablation {terms}": terms for terms in TERMS}
"""Every step of the objective's making, climbed by osarses-50 as in the paper's table 1 and figure 2."""


def make_mover(method: str, vehicles: int, landmarks: int, setup: Setup, rng: np.random.Generator) -> Mover:
    """A method by its name in the rows, for a team of so many and so many landmarks."""
    if method == DEFAULT:
        return Fleet(vehicles, setup)
    terms = ABLATION.get(method, TERMS[-1])
    nearness = CAO_NEARNESS if method == CAO else OSARSES_NEARNESS
    objective = Objective(ObjectiveParams.suited(vehicles, landmarks, terms, nearness), vehicles)
    if method == CAO:
        return CaoServer(objective, MappingCao(MappingCaoParams(setup.reach_m), vehicles, rng))
    return OsarsesServer(objective, Osarses(TRIALS.get(method, ABLATION_TRIALS), setup.reach_m, rng))


def exchange_for(method: str, setup: Setup, world: World) -> Callable[[LandmarkMap], Exchange]:
    """How a method's vehicles tell each other of landmarks, given each one's map.

    Section 3.4, near duplicates being those nearer than half a spacing; the default tells what listeners need.
    """
    if method == DEFAULT:
        return lambda known: NeededExchange(known, setup.capacity, URGENT_WITHIN * setup.range_m)
    params = ExchangeParams(setup.capacity, setup.reach_m, 0.5 * world.layout.spacing_m)
    return lambda known: PaperExchange(known, params)


@dataclass(frozen=True, slots=True)
class _Picture:
    """What a server knows between two steps.

    Attributes
    ----------
    done
        (N,) bool, accurate or given up in anybody's map.
    near
        Ids of the landmarks of J2: those that are visible before the move and not done. Summed over what a candidate
        would see, as eq. 12 can be read too, the term is best where nothing is seen.
    far
        Ids of those of J3: once seen, now out of sight and still not done; if there are none, all out of sight.
    supposed
        (N, 3), where landmarks are supposed to be.
    """

    done: BoolArray
    near: IndexArray
    far: IndexArray
    supposed: FloatArray

    @classmethod
    def of(cls, team: Team) -> _Picture:
        done: BoolArray = team.accurate | np.any([known.given_up for known in team.maps], axis=0)
        visible = np.zeros(len(done), dtype=np.bool_)
        visible[np.concatenate(team.visible)] = True
        waiting = ~done & ~visible
        once_seen = waiting & team.ever_seen
        heights = np.array([known.heights_m for known in team.maps])
        known = ~np.isnan(heights)
        mean = np.where(known, heights, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
        return cls(
            done,
            np.flatnonzero(visible & ~done),
            np.flatnonzero(once_seen if once_seen.any() else waiting),
            np.ascontiguousarray(np.column_stack((team.world.layout.positions_en_m, mean))),
        )


class _Server:
    """Knows all that anybody knows, and says where everybody goes."""

    def __init__(self, objective: Objective) -> None:
        self.objective = objective

    def outlook(self, team: Team, picture: _Picture, positions: FloatArray, information: FloatArray) -> Outlook:
        """What moving there would bring."""
        world, setup = team.world, team.setup
        visible = np.zeros(team.vehicles, dtype=np.int64)
        sealed, near_sum, far_sum = try_out(
            world.elevation, world.shape, world.heights, setup.range_m, setup.accurate_sd_m / setup.noise_share,
            (setup.accurate_sd_m / setup.landmark_params.best_sd_m) ** 2, information, picture.done,
            np.ascontiguousarray(positions), picture.near, picture.far, picture.supposed, visible,
        )  # fmt: skip
        squared = setup.range_m**2
        return Outlook(sealed, visible, near_sum / squared, far_sum / squared)

    def present(self, team: Team, picture: _Picture) -> Outlook:
        """What the last step has brought."""
        nothing = np.full((team.vehicles, len(team.world.layout)), -np.inf)
        here = self.outlook(team, picture, team.positions, nothing)
        return Outlook(team.sealed_now, here.visible, here.near_sum, here.far_sum)


class OsarsesServer(_Server):
    """Algorithm 1 on a server."""

    def __init__(self, objective: Objective, search: Osarses) -> None:
        super().__init__(objective)
        self._search = search

    def move(self, team: Team) -> Sequence[float]:
        began_s = time.perf_counter()
        picture = _Picture.of(team)
        self.objective.record(team.sealed_by.copy(), self.present(team, picture))
        information = np.array([known.information for known in team.maps])
        if self.objective.switches()[2].sum() == 0.0:
            picture = replace(picture, far=picture.far[:0])  # spares the sum over what does not count
        team.positions = self._search.ask(
            team.positions,
            team.ends_allowed,
            team.teams_allowed,
            lambda positions: self.objective.value(self.outlook(team, picture, positions, information)),
        )
        return [timed(began_s)]


class CaoServer(_Server):
    """Algorithm 2 on a server.

    What was measured is weighed by the present switches: values under different switches are of different functions.
    """

    def __init__(self, objective: Objective, search: MappingCao) -> None:
        super().__init__(objective)
        self._search = search
        self._brought: deque[Outlook] = deque(maxlen=search.window)

    def move(self, team: Team) -> Sequence[float]:
        began_s = time.perf_counter()
        brought = self.present(team, _Picture.of(team))
        self._brought.append(brought)
        self._search.tell(team.positions, self.objective.record(team.sealed_by.copy(), brought))
        self._search.revalue([self.objective.value(outlook) for outlook in self._brought])
        team.positions = self._search.ask(team.positions, team.ends_allowed, team.teams_allowed)
        return [timed(began_s)]


class Fleet:
    """Every vehicle decides for itself, one after the other, by its own map and what it heard of its teammates."""

    def __init__(self, vehicles: int, setup: Setup) -> None:
        self._planners = [ViewpointPlanner(vehicles) for _ in range(vehicles)]
        self._band = HeightBand(setup.clearance_m, setup.ceiling_m)

    def move(self, team: Team) -> Sequence[float]:
        took = []
        for index in np.flatnonzero(team.present).tolist():
            situation = MappingSituation(
                index, point(team.positions[index]), team.maps[index], team.setup.sensor, self._band,
                team.setup.reach_m, lambda ends, index=index: team.move_allowed(index, ends),  # type: ignore[misc]
                team.teammates(team.heard[index]), team.setup.radio_range_m, said_done=team.said_done(index),
            )  # fmt: skip
            began_s = time.perf_counter()
            decision = self._planners[index].ask(situation)
            took.append(timed(began_s))
            if isinstance(decision, Waypoint):
                team.positions[index] = decision.position_enu_m
                team.goals[index] = decision.goal_enu_m
        return took
