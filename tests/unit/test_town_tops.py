"""A town from above: records of voxels become the highest known surface of each column."""

from __future__ import annotations

import numpy as np

from ground_station.team_map import TeamMap
from ground_station.town_tops import cells_told, tops_of
from tests.fakes.town_missions import town_plan
from vehicle_agent.domain.elevation import UNOBSERVED_STAMP_MS
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.voxel_evidence import VoxelEvidence
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.wire.voxel_blob import pack_voxels

GRID = VoxelGrid(0.0, 0.0, -1.0, 1.0, 3, 2, 5)
FLAT = Grid(0.0, 0.0, 1.0, 3, 2)


def told(hits: dict[tuple[int, int, int], int], crossed: list[tuple[int, int, int]] | None = None) -> VoxelEvidence:
    stamps = {GRID.flat_of(voxel): stamp for voxel, stamp in hits.items()}
    stamps |= {GRID.flat_of(voxel): UNOBSERVED_STAMP_MS for voxel in crossed or []}
    order = np.array(sorted(stamps), dtype=np.int64)
    is_hit = np.array([stamps[flat] != UNOBSERVED_STAMP_MS for flat in order.tolist()])
    return VoxelEvidence(
        order,
        is_hit.astype(np.uint8),
        (~is_hit).astype(np.uint8),
        np.array([stamps[flat] for flat in order.tolist()], dtype=np.int64),
    )


def test_a_column_shows_its_highest_surface_from_when_any_of_it_was_seen() -> None:
    cells = tops_of(told({(0, 1, 0): 50, (0, 1, 3): 70, (2, 0, 2): 60}, crossed=[(0, 1, 4), (1, 0, 2)]), GRID)
    assert cells.cell_indices.tolist() == [1, 4]
    assert cells.elevations_dm.tolist() == [30, 20]
    assert cells.stamps_ms.tolist() == [50, 60]
    assert len(tops_of(told({}, crossed=[(1, 1, 1)]), GRID)) == 0


def test_later_records_raise_the_roofs_but_not_the_coverage() -> None:
    area = np.ones((3, 2), dtype=np.bool_)
    empty = TeamMap.empty(FLAT, area, 2, keeps_highest=True)
    low, high = tops_of(told({(0, 0, 0): 10}), GRID), tops_of(told({(0, 0, 2): 90, (0, 0, 4): 95}), GRID)
    for records in ([(0, low), (1, high)], [(1, high), (0, low)]):
        team_map = empty
        for record in records:
            before = team_map
            team_map = team_map.joined_with([record])
            assert team_map.version == before.version + 1
        assert team_map.elevation.elevation_dm[0, 0] == 40
        assert team_map.elevation.first_stamp_ms[0, 0] == 10
        assert team_map.observed_cells == 1
        assert team_map.first_seen_cells == (1.0, 0.0)


def test_blobs_are_read_as_the_mission_s_kind_of_map() -> None:
    plan = town_plan()
    assert plan.voxel_grid is not None
    cells = cells_told(plan, pack_voxels(told({(0, 0, 2): 5})))
    assert cells is not None
    assert len(cells) == 1
    assert cells_told(plan, b"rubbish") is None
