"""Voxel maps merge: in any order, however often, everybody ends with the same map."""

from __future__ import annotations

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from vehicle_agent.domain.voxel_evidence import VoxelEvidence
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.domain.voxels import VoxelMap

GRID = VoxelGrid(-3.0, -2.0, 0.0, 1.0, 9, 10, 11)  # no edge is a whole number of blocks
Scan = tuple[int, tuple[float, float, float], list[tuple[float, float, float]], int]

coordinates = st.tuples(st.floats(-5, 8), st.floats(-4, 10), st.floats(-2, 13))
scans = st.lists(
    st.tuples(
        st.sampled_from([0, 1, 63]),
        st.tuples(st.floats(-2.9, 5.9), st.floats(-1.9, 7.9), st.floats(0.1, 10.9)),
        st.lists(coordinates, max_size=5),
        st.integers(0, 3),
    ),
    max_size=8,
)


def map_of(taken: list[Scan]) -> VoxelMap:
    voxels = VoxelMap(GRID)
    for contributor, sensor, ends, stamp_ms in taken:
        voxels.insert(contributor, sensor, np.array(ends).reshape(-1, 3), 6.0, stamp_ms)
    return voxels


def merged(*maps: VoxelMap) -> VoxelMap:
    result = VoxelMap(GRID)
    for other in maps:
        result.merge(other)
    return result


MAPS = scans.map(map_of)


@settings(deadline=None)
@given(MAPS, MAPS, MAPS)
def test_merge_commutes_associates_and_repeats(a: VoxelMap, b: VoxelMap, c: VoxelMap) -> None:
    assert merged(a, b) == merged(b, a)
    assert merged(merged(a, b), c) == merged(a, merged(b, c))
    assert merged(a, a) == a
    assert merged(a, b, a, b) == merged(a, b)
    assert merged(a, VoxelMap(GRID)) == a == a.copy()


@settings(deadline=None)
@given(scans, st.data())
def test_told_deltas_in_any_order_and_number_make_the_teller_s_map(taken: list[Scan], data: st.DataObject) -> None:
    tellers = {contributor: VoxelMap(GRID) for contributor in (0, 1, 63)}
    deltas: list[tuple[int, VoxelEvidence]] = []
    for contributor, sensor, ends, stamp_ms in taken:
        tellers[contributor].insert(contributor, sensor, np.array(ends).reshape(-1, 3), 6.0, stamp_ms)
        deltas.append((contributor, tellers[contributor].take_untold(contributor)))
    expected = merged(*tellers.values())
    hearer = VoxelMap(GRID)
    order = data.draw(st.permutations(deltas))
    for contributor, told in [
        *order,
        *data.draw(st.lists(st.sampled_from(deltas), max_size=5) if deltas else st.just([])),
    ]:
        hearer.observe(contributor, told)
    assert hearer == expected
    assert all(len(teller.take_untold(contributor)) == 0 for contributor, teller in tellers.items())


@settings(deadline=None)
@given(scans)
def test_the_first_to_hit_a_voxel_is_its_observer(taken: list[Scan]) -> None:
    looks: dict[int, list[tuple[int, int]]] = {}
    for contributor, sensor, ends, stamp_ms in taken:
        for end in ends:
            voxel = GRID.voxel_of(end)
            away_m = float(np.linalg.norm(np.array(end) - np.array(sensor)))
            assume(abs(away_m - 6.0) > 1e-6)
            if GRID.contains(voxel) and away_m < 6.0:
                looks.setdefault(GRID.flat_of(voxel), []).append((stamp_ms, contributor))
    surface, stamps, observers = map_of(taken).surface()
    assert surface.tolist() == sorted(looks)
    for voxel, stamp, bits in zip(surface.tolist(), stamps.tolist(), observers.tolist(), strict=True):
        first = min(looks[voxel])[0]
        assert stamp == first
        assert bits == sum({1 << contributor for when, contributor in looks[voxel] if when == first})
