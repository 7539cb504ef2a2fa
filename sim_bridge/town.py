"""Random towns as voxels: houses along streets, storeys that overhang, passages through houses, and bridges."""

from __future__ import annotations

import numpy as np

from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.mission.terrain import TownTerrain


def draw_town(grid: VoxelGrid, terrain: TownTerrain, rng: np.random.Generator) -> BoolArray:
    """Voxels that are solid: (columns, rows, layers) bool; the lowest layer is the ground.

    The south-western block is a square, so that vehicles can stand there.
    """
    solid: BoolArray = np.zeros(grid.shape, dtype=np.bool_)
    solid[:, :, 0] = True
    block = max(1, round(terrain.block_m / grid.voxel_m))
    for column in range(0, grid.columns, block):
        for row in range(0, grid.rows, block):
            draws = rng.random(3)
            empty = rng.random() < terrain.square_share or (column == 0 and row == 0)
            house = _house(grid, terrain, rng, column, row, block)
            if not empty:
                _build(solid, grid, terrain, rng, house, draws)
    return solid


def _house(
    grid: VoxelGrid, terrain: TownTerrain, rng: np.random.Generator, column: int, row: int, block: int
) -> tuple[int, int, int, int, int]:
    """West, south, east, north and height of a block's building in voxels."""
    margins = np.rint(0.5 * rng.uniform(*terrain.street_m, 4) / grid.voxel_m).astype(int)
    height = max(3, round(float(rng.uniform(*terrain.height_m)) / grid.voxel_m))
    west, south = column + int(margins[0]), row + int(margins[1])
    east = min(column + block - int(margins[2]), grid.columns - int(margins[2]))
    north = min(row + block - int(margins[3]), grid.rows - int(margins[3]))
    return west, south, east, north, min(height, grid.layers - 1)


def _build(
    solid: BoolArray,
    grid: VoxelGrid,
    terrain: TownTerrain,
    rng: np.random.Generator,
    house: tuple[int, int, int, int, int],
    draws: np.ndarray[tuple[int], np.dtype[np.float64]],
) -> None:
    """Put a building there, perhaps with a lower wing, an overhang, a passage and a bridge to the east."""
    west, south, east, north, height = house
    if east - west < 4 or north - south < 4:
        return
    unit = 1.0 / grid.voxel_m
    solid[west:east, south:north, 1 : 1 + height] = True
    corner_e, corner_n = int(rng.integers(west + 2, east - 1)), int(rng.integers(south + 2, north - 1))
    if rng.random() < 0.5:  # an L: one corner is lower
        solid[corner_e:east, corner_n:north, 1 + height // 2 : 1 + height] = False
    storey, reach = round(5 * unit), max(1, round(2 * unit))
    if draws[0] < terrain.overhang_share and height > storey + reach:
        low = 1 + storey
        solid[max(0, west - reach) : west, south:north, low : low + reach] = True
        solid[west:east, north : north + reach, low : low + reach] = True
    if draws[1] < terrain.passage_share and height > storey + 1:
        middle, half = (south + north) // 2, max(2, round(3 * unit))
        solid[west:east, middle - half : middle + half, 1 : 1 + storey] = False
    if draws[2] < terrain.bridge_share and height > storey + reach:
        low, middle = 1 + storey, (south + north) // 2
        beyond = min(grid.columns - 1, east + round(terrain.street_m[1] * unit))
        solid[east:beyond, middle - reach : middle + reach, low : low + reach] = True
