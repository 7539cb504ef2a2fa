"""The shared voxel map: what a scan decides is told once, in pieces that fit, and all end with the same states."""

from __future__ import annotations

import numpy as np
import pytest

from sim_bridge.town_world import Town
from vehicle_agent.behaviour.map_exchange import MapExchange, encode_record
from vehicle_agent.behaviour.voxel_share import VoxelShare
from vehicle_agent.domain.elevation import CellObservations
from vehicle_agent.domain.range_image import RangeImage
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.domain.voxels import OCCUPIED
from vehicle_agent.ports import SensorScan
from vehicle_agent.wire.messages import DeltaRecord

GRID = VoxelGrid(0.0, 0.0, -1.0, 1.0, 16, 14, 9)
TEAM = ("ada", "bob")
AREA = np.ones((16, 14), dtype=np.bool_)
RANGE_M = 9.0


def town() -> Town:
    solid = np.zeros(GRID.shape, dtype=np.bool_)
    solid[:, :, 0] = True
    solid[6:10, 5:9, 1:5] = True
    return Town(GRID, solid)


def share(index: int) -> VoxelShare:
    return VoxelShare(GRID, index, RANGE_M, ceiling=7)


def exchange(name: str, journal: tuple[bytes, ...] = ()) -> MapExchange:
    return MapExchange(share(TEAM.index(name)), TEAM, TEAM.index(name), 7, journal)


def scan(place: tuple[float, float, float], stamp_ms: int) -> SensorScan:
    return SensorScan(town().scan(place, RANGE_M, stamp_ms))


def records_of(held: MapExchange) -> list[DeltaRecord]:
    records = []
    while (record := held.next_record()) is not None:
        records.append(record)
    return records


def test_scans_show_only_what_is_there_and_a_second_look_tells_nothing_new() -> None:
    ada = exchange("ada")
    assert ada.observe(scan((3.5, 3.5, 6.5), 1_000)) > 0
    seen = ada.team_map.observed
    assert seen.sum() > 30
    assert not (seen & ~town().solid).any()
    assert len(records_of(ada)) == 1
    ada.observe(scan((3.5, 3.5, 6.5), 2_000))
    assert records_of(ada) == []


def test_told_in_small_pieces_and_any_order_the_states_are_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vehicle_agent.behaviour.map_exchange.MAX_RECORD_BYTES", 200)
    ada, bob = exchange("ada"), exchange("bob")
    records = []
    for number, place in enumerate([(3.5, 3.5, 6.5), (12.5, 3.5, 6.5), (12.5, 11.5, 3.5), (3.2, 11.1, 5.9)]):
        ada.observe(scan(place, 1_000 * number))
        records += records_of(ada)
    assert len(records) > 3
    assert max(len(record.cells) for record in records) <= 200
    assert bob.receive([*reversed(records), *records]) == len(records)
    mine, theirs = ada.shared, bob.shared
    assert isinstance(mine, VoxelShare)
    assert isinstance(theirs, VoxelShare)
    assert np.array_equal(mine.team_map.states(), theirs.team_map.states())
    assert theirs.first_seen(0, AREA) == pytest.approx(mine.first_seen(0, AREA))
    assert bob.refused == 0


def test_a_restarted_agent_resumes_from_its_journal_and_repeats_nothing() -> None:
    ada = exchange("ada")
    ada.observe(scan((3.5, 3.5, 6.5), 1_000))
    journal = tuple(encode_record(record) for record in records_of(ada))
    again = exchange("ada", journal)
    assert np.array_equal(again.team_map.observed, ada.team_map.observed)
    again.observe(scan((3.5, 3.5, 6.5), 3_000))
    assert records_of(again) == []


def test_what_is_known_grows_to_one_as_frontiers_vanish() -> None:
    mine = share(0)
    fractions = [mine.known_fraction(AREA)]
    assert fractions == [0.0]
    for east in range(2, 15, 3):
        for north in range(2, 13, 3):
            for up in (2, 5, 7):
                if not town().solid[east, north, up]:
                    mine.take_scan(scan((east + 0.5, north + 0.5, up - 0.5), 1_000))
        fractions.append(mine.known_fraction(AREA))
    assert fractions[-1] > 0.9 > fractions[1]
    assert mine.highest_up_m() == 7.0
    assert (mine.picture.states == OCCUPIED).sum() > 200


def test_scans_without_sense_are_counted_and_change_nothing() -> None:
    ada = exchange("ada")
    good = scan((3.5, 3.5, 6.5), 1_000).seen
    assert isinstance(good, RangeImage)
    nothing = np.empty(0, dtype=np.int64)
    for bad in (
        RangeImage((float("nan"), 0.0, 0.0), good.ranges_m, good.returned, 1),
        RangeImage((1e12, 0.0, 0.0), good.ranges_m, good.returned, 1),
        RangeImage(good.sensor_enu_m, good.ranges_m[:5], good.returned[:5], 1),
        RangeImage(good.sensor_enu_m, good.ranges_m, good.returned, -5),
        CellObservations(nothing, nothing.astype(np.int32), nothing),
    ):
        assert ada.observe(SensorScan(bad)) == 0
    assert ada.refused == 5
    assert not ada.team_map.observed.any()
    assert ada.receive([DeltaRecord("bob", 1, 0, b"rubbish"), DeltaRecord("eve", 1, 0, b"")]) == 0
    assert ada.refused == 7
