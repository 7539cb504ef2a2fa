"""Our planner of map missions: it keeps the constraints, works off a small area, divides it, and ends."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.landmark_layout import LandmarkLayout, LandmarkParams
from vehicle_agent.domain.landmarks import LandmarkMap
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.range_sensing import RangeSensor
from vehicle_agent.planning.interface import Finished, Teammate, Wait, Waypoint
from vehicle_agent.planning.mapping.default import ViewpointPlanner
from vehicle_agent.planning.mapping.interface import HeightBand, MappingSituation
from vehicle_agent.planning.mapping.work_sites import ViewpointParams

SENSOR = RangeSensor(range_m=30.0, noise_share=0.05)
PARAMS = LandmarkParams(accurate_sd_m=1.0, best_sd_m=0.25, lowest_m=-50.0, highest_m=50.0)
BAND = HeightBand(clearance_m=5.0, highest_m=60.0)
LAYOUT = LandmarkLayout.at_cells(Grid(0.0, 0.0, 5.0, 16, 16))
REACH_M, RADIO_M = 6.0, 40.0


def ground_m(places: FloatArray) -> FloatArray:
    """A hill of 20 m in the middle of 80 m x 80 m."""
    heights: FloatArray = 20.0 * np.exp(-((places[:, :2] - 40.0) ** 2).sum(axis=1) / 400.0)
    return heights


@dataclass
class Vehicle:
    """A vehicle with a perfect eye: it sees every landmark in range."""

    index: int
    position: Point
    vehicles: int
    known: LandmarkMap = field(init=False)
    planner: ViewpointPlanner = field(init=False)
    goal: Point | None = None

    def __post_init__(self) -> None:
        self.known = LandmarkMap(LAYOUT, PARAMS, self.vehicles, self.index)
        self.planner = ViewpointPlanner(self.vehicles)

    def sense(self) -> None:
        heights = ground_m(LAYOUT.positions_en_m)
        places = np.column_stack((LAYOUT.positions_en_m, heights))
        ranges = np.linalg.norm(places - np.array(self.position), axis=1)
        seen = np.flatnonzero((ranges < SENSOR.range_m) & (heights < self.position[2]))
        self.known.observe(seen, heights[seen], 0.05 * ranges[seen] ** 2 / (self.position[2] - heights[seen]))

    def ask(self, others: list[Vehicle]) -> Waypoint | Wait | Finished:
        def admissible(ends: FloatArray) -> BoolArray:
            good: BoolArray = (ends[:, 2] >= ground_m(ends) + BAND.clearance_m) & (ends[:, 2] <= BAND.highest_m)
            good &= ((ends[:, :2] >= 0.0) & (ends[:, :2] <= 80.0)).all(axis=1)
            if others:
                away = [np.linalg.norm(ends - np.array(other.position), axis=1) for other in others]
                good &= np.min(away, axis=0) <= RADIO_M
            return good

        teammates = tuple(Teammate(other.index, other.position, other.goal) for other in others)
        return self.planner.ask(
            MappingSituation(
                self.index, self.position, self.known, SENSOR, BAND, REACH_M, admissible, teammates, RADIO_M
            )
        )

    def move(self, others: list[Vehicle]) -> bool:
        """One step; False when nothing is left to do."""
        decision = self.ask(others)
        if isinstance(decision, Waypoint):
            end = decision.position_enu_m
            assert math.dist(end, self.position) <= REACH_M + 1e-9
            assert end[2] >= ground_m(np.array([end]))[0] + BAND.clearance_m - 1e-9
            assert decision.why
            self.position, self.goal = end, decision.goal_enu_m
        return not isinstance(decision, Finished)


def team_of(vehicles: int) -> list[Vehicle]:
    return [Vehicle(index, (5.0 + 10.0 * index, 5.0, 12.0), vehicles) for index in range(vehicles)]


def steps_of(vehicles: int) -> int:
    """Steps until a team that tells each other everything has nothing left to do."""
    team = team_of(vehicles)
    for step in range(400):
        for vehicle in team:
            vehicle.sense()
        for vehicle in team:
            for other in team:
                vehicle.known.merge(other.known.records())
        if not sum(vehicle.move([other for other in team if other is not vehicle]) for vehicle in team):
            assert all(vehicle.known.accurate.all() for vehicle in team)
            return step
    raise AssertionError("not done in 400 steps")


def test_a_team_makes_every_landmark_accurate_and_sooner_than_one_vehicle() -> None:
    alone, together = steps_of(1), steps_of(3)
    assert together < 0.9 * alone


def test_decisions_need_no_dice() -> None:
    first, second = team_of(1)[0], team_of(1)[0]
    for vehicle in (first, second):
        for _ in range(10):
            vehicle.sense()
            vehicle.move([])
    assert first.position == second.position


def test_it_waits_where_no_leg_is_admissible() -> None:
    vehicle = team_of(1)[0]
    vehicle.position = (5.0, 5.0, 500.0)  # far above its ceiling
    assert isinstance(vehicle.ask([]), Wait)


def test_it_is_finished_when_all_is_accurate_or_given_up() -> None:
    vehicle = team_of(1)[0]
    ids = np.arange(len(LAYOUT))
    for _ in range(PARAMS.attempts_limit):
        vehicle.known.observe(ids[:10], np.full(10, np.nan), np.full(10, np.nan))
    vehicle.known.observe(ids[10:], np.zeros(len(ids) - 10), np.full(len(ids) - 10, 0.5))
    assert isinstance(vehicle.ask([]), Finished)


def test_what_teammates_called_done_is_left_until_nothing_else_is_open() -> None:
    west = LAYOUT.positions_en_m[:, 0] < 40.0
    vehicle = team_of(1)[0]
    vehicle.position = (38.0, 40.0, 30.0)
    for said_done, eastwards in ((west, True), (~west, False), (np.ones_like(west), None)):
        planner = ViewpointPlanner(1)
        decision = planner.ask(
            MappingSituation(
                0, vehicle.position, vehicle.known, SENSOR, BAND, REACH_M, lambda ends: np.ones(len(ends), np.bool_),
                said_done=said_done,
            )
        )  # fmt: skip
        assert isinstance(decision, Waypoint)
        assert decision.goal_enu_m is not None
        assert eastwards is None or (decision.goal_enu_m[0] > 40.0) == eastwards


def test_a_follower_keeps_to_its_leader() -> None:
    leader, follower = team_of(2)
    leader.position, leader.goal = (60.0, 60.0, 20.0), (70.0, 70.0, 20.0)
    follower.position = (35.0, 45.0, 30.0)
    follower.sense()
    decision = follower.ask([leader])
    assert isinstance(decision, Waypoint)
    assert decision.goal_enu_m is not None
    assert math.dist(decision.goal_enu_m, leader.goal) <= ViewpointParams().company * RADIO_M


def test_a_vehicle_yields_to_a_mate_that_follows_somebody_unheard() -> None:
    """Else both pull the mate between them, and all three stand."""
    together_m = ViewpointParams().company * RADIO_M
    for index, yields in ((1, True), (0, False)):
        vehicle, mate = Vehicle(index, (70.0, 70.0, 20.0), 3), Vehicle(2, (50.0, 45.0, 20.0), 3)
        mate.goal = (10.0, 10.0, 20.0)
        vehicle.sense()
        goals = []
        for _ in range(20):
            decision = vehicle.ask([mate])
            assert isinstance(decision, Waypoint)
            assert decision.goal_enu_m is not None
            goals.append(decision.goal_enu_m)
        assert math.dist(goals[0], mate.goal) > together_m
        assert any(math.dist(goal, mate.goal) <= together_m for goal in goals) == yields


def test_beside_its_way_a_vehicle_leaves_to_a_teammate_what_is_nearer_to_that() -> None:
    alone, accompanied = team_of(1)[0], team_of(2)[0]
    ends = []
    for vehicle, others in ((alone, []), (accompanied, [Vehicle(1, (32.0, 10.0, 20.0), 2)])):
        vehicle.position = (40.0, 10.0, 20.0)
        vehicle.sense()
        decision = vehicle.ask(others)
        assert isinstance(decision, Waypoint)
        ends.append(decision.position_enu_m)
    assert ends[1][0] > ends[0][0] + 1.0  # farther from the teammate in the west


def test_a_vehicle_stays_where_work_goes_on_and_leaves_where_nothing_gets_done() -> None:
    """However slowly: one landmark a step takes longer than it has patience with a site that stays as it is."""
    places = LAYOUT.positions_en_m
    west, east = (np.flatnonzero((np.abs(places - corner) < 15.0).all(axis=1)) for corner in ((0.0, 0.0), (80.0, 80.0)))
    for goes_on in (True, False):
        vehicle = team_of(1)[0]
        others = np.setdiff1d(np.arange(len(LAYOUT)), np.concatenate((west, east)))
        vehicle.known.observe(others, np.zeros(len(others)), np.full(len(others), 0.5))
        left = []
        for landmark in west:
            decision = vehicle.ask([])
            assert isinstance(decision, Waypoint)
            assert decision.goal_enu_m is not None
            left.append(decision.goal_enu_m[0] > 40.0)
            if not left[-1]:
                vehicle.position = decision.goal_enu_m
            if goes_on:
                vehicle.known.observe(np.array([landmark]), np.zeros(1), np.full(1, 0.5))
        assert any(left) != goes_on
