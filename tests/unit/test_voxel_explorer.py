"""Explorers among buildings: they part, keep what they go for, leave alone what a teammate does, and end."""

from __future__ import annotations

import numpy as np
import pytest

from vehicle_agent.domain.ray_fan import down_looking_fan
from vehicle_agent.domain.voxels import FREE, OCCUPIED, UNKNOWN
from vehicle_agent.planning.voxel_explorer import Voxel, VoxelExplorer, VoxelExplorerParams, VoxelTeammate
from vehicle_agent.planning.voxel_picture import VoxelPicture

SHAPE, CEILING = (64, 40, 20), 17
FAN = down_looking_fan(10.0)
HERE: Voxel = (32, 20, 12)
WEST, EAST = (slice(2, 10), slice(16, 24), 0), (slice(54, 62), slice(16, 24), 0)


def picture(*unknown: tuple[slice, slice, int]) -> VoxelPicture:
    """Known air over level ground, parts of which nobody saw."""
    states = np.full(SHAPE, FREE, dtype=np.uint8)
    states[:, :, 0] = OCCUPIED
    for place in unknown:
        states[place] = UNKNOWN
    return VoxelPicture.of(states, CEILING)


def end_of(route_voxels: np.ndarray[tuple[int], np.dtype[np.int64]]) -> tuple[int, ...]:
    return tuple(int(index) for index in np.unravel_index(int(route_voxels[-1]), SHAPE))


def test_a_route_leads_to_where_the_unknown_is_seen() -> None:
    explorer = VoxelExplorer(0, FAN)
    route = explorer.ask(picture(EAST), HERE, [])
    assert route is not None
    assert explorer.goal is not None
    assert explorer.goal[0] in range(54, 62)
    assert np.linalg.norm(np.subtract(end_of(route.voxels), explorer.goal)) <= 16.0
    assert len(explorer.expected) > 0
    assert explorer.still_worth(picture(EAST))
    assert not explorer.still_worth(picture())


def test_teammates_part_and_leave_goals_to_each_other() -> None:
    shown = picture(WEST, EAST)
    first, second = VoxelExplorer(0, FAN), VoxelExplorer(1, FAN)
    assert first.ask(shown, HERE, [VoxelTeammate(1, (30, 24, 12))]) is not None
    assert first.goal is not None
    route = second.ask(shown, (30, 24, 12), [VoxelTeammate(0, HERE, first.goal)])
    assert route is not None
    assert second.goal is not None
    assert (first.goal[0] < 32) != (second.goal[0] < 32)


def test_what_a_teammate_goes_for_is_taken_only_when_nothing_else_is_left() -> None:
    shown = picture((slice(54, 56), slice(20, 22), 0))
    explorer = VoxelExplorer(0, FAN)
    assert explorer.ask(shown, HERE, [VoxelTeammate(1, (50, 20, 12), (55, 21, 0))]) is not None
    assert explorer.goal is not None
    assert explorer.goal[0] >= 54


def test_a_goal_goes_to_who_is_much_nearer_and_the_other_lets_it_go() -> None:
    shown = picture(WEST, EAST)
    far, near = VoxelExplorer(0, FAN), VoxelExplorer(1, FAN)
    far.ask(shown, (50, 20, 12), [VoxelTeammate(1, (58, 20, 12), (58, 20, 0))])
    assert far.goal is not None
    assert far.goal[0] < 32
    mate = VoxelTeammate(0, (50, 20, 12), far.goal)
    near.ask(shown, (14, 20, 12), [mate])
    assert near.goal == far.goal
    assert far.is_taken((50, 20, 12), [VoxelTeammate(1, (14, 20, 12), near.goal)])
    assert not near.is_taken((14, 20, 12), [mate])
    assert not far.is_taken((20, 20, 12), [VoxelTeammate(1, (14, 20, 12), near.goal)])


def test_who_has_nothing_else_to_do_helps_on() -> None:
    shown = picture((slice(54, 56), slice(20, 22), 0))
    spare = VoxelExplorer(0, FAN)
    mate = VoxelTeammate(1, (50, 20, 12), (55, 21, 0))
    spare.ask(shown, HERE, [mate])
    assert not spare.is_taken(HERE, [mate])


def test_a_goal_is_kept_until_nothing_of_it_is_left() -> None:
    explorer = VoxelExplorer(0, FAN)
    explorer.ask(picture(EAST), HERE, [])
    kept = explorer.goal
    nearer = (slice(30, 34), slice(18, 22), 0)
    explorer.ask(picture(EAST, nearer), (40, 20, 12), [])
    assert explorer.goal == kept
    explorer.let_go()
    explorer.ask(picture(EAST, nearer), (34, 20, 12), [])
    assert explorer.goal is not None
    assert explorer.goal[0] in range(30, 34)


def test_nothing_unknown_in_sight_ends_it() -> None:
    explorer = VoxelExplorer(0, FAN)
    assert explorer.ask(picture(), HERE, []) is None
    assert explorer.goal is None


@pytest.mark.parametrize("name", ["patch", "storey", "sampled", "full_patch"])
def test_params_must_be_at_least_one(name: str) -> None:
    with pytest.raises(ValueError, match="at least 1"):
        VoxelExplorerParams(**{name: 0})


def test_ways_cannot_be_saved_from_nowhere() -> None:
    with pytest.raises(ValueError, match="seen_from"):
        VoxelExplorerParams(seen_from=0.0)
