"""Streams of map records: numbering, splitting, resuming, refusing, repairing."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from vehicle_agent.behaviour import map_exchange
from vehicle_agent.behaviour.elevation_share import ElevationShare
from vehicle_agent.behaviour.map_exchange import MapExchange, encode_record
from vehicle_agent.domain.elevation import CellObservations
from vehicle_agent.domain.grid import Grid
from vehicle_agent.ports import SensorScan
from vehicle_agent.wire.cells import pack_cells, unpack_cells
from vehicle_agent.wire.messages import DeltaRecord, Digest, StreamHeld

GRID = Grid(0.0, 0.0, 10.0, 20, 20)
TEAM = ("ada", "bob", "cyd")


def seen(indices: list[int] | np.ndarray, stamp_ms: int = 1_000, elevation_dm: int = 50) -> CellObservations:
    count = len(indices)
    return CellObservations(
        np.array(indices, dtype=np.int64),
        np.full(count, elevation_dm, dtype=np.int32),
        np.full(count, stamp_ms, dtype=np.int64),
    )


def exchange(name: str = "ada", boot_id: int = 7, journal: tuple[bytes, ...] = (), grid: Grid = GRID) -> MapExchange:
    return MapExchange(ElevationShare(grid, TEAM.index(name)), TEAM, TEAM.index(name), boot_id, journal)


def digest_of(held: MapExchange, sender: str) -> Digest:
    return Digest(sender=sender, boot_id=1, sequence=0, stamp_ms=0, streams=held.digest())


def said(held: MapExchange, *batches: list[int]) -> list[DeltaRecord]:
    records = []
    for number, indices in enumerate(batches):
        held.observe(SensorScan(seen(indices, 1_000 + number)))
        record = held.next_record()
        assert record is not None
        records.append(record)
    return records


def test_records_are_numbered_without_gaps_and_hold_only_what_is_new() -> None:
    ada = exchange()
    records = said(ada, [1, 2, 3], [2, 3, 4])
    assert [record.delta_sequence for record in records] == [0, 1]
    cells = unpack_cells(records[1].cells, GRID.cells)
    assert cells is not None
    assert cells.cell_indices.tolist() == [4]
    assert ada.next_record() is None
    assert ada.observe(SensorScan(seen([1, 2], 9_000))) == 0
    assert ada.next_record() is None


def test_several_scans_become_one_record_with_the_earliest_of_each_cell() -> None:
    ada = exchange()
    ada.observe(SensorScan(seen([5, 6], 3_000, 30)))
    ada.observe(SensorScan(seen([6, 7], 2_000, 20)))
    record = ada.next_record()
    assert record is not None
    cells = unpack_cells(record.cells, GRID.cells)
    assert cells is not None
    assert cells.cell_indices.tolist() == [5, 6, 7]
    assert cells.stamps_ms.tolist() == [3_000, 2_000, 2_000]
    assert cells.elevations_dm.tolist() == [30, 20, 20]


def test_a_scan_too_large_for_one_record_is_split_and_nothing_is_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    grid = Grid(0.0, 0.0, 1.0, 400, 400)
    rng = np.random.default_rng(0)
    indices = np.flatnonzero(rng.random(grid.cells) < 0.5)
    noisy = CellObservations(
        indices, rng.integers(0, 30_000, len(indices)).astype(np.int32), np.full(len(indices), 5_000, dtype=np.int64)
    )
    ada, bob = exchange(grid=grid), exchange("bob", grid=grid)
    ada.observe(SensorScan(noisy))
    count = 0
    while (record := ada.next_record()) is not None:
        assert len(record.cells) <= map_exchange.MAX_RECORD_BYTES
        encoded = encode_record(record)
        bob.receive([msgspec.msgpack.decode(encoded, type=DeltaRecord)])
        count += 1
    assert count > 10
    assert bob.team_map == ada.team_map


def test_an_impossible_scan_is_counted_and_changes_nothing() -> None:
    ada = exchange()
    for impossible in (seen([3, 3]), seen([5, 4]), seen([GRID.cells]), seen([-1])):
        assert ada.observe(SensorScan(impossible)) == 0
    assert ada.refused == 4
    assert not ada.team_map.observed.any()
    assert ada.next_record() is None


@pytest.mark.parametrize(
    ("stamp_ms", "elevation_dm"), [(-1, 0), (np.iinfo(np.int64).max, 0), (5, 250_001), (5, -(2**31)), (2**53 + 1, 0)]
)
def test_cells_of_which_nobody_could_be_told_are_left_out(stamp_ms: int, elevation_dm: int) -> None:
    ada = exchange()
    odd = CellObservations(
        np.array([1, 2]), np.array([50, elevation_dm], dtype=np.int32), np.array([5, stamp_ms], dtype=np.int64)
    )
    assert ada.observe(SensorScan(odd)) == 1
    assert ada.refused == 1
    record = ada.next_record()
    assert record is not None
    assert exchange("bob").receive([record]) == 1


def test_a_restarted_agent_resumes_its_stream_and_its_map() -> None:
    before = exchange(boot_id=7)
    records = said(before, [1, 2], [3, 4])
    after = exchange(boot_id=8, journal=tuple(map(encode_record, records)))
    assert after.team_map == before.team_map
    (next_record,) = said(after, [10])
    assert (next_record.stream_id, next_record.delta_sequence) == (7, 2)


def test_damaged_and_foreign_journal_records_are_left_out() -> None:
    (own,) = said(exchange("ada", 7), [1, 2])
    (foreign,) = said(exchange("bob", 9), [5])
    after = exchange(boot_id=8, journal=(b"", b"\xff\x00junk", encode_record(foreign), encode_record(own)))
    assert np.flatnonzero(after.team_map.observed.ravel()).tolist() == [1, 2]
    assert [held.origin for held in after.digest()] == ["ada"]


def test_a_journal_with_a_gap_is_not_continued_under_numbers_that_others_know() -> None:
    records = said(exchange(boot_id=7), [1], [2], [3])
    after = exchange(boot_id=8, journal=(encode_record(records[0]), encode_record(records[2])))
    (next_record,) = said(after, [10])
    assert (next_record.stream_id, next_record.delta_sequence) == (8, 0)
    others = exchange("bob")
    others.receive(records)
    after.receive(others.repair_for(digest_of(after, "ada"), ("ada", "bob"), 0.0))
    assert set(records) <= {r for stream in after._streams.values() for r in stream.records.values()}
    assert after.team_map.observed.ravel()[[1, 2, 3, 10]].all()


def test_an_agent_without_its_journal_gets_its_own_map_back() -> None:
    records = said(exchange("ada", 7), [1, 2], [3])
    bob = exchange("bob")
    bob.receive(records)
    reborn = exchange("ada", 8)
    reborn.receive(bob.repair_for(digest_of(reborn, "ada"), ("ada", "bob"), 0.0))
    assert reborn.team_map == bob.team_map


def test_duplicates_are_folded_once_and_counted_as_nothing_new() -> None:
    records = said(exchange("ada"), [1, 2], [3])
    bob = exchange("bob")
    assert bob.receive(records) == 2
    assert bob.receive(reversed(records)) == 0


def test_records_after_a_gap_count_only_when_it_is_mended() -> None:
    records = said(exchange("ada", 7), [1], [2], [3])
    bob = exchange("bob")
    bob.receive([records[0], records[2]])
    assert bob.digest() == (StreamHeld("ada", 7, 1),)
    assert bob.team_map.observed.ravel()[[1, 3]].all()
    bob.receive([records[1]])
    assert bob.digest() == (StreamHeld("ada", 7, 3),)


@pytest.mark.parametrize(
    "record",
    [
        DeltaRecord("eve", 1, 0, pack_cells(seen([1]))),
        DeltaRecord("ada", 1, 0, b"junk"),
        DeltaRecord("ada", 1, 0, pack_cells(seen([GRID.cells + 5]))),
    ],
)
def test_unknown_vehicles_and_impossible_cells_are_refused_and_counted(record: DeltaRecord) -> None:
    bob = exchange("bob")
    assert bob.receive([record]) == 0
    assert bob.refused == 1
    assert bob.digest() == ()
    assert not bob.team_map.observed.any()


def test_a_flood_of_streams_is_bounded() -> None:
    bob = exchange("bob")
    bob.receive(DeltaRecord("ada", number, 0, pack_cells(seen([1]))) for number in range(1_000))
    assert len(bob.digest()) == map_exchange.MAX_STREAMS
    assert bob.refused == 1_000 - map_exchange.MAX_STREAMS


def empty_digest(sender: str = "station") -> Digest:
    return Digest(sender=sender, boot_id=1, sequence=0, stamp_ms=0, streams=())


def origins(records: tuple[DeltaRecord, ...]) -> list[str]:
    return sorted(record.origin for record in records)


def test_each_living_vehicle_answers_for_its_own_stream() -> None:
    ada, bob, cyd = exchange("ada", 7), exchange("bob", 8), exchange("cyd", 9)
    everybody = [ada, bob, cyd]
    records = said(ada, [1], [2]) + said(bob, [4]) + said(cyd, [3])
    for vehicle, name in zip(everybody, TEAM, strict=True):
        vehicle.receive(records)
        assert set(origins(vehicle.repair_for(empty_digest(), TEAM, 0.0))) == {name}


def test_for_a_silent_vehicle_the_first_that_holds_more_answers() -> None:
    records = said(exchange("ada", 7), [1], [2])
    bob, cyd = exchange("bob", 8), exchange("cyd", 9)
    cyd.receive(records)  # bob never heard them
    living = ("bob", "cyd")
    assert bob.repair_for(empty_digest(), living, 0.0) == ()
    assert origins(cyd.repair_for(empty_digest(), living, 0.0)) == ["ada", "ada"]
    bob.receive(records)
    cyd.repair_for(digest_of(bob, "bob"), living, 10.0)
    assert cyd.repair_for(empty_digest(), living, 20.0) == ()
    assert origins(bob.repair_for(empty_digest(), living, 20.0)) == ["ada", "ada"]


def test_only_what_the_digest_lacks_is_sent() -> None:
    ada = exchange("ada", 7)
    said(ada, [1], [2])
    has_one = Digest(sender="station", boot_id=1, sequence=0, stamp_ms=0, streams=(StreamHeld("ada", 7, 1),))
    assert [r.delta_sequence for r in ada.repair_for(has_one, TEAM, 0.0)] == [1]


def test_what_a_teammate_has_just_repaired_is_not_sent_again() -> None:
    ada, bob = exchange("ada", 7), exchange("bob", 8)
    records = said(ada, [1])
    bob.receive(records, repaired_at_s=50.0)
    assert bob.repair_for(empty_digest(), ("bob",), 52.0) == ()
    assert len(bob.repair_for(empty_digest(), ("bob",), 53.5)) == 1


def test_records_after_a_gap_that_died_with_its_vehicle_are_passed_on() -> None:
    records = said(exchange("ada", 7), [1], [2], [3])
    bob, cyd = exchange("bob", 8), exchange("cyd", 9)
    cyd.receive([records[0], records[2]])
    bob.receive(cyd.repair_for(digest_of(bob, "bob"), ("bob", "cyd"), 0.0))
    assert bob.team_map == cyd.team_map
    assert cyd.repair_for(digest_of(bob, "bob"), ("bob", "cyd"), 30.0) == ()
    assert len(cyd.repair_for(digest_of(bob, "bob"), ("bob", "cyd"), 61.0)) == 1


def test_a_record_is_not_repeated_at_once() -> None:
    ada = exchange("ada", 7)
    said(ada, [1])
    assert len(ada.repair_for(empty_digest("bob"), TEAM, 100.0)) == 1
    assert ada.repair_for(empty_digest("bob"), TEAM, 101.0) == ()
    assert len(ada.repair_for(empty_digest("bob"), TEAM, 103.1)) == 1


def test_repairs_are_bounded_but_never_stuck(monkeypatch: pytest.MonkeyPatch) -> None:
    ada, bob = exchange("ada", 7), exchange("bob", 8)
    said(ada, *([n] for n in range(50)))
    monkeypatch.setattr(map_exchange, "MAX_REPAIR_BYTES", 300)
    rounds = 0
    while ada.team_map != bob.team_map:
        repair = ada.repair_for(digest_of(bob, "bob"), TEAM, 10.0 * rounds)
        assert repair
        assert len(repair) == 1 or sum(len(r.cells) + 16 for r in repair) <= 300
        bob.receive(repair)
        rounds += 1
    monkeypatch.setattr(map_exchange, "MAX_REPAIR_BYTES", 1)
    said(ada, [60])
    assert len(ada.repair_for(digest_of(bob, "bob"), TEAM, 1e4)) == 1
