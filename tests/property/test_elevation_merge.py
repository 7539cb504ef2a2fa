"""Maps merge: in any order, however often, through any radio, everybody ends with the same map."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.domain.elevation import CellObservations, ElevationMap
from vehicle_agent.domain.grid import Grid
from vehicle_agent.wire.cells import pack_cells, unpack_cells

GRID = Grid(0.0, 0.0, 10.0, 5, 4)
Delta = tuple[int, CellObservations]


@st.composite
def observations(draw: st.DrawFn, cells: int = GRID.cells) -> CellObservations:
    """Few stamps and elevations, so that ties and contradictions are common."""
    indices = sorted(draw(st.sets(st.integers(0, cells - 1), max_size=8)))
    count = len(indices)
    elevations = draw(st.lists(st.integers(-3, 3), min_size=count, max_size=count))
    stamps = draw(st.lists(st.integers(0, 3), min_size=count, max_size=count))
    return CellObservations(
        np.array(indices, dtype=np.int64), np.array(elevations, dtype=np.int32), np.array(stamps, dtype=np.int64)
    )


DELTAS = st.lists(st.tuples(st.sampled_from([0, 1, 2, 63]), observations()), max_size=6)


def map_of(deltas: list[Delta]) -> ElevationMap:
    terrain = ElevationMap(GRID)
    for observer, cells in deltas:
        terrain.observe(observer, cells)
    return terrain


def merged(*maps: ElevationMap) -> ElevationMap:
    result = maps[0].copy()
    for other in maps[1:]:
        result.merge(other)
    return result


MAPS = DELTAS.map(map_of)


@given(MAPS, MAPS)
def test_merge_commutes(a: ElevationMap, b: ElevationMap) -> None:
    assert merged(a, b) == merged(b, a)


@given(MAPS, MAPS, MAPS)
def test_merge_associates(a: ElevationMap, b: ElevationMap, c: ElevationMap) -> None:
    assert merged(merged(a, b), c) == merged(a, merged(b, c))


@given(MAPS, MAPS)
def test_merge_is_idempotent_and_has_the_empty_map_as_its_unit(a: ElevationMap, b: ElevationMap) -> None:
    assert merged(a, a) == a
    both = merged(a, b)
    assert merged(both, a) == merged(both, b) == both
    assert merged(a, ElevationMap(GRID)) == merged(ElevationMap(GRID), a) == a


@given(MAPS, MAPS)
def test_merge_leaves_the_other_map_alone(a: ElevationMap, b: ElevationMap) -> None:
    before = b.copy()
    joined = merged(a, b)
    joined.observe(5, map_cells(b))
    assert b == before


@given(DELTAS, DELTAS)
def test_merging_maps_is_observing_their_deltas(first: list[Delta], second: list[Delta]) -> None:
    assert merged(map_of(first), map_of(second)) == map_of(first + second)


@given(DELTAS, st.data())
def test_any_radio_plus_repair_ends_in_equal_maps(deltas: list[Delta], data: st.DataObject) -> None:
    packets = [(observer, pack_cells(cells)) for observer, cells in deltas]
    everything = map_of(deltas)
    for _ in range(2):
        order = data.draw(st.lists(st.integers(0, max(len(packets) - 1, 0)), max_size=12)) if packets else []
        receiver = ElevationMap(GRID)
        for number in order:
            feed(receiver, packets[number])
        lost = data.draw(st.permutations(sorted(set(range(len(packets))) - set(order))))
        for number in lost:
            feed(receiver, packets[number])
        assert receiver == everything


@given(DELTAS, st.sampled_from([0, 1, 2, 63]), observations())
def test_observe_returns_exactly_what_changed(deltas: list[Delta], observer: int, cells: CellObservations) -> None:
    terrain = map_of(deltas)
    before = terrain.copy()
    changed = terrain.observe(observer, cells)
    differs = (
        (before.first_stamp_ms != terrain.first_stamp_ms)
        | (before.observers != terrain.observers)
        | (before.elevation_dm != terrain.elevation_dm)
    )
    assert changed.cell_indices.tolist() == np.flatnonzero(differs.ravel()).tolist()
    given_cells = dict(
        zip(cells.cell_indices.tolist(), zip(cells.elevations_dm, cells.stamps_ms, strict=True), strict=True)
    )
    for index, elevation, stamp in zip(changed.cell_indices, changed.elevations_dm, changed.stamps_ms, strict=True):
        assert given_cells[int(index)] == (elevation, stamp)
    # What changed is enough: who hears only that gets the same map.
    hearer = before.copy()
    hearer.observe(observer, changed)
    assert hearer == terrain


@given(DELTAS)
def test_shares_of_first_observers_sum_to_the_observed_cells(deltas: list[Delta]) -> None:
    terrain = map_of(deltas)
    total = sum(terrain.first_observer_share(observer) for observer in range(64))  # Renzaglia eq. 6
    assert abs(total - terrain.observed.sum()) < 1e-9


@given(DELTAS)
def test_the_first_observer_is_the_first(deltas: list[Delta]) -> None:
    terrain = map_of(deltas)
    for cell in range(GRID.cells):
        looks = [
            (int(cells.stamps_ms[place]), observer, int(cells.elevations_dm[place]))
            for observer, cells in deltas
            for place in np.flatnonzero(cells.cell_indices == cell)
        ]
        if not looks:
            assert not terrain.observed.ravel()[cell]
            continue
        first = min(stamp for stamp, _, _ in looks)
        assert terrain.first_stamp_ms.ravel()[cell] == first
        bits = sum({1 << observer for stamp, observer, _ in looks if stamp == first})
        assert int(terrain.observers.ravel()[cell]) == bits
        assert terrain.elevation_dm.ravel()[cell] == min(height for stamp, _, height in looks if stamp == first)


def feed(terrain: ElevationMap, packet: tuple[int, bytes]) -> None:
    cells = unpack_cells(packet[1], GRID.cells)
    assert cells is not None
    terrain.observe(packet[0], cells)


def map_cells(terrain: ElevationMap) -> CellObservations:
    indices = np.flatnonzero(terrain.observed.ravel())
    return CellObservations(indices, terrain.elevation_dm.ravel()[indices], terrain.first_stamp_ms.ravel()[indices] - 1)
