"""What listeners need is told first: what lies where they go, what they were not told, and what is done at a glance."""

from __future__ import annotations

import numpy as np
import pytest

from vehicle_agent.domain.done_sketch import SKETCH_BYTES, DoneSketch
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.landmark_layout import LandmarkLayout, LandmarkParams
from vehicle_agent.domain.landmark_records import SEAL, LandmarkRecords
from vehicle_agent.domain.landmarks import LandmarkMap
from vehicle_agent.planning.interface import Teammate
from vehicle_agent.planning.mapping.need_exchange import NeedExchange, Packet

LAYOUT = LandmarkLayout.at_cells(Grid(0.0, 0.0, 1.0, 200, 1))
"""Landmarks at 0.5, 1.5, ... 199.5 m east."""
PARAMS = LandmarkParams(accurate_sd_m=0.1, best_sd_m=0.05, lowest_m=-9.0, highest_m=9.0)
HERE = (0.5, 0.5, 5.0)


def measured(accurate: list[int], inaccurate: list[int], own_index: int = 0) -> LandmarkMap:
    known = LandmarkMap(LAYOUT, PARAMS, 3, own_index)
    ids = np.array(accurate + inaccurate, dtype=np.int64)
    known.observe(ids, np.ones(len(ids)), np.array([0.1] * len(accurate) + [0.2] * len(inaccurate)))
    return known


def exchange_of(accurate: list[int], inaccurate: list[int], capacity: int = 1) -> NeedExchange:
    return NeedExchange(measured(accurate, inaccurate), capacity, near_m=3.0)


def mate_at(east_m: float, index: int = 1, goal_m: float | None = None) -> Teammate:
    return Teammate(index, (east_m, 0.5, 5.0), None if goal_m is None else (goal_m, 0.5, 5.0))


def seal_of(landmark: int) -> Packet:
    return Packet(measured([landmark], [], 1).seals(np.array([landmark])))


def test_what_lies_where_a_listener_is_or_goes_is_told_first() -> None:
    for mate, first in ((mate_at(10.5), 10), (mate_at(50.5), 50), (mate_at(50.5, goal_m=90.5), 90)):
        assert exchange_of([10, 90], [50] if first == 50 else []).packet([mate]).records.landmarks.tolist() == [first]


def test_an_accurate_landmark_comes_before_one_that_is_not() -> None:
    told = exchange_of([11], [10]).packet([mate_at(10.5)]).records
    assert (told.landmarks.tolist(), told.contributors.tolist()) == ([11], [SEAL])


def test_what_was_told_waits_for_what_was_not_and_is_told_again_later() -> None:
    exchange = exchange_of([10, 12], [])
    packets = [exchange.packet([mate_at(10.5)]).records.landmarks.tolist() for _ in range(4)]
    assert packets[:2] == [[10], [12]]
    assert [10] in packets[2:]


def test_what_a_listener_told_itself_is_not_told_to_it() -> None:
    exchange = exchange_of([10, 30], [])
    exchange.take({1: seal_of(10)}, HERE)
    assert exchange.packet([mate_at(10.5, index=1)]).records.landmarks.tolist() == [30]
    assert exchange.packet([mate_at(10.5, index=2)]).records.landmarks.tolist() == [10]


def test_with_nobody_near_packets_go_on_saying_what_there_is() -> None:
    assert exchange_of([10, 30], [], capacity=2).packet([]).records.landmarks.tolist() == [10, 30]


def test_with_nobody_near_packets_come_to_everything() -> None:
    exchange = exchange_of(list(range(40)), [], capacity=10)
    told = {landmark for _ in range(4) for landmark in exchange.packet([]).records.landmarks.tolist()}
    assert told == set(range(40))


def test_less_room_than_capacity_is_kept_to() -> None:
    exchange = exchange_of(list(range(20, 60)), [], capacity=10)
    packets = [exchange.packet([mate_at(40.5)], room) for room in (0, 1, 4)]
    assert [len(packet.records) + (packet.sketch is not None) for packet in packets] == [0, 1, 4]


def test_what_a_listener_seems_to_lack_is_told_again_least_told_first() -> None:
    exchange = exchange_of([10], [12])
    mate = mate_at(11.5)
    assert exchange.has_untold
    while exchange.has_untold:
        exchange.packet([mate])
    for _ in range(20):
        exchange.packet([mate])
    assert len(exchange.packet([mate]).records) == 0
    exchange.doubt(1, np.array([10, 12]))
    assert {exchange.packet([mate]).records.landmarks[0] for _ in range(3)} == {10, 12}


def test_what_a_listener_told_itself_may_be_doubted_too() -> None:
    exchange = exchange_of([10], [])
    exchange.take({1: seal_of(10)}, HERE)
    assert len(exchange.packet([mate_at(10.5)]).records) == 0
    exchange.doubt(1, np.array([10]))
    assert exchange.packet([mate_at(10.5)]).records.landmarks.tolist() == [10]


def test_who_begins_anew_is_told_everything_again() -> None:
    exchange = exchange_of([10], [12], capacity=2)
    first = exchange.packet([mate_at(10.5)]).records.landmarks.tolist()
    for _ in range(30):
        exchange.packet([mate_at(10.5)])
    exchange.forget(1)
    assert exchange.packet([mate_at(10.5)]).records.landmarks.tolist() == first


def test_a_sketch_takes_the_room_of_one_landmark() -> None:
    exchange = exchange_of(list(range(20, 60)), [], capacity=3)
    packet = exchange.packet([mate_at(40.5)])
    assert packet.sketch is not None
    assert len(packet.records) == 2
    assert exchange_of(list(range(20, 60)), [], capacity=1).packet([mate_at(40.5)]).sketch is None


def test_a_listener_learns_of_a_sketch_what_is_done_but_no_heights() -> None:
    speaker, listener = exchange_of(list(range(20, 60)), [], capacity=3), exchange_of([], [], capacity=3)
    packet = speaker.packet([mate_at(40.5)])
    listener.take({0: packet}, HERE)
    assert listener.said_done.sum() >= 30
    assert set(np.flatnonzero(listener.said_done)) <= set(range(20, 60))


def test_no_more_is_taken_in_than_there_is_room_for_and_sketches_count() -> None:
    listener = NeedExchange(measured([], [], 2), 2, near_m=3.0)
    many, sketch = exchange_of(list(range(8)), [], capacity=4).packet([mate_at(3.5, 2)]), DoneSketch(4, b"\xff" * 6)
    taken = listener.take({0: many, 1: Packet(LandmarkRecords.empty(), sketch)}, (3.5, 0.5, 5.0))
    assert len(taken) + 1 <= 2
    assert listener.said_done.any()


def test_what_cannot_be_true_reaches_the_map_to_be_counted_and_harms_nothing() -> None:
    known = measured([], [])
    listener = NeedExchange(known, 1, near_m=3.0)
    strange = LandmarkRecords(*(np.array([value, value]) for value in (500, SEAL, 0, 0, 2_000)))
    merged = known.merge(listener.take({1: Packet(strange, DoneSketch(10**6, bytes(SKETCH_BYTES)))}, HERE))
    assert merged.dropped == {"unknown landmark": 2}
    assert not listener.said_done.any()


@pytest.mark.parametrize(("capacity", "near_m", "name"), [(0, 1.0, "capacity"), (3, 0.0, "near_m")])
def test_impossible_params_are_refused(capacity: int, near_m: float, name: str) -> None:
    with pytest.raises(ValueError, match=name):
        NeedExchange(measured([], []), capacity, near_m)
