"""A vehicle thinks of what comes next while it flies, and decides only when it has thought."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.fakes.hill_missions import hill_plan
from vehicle_agent.behaviour.guide import Surroundings
from vehicle_agent.behaviour.navigator import Navigator
from vehicle_agent.domain.elevation import CellObservations, ElevationMap
from vehicle_agent.domain.frames import Point
from vehicle_agent.planning.interface import Decision, Observation, Situation, Waypoint
from vehicle_agent.ports import VehicleState

PLAN = hill_plan()
HERE: Point = (50.0, 50.0, 60.0)
THERE: Point = (90.0, 50.0, 60.0)


class Thinker:
    """Sends a vehicle to and fro; takes three turns to think of where."""

    def __init__(self) -> None:
        self.thought_of: list[Point] = []
        self.asked = 0

    def tell(self, observation: Observation) -> None:
        pass

    def think(self, situation: Situation, place_enu_m: Point) -> bool:
        self.thought_of.append(place_enu_m)
        return len(self.thought_of) >= 3

    def ask(self, situation: Situation) -> Decision:
        self.asked += 1
        self.thought_of.clear()
        return Waypoint(THERE if self.asked % 2 else HERE, "to and fro")


def around(place: Point, now_s: float, east_m_s: float = 0.0) -> Surroundings:
    state = VehicleState(stamp_ms=round(1000 * now_s), position_enu_m=place, velocity_enu_m_s=(east_m_s, 0.0, 0.0))
    return Surroundings(now_s, state, 1, (), (), (), 0.0)


def navigator(planner: Thinker) -> Navigator:
    ground = ElevationMap(PLAN.grid)
    cells = np.arange(PLAN.grid.cells - PLAN.grid.rows)
    ground.observe(0, CellObservations(cells, np.zeros(len(cells), dtype=np.int32), 1_000 + cells))
    return Navigator(PLAN, 0, planner, ground)


def test_a_vehicle_that_rests_decides_once_it_has_thought() -> None:
    planner = Thinker()
    guide = navigator(planner)
    targets = [guide.work(around(HERE, float(turn))) for turn in range(4)]
    assert targets[:2] == [None, None]
    assert targets[2] == THERE
    assert planner.asked == 1


def test_a_vehicle_thinks_of_its_next_leg_before_the_present_one_ends() -> None:
    planner = Thinker()
    guide = navigator(planner)
    for turn in range(3):
        guide.work(around(HERE, float(turn)))
    assert guide.leg is not None
    far, near, ending = ((THERE[0] - away_m, *HERE[1:]) for away_m in (35.0, 15.0, 4.0))
    guide.work(around(far, 4.0, 5.0))
    assert planner.thought_of == []
    guide.work(around(near, 5.0, 5.0))
    guide.work(around(near, 5.2, 5.0))
    assert planner.thought_of == [THERE, THERE]
    assert planner.asked == 1
    guide.work(around(ending, 7.0, 4.0))
    assert planner.asked == 2


def test_what_is_ordered_meanwhile_does_not_wait_for_thoughts() -> None:
    planner = Thinker()
    guide = navigator(planner)
    guide.work(around(HERE, 0.0))
    sector = np.zeros(PLAN.grid.shape, dtype=bool)
    sector[5:8, 5:8] = True
    guide.limit(PLAN.area_cells, PLAN.area_cells, sector)
    assert guide.work(replace(around(HERE, 1.0), map_version=2)) == THERE
