"""The exchange of section 3.4: what is told, in which order, and how much."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.landmark_records import SEAL, LandmarkRecords
from vehicle_agent.domain.landmarks import LandmarkLayout, LandmarkMap, LandmarkParams
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


def test_what_found_no_room_is_told_later_if_wished() -> None:
    nothing = np.array([], dtype=np.int64)
    for keeps_backlog, later in ((True, [0, 1, 1]), (False, [])):
        exchange = exchange_of([0, 1], [], ExchangeParams(capacity=1, keeps_backlog=keeps_backlog))
        assert told(exchange.packet((0.0, 0.5, 5.0), [])) == [(0, SEAL)]
        exchange.sensed(nothing, nothing)
        packets = [exchange.packet((0.0, 0.5, 5.0), []).landmarks.tolist() for _ in range(4)]
        assert [landmark for packet in packets for landmark in packet] == later


def test_news_comes_first_if_wished() -> None:
    exchange = exchange_of([9], [0, 1, 2], ExchangeParams(capacity=2, keeps_backlog=True))
    assert told(exchange.packet((0.0, 0.5, 5.0), [])) == [(9, SEAL), (0, 0)]


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


def test_what_is_measured_most_and_not_told_goes_first_if_wished() -> None:
    known = measured([], [0, 1, 2])
    for landmark, looks in ((5, 4), (9, 2)):
        for _ in range(looks):
            known.observe(np.array([landmark]), np.ones(1), np.array([0.3]))
    exchange = LandmarkExchange(known, ExchangeParams(capacity=1, keeps_backlog=True))
    packets = [exchange.packet((0.0, 0.5, 5.0), []).landmarks.tolist() for _ in range(6)]
    assert packets == [[5], [9], [0], [1], [2], []]
    known.observe(np.array([1]), np.ones(1), np.array([0.3]))
    assert exchange.packet((0.0, 0.5, 5.0), []).landmarks.tolist() == [1]


def test_news_is_told_as_often_as_wished() -> None:
    exchange = exchange_of([3], [], ExchangeParams(keeps_backlog=True, tellings=3))
    assert [len(exchange.packet((0.0, 0.5, 5.0), [])) for _ in range(5)] == [1, 1, 1, 0, 0]


def test_a_receiver_takes_what_adds_most_if_wished() -> None:
    known = measured([4], [0], 2)
    listener = LandmarkExchange(known, ExchangeParams(capacity=2, keeps_backlog=True))
    packets = [measured([4, 11], [0], 0).records(), measured([], [1, 2], 1).records()]
    packets[1] = LandmarkRecords.joined(packets[1], measured([9], [], 1).records())
    taken = listener.sieve(packets, (0.0, 0.5, 5.0))
    assert {landmark for landmark, _ in told(taken)} == {9, 11}
    assert known.merge(taken).sealed.tolist() == [9, 11]


def test_equal_maps_come_of_packets_alone_even_where_seals_differ() -> None:
    """A seal of a landmark that is accurate already is worth little, but not nothing."""
    first, second = measured([3], [], 0), measured([], [3], 1)
    for _ in range(20):
        second.observe(np.array([3]), np.full(1, 2.0), np.array([0.3]))
    assert first.accurate[3]
    assert second.accurate[3]
    for known, other in ((first, second), (second, first)):
        listener = LandmarkExchange(known, ExchangeParams(capacity=2, keeps_backlog=True))
        known.merge(listener.sieve([other.records()], (0.0, 0.5, 5.0)))
    assert first == second


@pytest.mark.parametrize("wrong", [{"capacity": 0}, {"travel_m": -1.0}, {"near_m": math.nan}, {"tellings": 0}])
def test_impossible_params_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        ExchangeParams(**wrong)  # type: ignore[arg-type]
