"""A survey sails its strip in lines, then goes where the map is least certain, within what it can still sail."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.landmarks import LandmarkLayout, LandmarkMap, LandmarkParams
from vehicle_agent.domain.range_sensing import RangeSensor
from vehicle_agent.domain.relief import Relief
from vehicle_agent.planning.interface import Finished, Teammate, Waypoint
from vehicle_agent.planning.mapping.infill import most_telling_way
from vehicle_agent.planning.mapping.interface import HeightBand, MappingSituation
from vehicle_agent.planning.mapping.survey import Survey, SurveyParams, SurveyPlanner
from vehicle_agent.planning.mapping.survey_lines import Box, parallel_lines, points_along

AREA = Box(0.0, 0.0, 60.0, 60.0)


def length_m(way: FloatArray) -> float:
    return float(np.hypot(*np.diff(way, axis=0).T).sum())


@pytest.mark.parametrize("start", [(0.0, 0.0), (60.0, 0.0), (0.0, 60.0), (60.0, 60.0)])
def test_lines_begin_nearby_and_leave_no_wide_gap(start: tuple[float, float]) -> None:
    box = Box(10.0, 0.0, 40.0, 60.0)
    lines = parallel_lines(box, 7.0, 2.0, start)
    assert math.dist(lines[0], start) < 25.0
    assert lines[:, 0].min() > 10.0
    assert lines[:, 0].max() < 40.0
    offsets = np.unique(lines[:, 0].round(6))
    assert np.diff(offsets).max() <= 7.0
    assert np.diff(offsets).max() == pytest.approx(np.diff(offsets).min())


def test_lanes_share_the_area() -> None:
    lanes = [AREA.lane(number, 3) for number in range(3)]
    assert sum(lane.area_m2 for lane in lanes) == pytest.approx(AREA.area_m2)
    assert lanes[0].east_m == pytest.approx(lanes[1].west_m)


def test_points_along_a_way_are_a_step_apart() -> None:
    way = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 5.0]])
    points = points_along(way, 2.5)
    assert len(points) == 6
    assert points[0].tolist() == [2.5, 0.0]
    assert points[-1].tolist() == [10.0, 5.0]


def test_the_most_telling_way_goes_where_uncertainty_is_and_keeps_its_length() -> None:
    axis = np.arange(2.0, 60.0, 4.0)
    nodes = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
    variance = np.where(nodes[:, 0] > 40.0, 1.0, 0.001)
    near = np.exp(-0.5 * ((nodes[:, None] - nodes) ** 2).sum(axis=2) / 4.0**2)
    covariance = near * np.sqrt(variance[:, None] * variance)
    way = most_telling_way(5.0, 5.0, nodes, covariance.copy(), np.ones(len(nodes)), 0.01, 120.0, 2.0)
    assert way[0].tolist() == [5.0, 5.0]
    assert length_m(way) <= 120.0 + 1e-6
    assert np.mean(way[1:, 0] > 40.0) > 0.6
    assert len(np.unique(way, axis=0)) == len(way), "no place twice"


def test_nothing_in_reach_makes_no_way() -> None:
    nodes = np.array([[50.0, 50.0]])
    way = most_telling_way(0.0, 0.0, nodes, np.eye(1), np.ones(1), 0.1, 10.0, 1.0)
    assert way.tolist() == [[0.0, 0.0]]


def test_two_vehicles_share_what_is_uncertain() -> None:
    """Each keeps to its side of a cut with equal uncertainty on both, whatever the other does."""
    rng = np.random.default_rng(2)
    places = rng.uniform(0.0, 60.0, (80, 2))
    relief = Relief(places, -10.0 + rng.normal(0.0, 0.5, 80), np.full(80, 0.05))
    params = SurveyParams(way_m=500.0, nodes=225, foreign_weight=0.0)
    here = ((10.0, 30.0), (50.0, 30.0))
    ways = [
        Survey(AREA, index, 2, params).next_way(here[index], relief, 0.05, 200.0, np.array([here[1 - index]]))
        for index in range(2)
    ]
    assert ways[0][1:, 0].max() <= ways[1][1:, 0].min() + 4.0


def landmarks() -> LandmarkMap:
    params = LandmarkParams(accurate_sd_m=0.2, best_sd_m=0.01, lowest_m=-40.0, highest_m=0.0)
    return LandmarkMap(LandmarkLayout.at_cells(Grid(0.0, 0.0, 4.0, 15, 15)), params, 2, 0)


def situation(known: LandmarkMap, place: tuple[float, float], teammates: tuple[Teammate, ...] = ()) -> MappingSituation:
    return MappingSituation(
        0, (*place, -3.0), known, RangeSensor(40.0, 0.01, 2.0), HeightBand(1.0, -3.0, -3.0), 12.0,
        lambda ends: np.asarray((ends[:, :2] > 0).all(axis=1) & (ends[:, :2] < 60).all(axis=1)), teammates,
    )  # fmt: skip


def test_the_planner_sails_legs_within_reach_until_its_way_is_used_up() -> None:
    known, place = landmarks(), (5.0, 5.0)
    planner = SurveyPlanner(Survey(AREA, 0, 1, SurveyParams(way_m=900.0, nodes=100, part_m=40.0)))
    reasons, sailed_m = set(), 0.0
    for _ in range(1_000):
        decision = planner.ask(situation(known, place))
        if isinstance(decision, Finished):
            break
        assert isinstance(decision, Waypoint)
        end = decision.position_enu_m
        leg_m = math.dist(place, end[:2])
        assert leg_m <= 12.0 + 1e-6
        assert end[2] == -3.0
        sailed_m += leg_m
        reasons.add(decision.why.split()[0])
        place = (end[0], end[1])
        cell = int(place[0] // 4) * 15 + int(place[1] // 4)
        known.observe(np.array([cell]), np.array([-10.0 + 0.05 * place[0]]), np.array([0.1]))
    else:
        pytest.fail("never finished")
    assert reasons == {"line,", "uncertain"}
    assert 0.8 * 900.0 < sailed_m < 900.0 + 60.0


def test_a_planner_without_any_sounding_gives_up_after_its_lines() -> None:
    planner = SurveyPlanner(Survey(AREA, 0, 1, SurveyParams(way_m=5_000.0, nodes=100)))
    place: tuple[float, float] = (5.0, 5.0)
    for _ in range(1_000):
        decision = planner.ask(situation(landmarks(), place))
        if isinstance(decision, Finished):
            return
        assert isinstance(decision, Waypoint)
        place = (decision.position_enu_m[0], decision.position_enu_m[1])
    pytest.fail("never finished")


@pytest.mark.parametrize("bad", [{"way_m": 0.0}, {"lines_share": 0.0}, {"nodes": 2}, {"part_m": -1.0}])
def test_impossible_surveys_are_refused(bad: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="must be"):
        SurveyParams(**{"way_m": 100.0, **bad})  # type: ignore[arg-type]
