"""Landmarks: weighted least squares, sticky accuracy, the limit of attempts, and what is not believed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.landmark_layout import LandmarkLayout, LandmarkParams
from vehicle_agent.domain.landmark_records import ACCURATE, SEAL, LandmarkRecords
from vehicle_agent.domain.landmarks import LandmarkMap

PARAMS = LandmarkParams(accurate_sd_m=0.1, best_sd_m=0.05, lowest_m=-20.0, highest_m=5.0, attempts_limit=30)
LAYOUT = LandmarkLayout.at_cells(Grid(0.0, 0.0, 2.0, 4, 3))


def new_map(own_index: int = 0, vehicles: int = 3) -> LandmarkMap:
    return LandmarkMap(LAYOUT, PARAMS, vehicles, own_index)


def measure(known: LandmarkMap, landmark: int, height_m: float, sd_m: float) -> list[int]:
    return known.observe(np.array([landmark]), np.array([height_m]), np.array([sd_m])).tolist()


def record(landmark: int, contributor: int, attempts: int, height: int, information: int) -> LandmarkRecords:
    return LandmarkRecords(*(np.array([value]) for value in (landmark, contributor, attempts, height, information)))


def test_estimates_are_weighted_by_inverse_variance() -> None:
    known = new_map()
    for height_m, sd_m in ((2.0, 0.4), (3.0, 0.2)):
        measure(known, 5, height_m, sd_m)
    assert known.heights_m[5] == pytest.approx((2.0 / 0.16 + 3.0 / 0.04) / (1 / 0.16 + 1 / 0.04), abs=PARAMS.quantum_m)
    assert known.sd_m[5] == pytest.approx(math.sqrt(1.0 / (1 / 0.16 + 1 / 0.04)), rel=0.01)
    assert np.isnan(known.heights_m[4])
    assert np.isinf(known.sd_m[4])


def test_accuracy_is_reached_once_and_for_ever() -> None:
    known = new_map()
    assert [measure(known, 3, 1.0, 0.2) for _ in range(4)] == [[], [], [], [3]]
    estimate = known.heights_m[3]
    assert measure(known, 3, -15.0, 0.05) == []
    known.merge(record(3, 1, 5, -100, 800))
    assert known.accurate[3]
    assert known.heights_m[3] == estimate


def test_two_vehicles_together_make_a_landmark_accurate() -> None:
    mine, theirs = new_map(0), new_map(1)
    for known in (mine, theirs):
        for _ in range(3):
            measure(known, 7, 1.0, 0.2)
    assert not mine.accurate[7]
    merged = mine.merge(theirs.own_records(np.array([7])))
    assert merged.sealed.tolist() == [7]
    assert mine.accurate[7]


def test_a_landmark_that_resists_is_given_up() -> None:
    known = new_map()
    for _ in range(PARAMS.attempts_limit):
        assert known.open[2]
        measure(known, 2, math.nan, math.nan)
    assert known.given_up[2]
    assert not known.open[2]
    before = known.records()
    measure(known, 2, 1.0, 0.05)
    assert np.array_equal(known.records().attempts, before.attempts)


@pytest.mark.parametrize(
    ("impossible", "reason"),
    [
        (record(12, 1, 1, 0, 10), "unknown landmark"),
        (record(-1, 1, 1, 0, 10), "unknown landmark"),
        (record(0, 3, 1, 0, 10), "unknown contributor"),
        (record(0, -2, 1, 0, 10), "unknown contributor"),
        (record(0, 1, 0, 0, 10), "impossible attempts"),
        (record(0, 1, 31, 0, 10), "impossible attempts"),
        (record(0, SEAL, 4, 0, ACCURATE), "impossible attempts"),
        (record(0, 1, 1, 600, 10), "impossible height"),
        (record(0, SEAL, 0, -(2**23) + 1, ACCURATE), "impossible height"),
        (record(0, 1, 1, 0, 4 * ACCURATE + 1), "too confident"),
        (record(0, 1, 30, 0, 2**23 - 1), "too confident"),
        (record(0, 1, 1, 0, -1), "too confident"),
        (record(0, SEAL, 0, 0, ACCURATE - 1), "too confident"),
        (record(0, SEAL, 0, 0, 2**23 - 1), "too confident"),
    ],
)
def test_what_cannot_be_true_is_dropped_and_counted(impossible: LandmarkRecords, reason: str) -> None:
    known = new_map()
    measure(known, 0, 1.0, 0.2)
    before = known.heights_m.copy()
    merged = known.merge(impossible)
    assert merged.dropped == {reason: 1}
    assert len(merged.changed) == 0
    assert np.array_equal(known.heights_m, before, equal_nan=True)


def test_own_measurements_are_never_better_than_the_sensor() -> None:
    known = new_map()
    measure(known, 1, 1.0, 1e-9)
    assert known.sd_m[1] >= PARAMS.best_sd_m * 0.99
    with pytest.raises(ValueError, match="distinct"):
        known.observe(np.array([1, 1]), np.zeros(2), np.ones(2))
    with pytest.raises(ValueError, match="distinct"):
        known.observe(np.array([12]), np.zeros(1), np.ones(1))


@pytest.mark.parametrize(
    ("height_m", "sd_m"), [(math.nan, 0.2), (math.inf, 0.2), (1.0, math.nan), (1.0, math.inf), (1.0, -0.2)]
)
def test_a_measurement_that_is_none_poisons_nothing(height_m: float, sd_m: float) -> None:
    known = new_map()
    measure(known, 1, 2.0, 0.2)
    height, deviation = known.heights_m[1], known.sd_m[1]
    assert measure(known, 1, height_m, sd_m) == []
    assert (known.heights_m[1], known.sd_m[1], known.attempts[1]) == (height, deviation, 2)
    measure(known, 5, 1.0, 0.0)  # infinite weight
    assert known.sd_m[5] >= PARAMS.best_sd_m * 0.99


def test_what_records_would_add_is_known_before_they_are_merged() -> None:
    known, other = new_map(0), new_map(1)
    measure(known, 2, 1.0, 0.05)
    for landmark, sd_m in ((1, 0.05), (2, 0.05), (3, 0.2)):
        measure(other, landmark, 1.0, sd_m)
    gains = dict(zip(other.records().landmarks.tolist(), known.gain_of(other.records()).tolist(), strict=True))
    assert gains[2] == 0.0
    assert gains[3] == pytest.approx(0.25)
    assert known.gain_of(other.seals(np.array([1]))).tolist() == [2.0]
    assert known.gain_of(record(500, 1, 1, 0, 10)).tolist() == known.gain_of(record(0, 7, 1, 0, 10)).tolist() == [0.0]
    known.merge(other.records())
    assert not known.gain_of(other.records()).any()


def test_a_restarted_vehicle_continues_what_its_team_remembers() -> None:
    before, teammate = new_map(0), new_map(1)
    for _ in range(3):
        measure(before, 4, 2.0, 0.2)
    teammate.merge(before.records())
    after = new_map(0)
    after.merge(teammate.records())
    assert after == before
    assert measure(after, 4, 2.0, 0.2) == [4]
    assert after.attempts[4] == 4


def test_digests_differ_only_where_maps_do() -> None:
    mine, theirs = new_map(0), new_map(1)
    assert mine.digest(4) == theirs.digest(4)
    measure(mine, 11, 0.0, 0.2)
    differing = [block for block in range(4) if mine.digest(4)[block] != theirs.digest(4)[block]]
    assert differing == [3]
    theirs.merge(mine.records(mine.block_of(3, 4)))
    assert mine.digest(4) == theirs.digest(4)
    assert mine == theirs


@pytest.mark.parametrize(
    "wrong",
    [
        {"accurate_sd_m": 0.0},
        {"best_sd_m": math.nan},
        {"lowest_m": 5.0},
        {"attempts_limit": 0},
        {"accurate_sd_m": 1e-9},
    ],
)
def test_impossible_params_are_refused(wrong: dict[str, float]) -> None:
    good = {"accurate_sd_m": 0.1, "best_sd_m": 0.05, "lowest_m": -20.0, "highest_m": 5.0, "attempts_limit": 30}
    with pytest.raises(ValueError, match=r"_m|attempts"):
        LandmarkParams(**{**good, **wrong})  # type: ignore[arg-type]


def test_layouts_and_teams_are_checked() -> None:
    with pytest.raises(ValueError, match="at least one landmark"):
        LandmarkLayout(np.empty((0, 2)), 1.0)
    with pytest.raises(ValueError, match="finite"):
        LandmarkLayout(np.array([[0.0, math.inf]]), 1.0)
    with pytest.raises(ValueError, match="team of 3"):
        new_map(own_index=3)
