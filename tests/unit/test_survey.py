"""A survey sails its strip in lines, then goes where the map is least certain, within what it can still sail."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial import KDTree

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.landmark_layout import LandmarkLayout, LandmarkParams
from vehicle_agent.domain.landmarks import LandmarkMap
from vehicle_agent.domain.range_sensing import RangeSensor
from vehicle_agent.planning.interface import Finished, Teammate, Waypoint
from vehicle_agent.planning.mapping.infill import left_untold, settled_track, telling_track
from vehicle_agent.planning.mapping.interface import HeightBand, MappingSituation
from vehicle_agent.planning.mapping.survey import Survey, SurveyParams, SurveyPlanner
from vehicle_agent.planning.mapping.survey_lines import Box, corners_of, parallel_lines, points_along

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


def nodes_every(step_m: float) -> FloatArray:
    axis = np.arange(0.5 * step_m, 60.0, step_m)
    return np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)


def test_corners_leave_no_place_of_a_track_far_aside() -> None:
    at = np.linspace(0.0, 6.0, 80)
    track = np.column_stack((5.0 * at, 6.0 * np.sin(at)))
    corners = corners_of(track, 0.5)
    assert 3 < len(corners) < 20
    assert corners[0].tolist() == track[0].tolist()
    assert corners[-1].tolist() == track[-1].tolist()
    legs = [points_along(corners[i : i + 2], 0.05) for i in range(len(corners) - 1)]
    assert np.min(np.hypot(*(track[:, None] - np.concatenate(legs)).transpose(2, 0, 1)), axis=1).max() < 0.6


def test_a_track_lies_close_on_rough_ground_and_keeps_its_length_and_its_steps() -> None:
    nodes = nodes_every(1.5)
    strengths = np.asarray(np.where(nodes[:, 0] > 30.0, 1.0, 0.1))
    track = telling_track(np.array([5.0, 5.0]), nodes, strengths, np.full(len(nodes), 1e3), 300.0, 2.0, 1.5, 100)
    assert track[0].tolist() == [5.0, 5.0]
    links_m = np.hypot(*np.diff(track, axis=0).T)
    assert links_m.max() <= 2.0 + 1e-9
    assert links_m.sum() <= 300.0 + 1e-6
    assert 0.0 <= track.min() <= track.max() <= 60.0
    away_m = np.asarray(KDTree(track).query(nodes)[0])
    # Where the roughness is ten times as strong, tracks would lie 10^0.8 times closer on unbounded ground.
    assert away_m[strengths == 1.0].mean() < 0.5 * away_m[strengths < 1.0].mean()


def test_a_track_leaves_out_what_was_sounded_already() -> None:
    nodes = nodes_every(2.0)
    away_m = np.where(nodes[:, 1] < 30.0, 0.5, 40.0)
    track = telling_track(np.array([30.0, 32.0]), nodes, np.ones(len(nodes)), away_m, 200.0, 2.0, 1.5, 50)
    assert np.mean(track[:, 1] > 28.0) > 0.95


def test_settling_makes_a_track_that_tells_more() -> None:
    nodes, start = nodes_every(1.5), np.array([1.0, 1.0])
    errors = []
    for rounds in (0, 150):
        track = telling_track(start, nodes, np.ones(len(nodes)), np.full(len(nodes), 1e3), 500.0, 2.0, 1.5, rounds)
        errors.append(np.mean(KDTree(track).query(nodes)[0] ** 1.5))
    assert errors[1] < 0.9 * errors[0]


def test_a_track_planned_before_is_kept_while_it_tells_as_much() -> None:
    survey = Survey(AREA, 0, 1, SurveyParams(way_m=900.0, nodes=900, step_m=2.0, rounds=60))
    sounded, rough = np.array([[2.0, 2.0]]), np.ones(900)
    away_m = np.asarray(KDTree(sounded).query(survey.nodes_en_m)[0])

    def untold(track: FloatArray) -> float:
        return left_untold(track, survey.nodes_en_m, rough, away_m, 1.5)

    fresh = survey.next_way((2.0, 2.0), rough, sounded, 500.0, [])
    good = settled_track(fresh, survey.nodes_en_m, rough, away_m, 2.0, 1.5, 300)
    kept = survey.next_way((2.0, 2.0), rough, sounded, 500.0, [], planned_en_m=good[1:])
    assert untold(kept) <= untold(fresh)
    assert np.hypot(*(kept[: len(good)] - good[: len(kept)]).T).mean() < 2.0
    idle = np.tile([[2.0, 2.0]], (250, 1))
    assert untold(survey.next_way((2.0, 2.0), rough, sounded, 500.0, [], planned_en_m=idle)) <= untold(fresh)


def test_nothing_in_reach_makes_no_track() -> None:
    track = telling_track(np.zeros(2), np.array([[50.0, 50.0]]), np.ones(1), np.full(1, 1e3), 10.0, 1.0, 1.5, 10)
    assert track.tolist() == [[0.0, 0.0]]


def test_two_vehicles_share_the_work() -> None:
    """Each keeps to its side of a cut with equal work on both; who is alone takes all."""
    params = SurveyParams(way_m=500.0, nodes=900, rounds=20)
    sounded = np.array([[10.0, 30.0], [50.0, 30.0]])
    ways = []
    for index in range(2):
        survey = Survey(AREA, index, 2, params)
        strengths = np.where(survey.nodes_en_m[:, 0] < 20.0, 1.0, 0.1)
        ways.append(survey.next_way((float(sounded[index, 0]), 30.0), strengths, sounded, 300.0, [1 - index]))
    assert ways[0].max(axis=0)[0] < 20.0
    # It begins far inside its teammate's share, and lets its way there count for nothing.
    assert np.median(ways[1][:, 0]) > 15.0
    alone = Survey(AREA, 0, 2, params).next_way((10.0, 30.0), np.ones(900), sounded, 400.0, [])
    assert np.ptp(alone[:, 0]) > 40.0


def test_a_track_keeps_inside() -> None:
    survey = Survey(AREA, 0, 1, SurveyParams(way_m=900.0, nodes=900, rounds=20, inside_m=5.0))
    track = survey.next_way((2.0, 2.0), np.ones(900), np.array([[2.0, 2.0]]), 800.0, [])
    assert track[0].tolist() == [2.0, 2.0]
    assert 5.0 <= track[1:].min() <= track[1:].max() <= 55.0


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
    planner = SurveyPlanner(Survey(AREA, 0, 1, SurveyParams(way_m=900.0, nodes=400, part_m=40.0, rounds=10)))
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
    assert reasons == {"line,", "rough"}
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
