"""Faces of walls, roofs and ground: which there are, which a place sees, and which place sees most."""

from __future__ import annotations

import numpy as np
import pytest

from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.ray_fan import down_looking_fan
from vehicle_agent.domain.voxel_faces import (
    EAST,
    NORTH,
    SOUTH,
    TOP,
    WEST,
    best_faces,
    count_faces,
    open_faces,
    seen_faces,
)
from vehicle_agent.planning.voxel_cao import face_share

FAN = down_looking_fan(6.0)


def ground(*houses: tuple[slice, slice, slice]) -> BoolArray:
    """Level ground of 16 x 16 voxels with boxes on it."""
    solid: BoolArray = np.zeros((16, 16, 10), dtype=np.bool_)
    solid[:, :, 0] = True
    for house in houses:
        solid[house] = True
    return solid


def at(*voxel: int) -> IndexArray:
    return np.array([voxel], dtype=np.int64)


def test_a_block_has_four_walls_and_a_roof_and_covers_its_ground() -> None:
    solid = ground((slice(5, 8), slice(5, 8), slice(1, 4)))
    faces = open_faces(solid)
    assert faces[6, 6, 0] == 0
    assert faces[6, 6, 3] == TOP
    assert faces[5, 5, 3] == WEST | SOUTH | TOP
    assert faces[7, 7, 1] == EAST | NORTH
    assert count_faces(faces) == 16 * 16 - 9 + 9 + 4 * 9


def test_undersides_of_overhangs_are_no_faces_but_the_ground_below_them_is() -> None:
    faces = open_faces(ground((slice(5, 8), slice(5, 8), slice(4, 5))))
    assert faces[6, 6, 0] == TOP
    assert faces[6, 6, 4] == TOP
    assert faces[5, 6, 4] == WEST | TOP


def test_a_place_beside_a_wall_sees_that_wall_only() -> None:
    solid = ground((slice(8, 10), slice(2, 14), slice(1, 9)))
    seen = seen_faces(solid, FAN, at(5, 8, 4))
    assert seen[8, 8, 4] == WEST
    assert not (seen & EAST).any()
    assert not seen[10:].any()
    assert count_faces(seen & ~open_faces(solid)) == 0


@pytest.mark.parametrize("seed", range(3))
def test_only_open_faces_are_seen_and_never_through_something_solid(seed: int) -> None:
    rng = np.random.default_rng(seed)
    solid = ground()
    solid |= rng.random(solid.shape) < 0.1
    solid[8, 8, 6] = False
    seen = seen_faces(solid, FAN, at(8, 8, 6))
    assert seen.any()
    assert count_faces(seen & ~open_faces(solid)) == 0
    assert not seen[:, :, 7:].any()


def test_the_place_that_sees_most_of_what_others_do_not_see_is_chosen() -> None:
    solid = ground()
    places = np.concatenate((at(4, 4, 3), at(5, 4, 3), at(11, 11, 3)))
    taken, ones = seen_faces(solid, FAN, at(4, 5, 3)), np.ones((16, 16), dtype=np.int64)
    chosen, gain, first = best_faces(solid, FAN.steps, FAN.firsts, places, ones, taken, np.zeros(3))
    assert chosen == 2
    assert gain == count_faces(seen_faces(solid, FAN, places[2:]) & ~taken)
    assert first == count_faces(seen_faces(solid, FAN, places[:1]) & ~taken)
    assert best_faces(solid, FAN.steps, FAN.firsts, places, ones, taken, np.array([1e6, 0.0, 0.0]))[0] == 0


def test_faces_of_unwanted_columns_do_not_count() -> None:
    solid, none = ground(), np.zeros((16, 16, 10), dtype=np.uint8)
    worth = np.zeros((16, 16), dtype=np.int64)
    worth[4, 4] = 3
    assert best_faces(solid, FAN.steps, FAN.firsts, at(4, 5, 3), worth, none, np.zeros(1)) == (0, 3, 3)


def test_a_face_that_several_see_is_shared() -> None:
    own = np.zeros((2, 2, 2), dtype=np.uint8)
    own[0, 0, 0], own[1, 1, 1] = WEST | TOP, EAST
    mate = np.zeros((2, 2, 2), dtype=np.uint8)
    mate[0, 0, 0] = TOP | NORTH
    assert face_share(own, []) == 3.0
    assert face_share(own, [mate]) == 2.5
    assert face_share(own, [mate, mate]) == pytest.approx(2.0 + 1.0 / 3.0)
