"""Maps of landmarks merge: in any order, any number of times, whatever is said, to the same estimates."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.domain.landmark_layout import LandmarkLayout, LandmarkParams
from vehicle_agent.domain.landmark_records import SEAL, LandmarkRecords
from vehicle_agent.domain.landmarks import LandmarkMap

LANDMARKS, VEHICLES = 5, 3
LAYOUT = LandmarkLayout(np.column_stack((np.arange(LANDMARKS, dtype=float), np.zeros(LANDMARKS))), 1.0)
PARAMS = LandmarkParams(accurate_sd_m=0.1, best_sd_m=0.03, lowest_m=-5.0, highest_m=5.0, attempts_limit=12)

Measurement = tuple[int, int, float, float]
MEASUREMENTS = st.lists(
    st.tuples(
        st.integers(0, VEHICLES - 1),
        st.integers(0, LANDMARKS - 1),
        st.floats(-8.0, 8.0) | st.just(np.nan) | st.just(np.inf),
        st.floats(1e-6, 10.0) | st.just(np.nan) | st.just(0.0),
    ),
    max_size=60,
)


def measured(said: list[Measurement]) -> list[LandmarkMap]:
    team = [LandmarkMap(LAYOUT, PARAMS, VEHICLES, index) for index in range(VEHICLES)]
    for vehicle, landmark, height_m, sd_m in said:
        team[vehicle].observe(np.array([landmark]), np.array([height_m]), np.array([sd_m]))
    return team


def is_sound(known: LandmarkMap) -> bool:
    estimated = ~np.isnan(known.heights_m)
    return bool(
        np.all(np.abs(known.heights_m[estimated]) <= 5.0 + 2 * PARAMS.quantum_m)
        and np.all(np.isfinite(known.sd_m) == estimated)
        and np.all(known.sd_m[estimated] > 0.0)
        and np.all(known.sd_m[known.accurate] <= PARAMS.accurate_sd_m)
    )


@given(MEASUREMENTS, st.permutations(range(VEHICLES)), st.data())
def test_order_and_repetition_of_packets_do_not_matter(
    said: list[Measurement], order: list[int], data: st.DataObject
) -> None:
    team = measured(said)
    packets = [team[index].records() for index in range(VEHICLES)]
    straight, shuffled = (LandmarkMap(LAYOUT, PARAMS, VEHICLES, 0) for _ in range(2))
    straight.merge(LandmarkRecords.joined(*packets))
    for index in order:
        packet = packets[index]
        rows = np.array(data.draw(st.permutations(range(len(packet)))), dtype=np.int64)
        for part in (rows[: len(rows) // 2], rows, rows[len(rows) // 2 :]):
            shuffled.merge(packet[part])
    for _ in range(2):  # each may have sealed on its own what it could sum up first
        straight.merge(shuffled.records())
        shuffled.merge(straight.records())
    assert straight == shuffled
    assert np.array_equal(straight.heights_m, shuffled.heights_m, equal_nan=True)
    assert np.array_equal(straight.sd_m, shuffled.sd_m)
    assert np.array_equal(straight.accurate, shuffled.accurate)


@given(MEASUREMENTS)
def test_maps_are_equal_after_repair(said: list[Measurement]) -> None:
    team = measured(said)
    for _ in range(3):
        for known in team:
            for other in team:
                known.merge(other.records())
    for known in team:
        assert is_sound(known)
        assert known == team[0]
        assert known.digest(2) == team[0].digest(2)
        assert np.array_equal(known.heights_m, team[0].heights_m, equal_nan=True)
        assert np.array_equal(known.attempts, team[0].attempts)
    assert all(len(team[0].merge(known.records()).changed) == 0 for known in team)


INTEGERS = st.integers(-(2**31), 2**31) | st.integers(-3, 40) | st.integers(0, 4_000)


@given(MEASUREMENTS, st.lists(st.tuples(INTEGERS, INTEGERS, INTEGERS, INTEGERS, INTEGERS), max_size=30))
def test_no_records_poison_a_map(said: list[Measurement], hostile: list[tuple[int, ...]]) -> None:
    known = measured(said)[0]
    accurate = known.accurate.copy()
    records = LandmarkRecords(*np.array(hostile, dtype=np.int64).reshape(-1, 5).T.copy())
    merged = known.merge(records)
    assert is_sound(known)
    assert np.all(known.accurate[accurate])
    assert sum(merged.dropped.values()) <= len(records)
    seals = records.contributors[np.isin(records.landmarks, merged.sealed)]
    assert len(merged.sealed) == 0 or SEAL in seals or np.all(known.information[merged.sealed] >= 1.0)
