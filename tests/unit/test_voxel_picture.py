"""What a voxel map leaves to look at: frontiers, but for shadows that hang in known air."""

from __future__ import annotations

import numpy as np
import pytest

from vehicle_agent.domain.voxels import FREE, OCCUPIED, UNKNOWN
from vehicle_agent.planning.voxel_picture import SURE, VoxelPicture

CEILING = 8
SHADOW = (slice(4, 6), slice(4, 6), slice(4, 6))


def known_air() -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """All known: ground, and air above it."""
    states = np.full((12, 12, 10), FREE, dtype=np.uint8)
    states[:, :, 0] = OCCUPIED
    return states


def test_a_shadow_in_known_air_is_not_looked_into() -> None:
    states = known_air()
    states[SHADOW] = UNKNOWN
    picture = VoxelPicture.of(states, CEILING)
    assert not picture.frontier.any()
    assert not picture.worth.any()
    assert not picture.passable[SHADOW].any()


@pytest.mark.parametrize("touched", [(6, 4, 4), (6, 6, 6)], ids=["by a face", "by a corner"])
def test_a_shadow_that_touches_known_surface_is_looked_into(touched: tuple[int, int, int]) -> None:
    states = known_air()
    states[SHADOW] = UNKNOWN
    states[touched] = OCCUPIED
    picture = VoxelPicture.of(states, CEILING)
    assert picture.frontier[5, 4, 4]
    assert picture.worth[5, 4, 4] > 0.0


def test_a_shadow_that_reaches_unknown_ground_is_looked_into() -> None:
    states = known_air()
    states[4:6, 4:6, :6] = UNKNOWN
    states[3:7, 3:7, 0] = UNKNOWN
    picture = VoxelPicture.of(states, CEILING)
    assert picture.frontier[5, 5, 5]
    assert picture.worth[3, 3, 0] == SURE
