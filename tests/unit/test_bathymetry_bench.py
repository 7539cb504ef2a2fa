"""What `missions bench bathymetry` measures: floors that a seed decides, equal time for all, rows that others read."""

from __future__ import annotations

import numpy as np

from missions.bench.bathymetry import SAMPLES, rows_of
from missions.bench.bathymetry_run import (
    STEP_M,
    STEPS,
    EchoSounder,
    Outcome,
    l2_error,
    survey_by_fleet,
    survey_by_lines,
)
from missions.terrain.sea_floor import SIDE_M, sea_floor
from vehicle_agent.planning.mapping.survey import SurveyParams

KEYS = {"map", "method", "samples", "seeds", "l2_error", "l2_error_sd", "time_s", "error_ratio"}
QUICK = SurveyParams(way_m=1_000.0, nodes=900, part_m=500.0, step_m=2.0, rounds=30)


def test_floors_follow_from_their_seed() -> None:
    assert np.array_equal(sea_floor("sharp", 3), sea_floor("sharp", 3))
    assert not np.array_equal(sea_floor("sharp", 3), sea_floor("sharp", 4))
    for name in ("sharp", "slope"):
        floor = sea_floor(name, 3)
        assert floor.shape == (200, 200)
        assert -26.0 < floor.min() < floor.max() < -3.5


def test_the_fleet_keeps_to_its_steps_and_the_usual_practice_to_the_same_time() -> None:
    fleet = survey_by_fleet("sharp", 5, QUICK)
    usual = survey_by_lines("sharp", 5, SAMPLES)
    assert fleet.samples == usual.samples == SAMPLES
    assert fleet.time_s <= STEPS * STEP_M
    assert usual.time_s <= 1.01 * STEPS * STEP_M
    half = len(fleet.places_en_m) // 2
    for track in (fleet.places_en_m[:half], fleet.places_en_m[half:]):
        assert np.hypot(*np.diff(track, axis=0).T).max() <= STEP_M + 1e-6
        assert track.min() >= 0.0
        assert track.max() <= SIDE_M
    assert 0.0 < fleet.l2_error < 2.0 * usual.l2_error


def test_who_knows_where_the_floor_is_rough_draws_a_better_map_than_the_usual_practice() -> None:
    informed = survey_by_fleet("sharp", 5, QUICK, informed=True)
    assert informed.samples == SAMPLES
    assert informed.time_s <= STEPS * STEP_M
    assert informed.l2_error < 0.9 * survey_by_lines("sharp", 5, SAMPLES).l2_error


def test_more_soundings_of_the_same_places_draw_a_better_map() -> None:
    floor = sea_floor("slope", 6)
    axis = np.arange(2.0, 100.0, 5.0)
    places = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
    errors = [l2_error(floor, EchoSounder(floor, np.random.default_rng(1)).sound(places[::every])) for every in (1, 4)]
    assert errors[0] < errors[1]


def test_rows_pair_each_error_with_the_fleets_on_the_same_floor() -> None:
    nowhere = np.empty((0, 2))
    outcomes = [
        Outcome("sharp", seed, method, samples, error, 900.0, nowhere)
        for seed, fleet, usual in ((1, 4.0, 8.0), (2, 3.0, 4.0))
        for method, samples, error in (("fleet", 1_000, fleet), ("lawnmower", 1_000, usual))
    ]
    rows = rows_of(outcomes)
    assert all(set(row) == KEYS for row in rows)
    assert [(row["method"], row["error_ratio"]) for row in rows] == [("fleet", 1.0), ("lawnmower", 0.625)]
