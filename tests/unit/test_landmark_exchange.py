"""The exchange of section 3.4: what is told, in which order, and how much."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.landmark_layout import LandmarkLayout, LandmarkParams
from vehicle_agent.domain.landmark_records import SEAL, LandmarkRecords
from vehicle_agent.domain.landmarks import LandmarkMap
from vehicle_agent.planning.mapping.exchange import ExchangeParams, LandmarkExchange

LAYOUT = LandmarkLayout.at_cells(Grid(0.0, 0.0, 1.0, 12, 1))
"""Landmarks at 0.5, 1.5, ... 11.5 m east."""
PARAMS = LandmarkParams(accurate_sd_m=0.1, best_sd_m=0.05, lowest_m=-9.0, highest_m=9.0)


def measured(accurate: list[int], inaccurate: list[int], own_index: int = 0) -> LandmarkMap:
    known = LandmarkMap(LAYOUT, PARAMS, 3, own_index)
    ids = np.array(accurate + inaccurate)
    known.observe(ids, np.ones(len(ids)), np.array([0.1] * len(accurate) + [0.3] * len(inaccurate)))
    return known


def exchange_of(accurate: list[int], inaccurate: list[int], params: ExchangeParams) -> LandmarkExchange:
    exchange = LandmarkExchange(measured(accurate, inaccurate), params)
    exchange.sensed(np.array(sorted(accurate + inaccurate)), np.array(accurate))
    return exchange


def told(records: LandmarkRecords) -> list[tuple[int, int]]:
    return list(zip(records.landmarks.tolist(), records.contributors.tolist(), strict=True))


def test_new_accurate_and_visible_inaccurate_landmarks_are_told() -> None:
    exchange = exchange_of([2, 3], [4, 5], ExchangeParams())
    assert sorted(told(exchange.packet((0.0, 0.0, 5.0), []))) == [(2, SEAL), (3, SEAL), (4, 0), (5, 0)]


def test_accurate_landmarks_are_told_when_they_are_new_only() -> None:
    exchange = exchange_of([2], [4], ExchangeParams())
    exchange.packet((0.0, 0.0, 5.0), [])
    exchange.sensed(np.array([2, 4]), np.array([], dtype=np.int64))
    assert told(exchange.packet((0.0, 0.0, 5.0), [])) == [(4, 0)]


def test_nearest_to_reachable_teammates_come_first_up_to_capacity() -> None:
    exchange = exchange_of([], [0, 1, 2, 3, 4, 5], ExchangeParams(capacity=2, travel_m=3.0))
    assert exchange.packet((3.0, 0.5, 5.0), [(7.5, 0.5, 2.0), (90.0, 0.5, 2.0)]).landmarks.tolist() == [5, 4]
    assert sorted(exchange.packet((3.0, 0.5, 5.0), [(-2.0, 0.5, 2.0), (8.0, 0.5, 2.0)]).landmarks) == [0, 5]


def test_a_teammate_out_of_reach_does_not_sort_while_another_is_reachable() -> None:
    exchange = exchange_of([], [0, 1, 2, 3, 4, 5], ExchangeParams(capacity=1, travel_m=3.0))
    near, far = (8.0, 0.5, 0.0), (-3.5, 0.5, 0.0)
    assert exchange.packet((3.0, 0.5, 5.0), [far, near]).landmarks.tolist() == [5]
    assert exchange.packet((3.0, 0.5, 5.0), [far]).landmarks.tolist() == [0]


def test_of_near_duplicates_one_is_told() -> None:
    exchange = exchange_of([], list(range(8)), ExchangeParams(near_m=2.5))
    assert exchange.packet((0.0, 0.5, 5.0), [(0.0, 0.5, 0.0)]).landmarks.tolist() == [0, 3, 6]


def test_a_receiver_takes_the_nearest_up_to_its_capacity() -> None:
    listener = LandmarkExchange(measured([], [], 2), ExchangeParams(capacity=3))
    packets = [measured([0, 11], [1], 0).records(), measured([10], [1, 2], 1).records()]
    taken = listener.sieve(packets, (0.0, 0.5, 5.0))
    assert set(taken.landmarks.tolist()) == {0, 1, 2}
    assert {(1, 0), (1, 1)} <= set(told(taken))


def test_unknown_landmarks_reach_the_map_to_be_counted() -> None:
    known = measured([], [])
    listener = LandmarkExchange(known, ExchangeParams(capacity=1))
    strange = LandmarkRecords(*(np.array([value, value]) for value in (500, 1, 1, 0, 10)))
    both = LandmarkRecords.joined(strange, measured([], [3], 1).records())
    merged = known.merge(listener.sieve([both], (0.0, 0.5, 5.0)))
    assert merged.dropped == {"unknown landmark": 2}
    assert merged.changed.tolist() == [3]


@pytest.mark.parametrize("wrong", [{"capacity": 0}, {"travel_m": -1.0}, {"near_m": math.nan}])
def test_impossible_params_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        ExchangeParams(**wrong)  # type: ignore[arg-type]
