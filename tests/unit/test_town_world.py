"""The true town: what its rays meet, who touches it, and towns that no team could start in."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from missions.flown import to_toml
from sim_bridge.fleet import Fleet
from sim_bridge.observable import observable_surface
from sim_bridge.town_world import Town, cast_rays
from sim_bridge.world import World
from tests.fakes.town_missions import town_content, town_plan
from vehicle_agent.domain.voxel_grid import VoxelGrid
from vehicle_agent.mission.load import MissionError, load_mission
from vehicle_agent.mission.model import Mission


def test_rays_meet_the_first_solid_voxel_that_their_points_lie_in() -> None:
    rng = np.random.default_rng(4)
    solid = rng.random((12, 12, 12)) < 0.15
    for _ in range(40):
        start = rng.uniform(0.5, 11.5, 3)
        solid[tuple(np.floor(start).astype(int))] = False
        aims = rng.uniform(-9.0, 9.0, (20, 3))
        shares, met = cast_rays(solid, start, aims)
        for aim, share, hit in zip(aims, shares, met, strict=True):
            places = np.floor(start + np.linspace(0.0, 1.0, 3_001)[:, None] * aim).astype(int)
            inside = ((places >= 0) & (places < 12)).all(axis=1)
            beyond = len(places) if inside.all() else int(np.argmin(inside))
            blocked = solid[tuple(places[:beyond].T)]
            if hit:
                voxel = np.floor(start + float(share) * aim).astype(int)
                assert solid[tuple(voxel)]
                before = np.linspace(0.0, 1.0, 3_001)[:beyond] < share
                assert (places[:beyond][before & blocked] == voxel).all()
            else:
                assert blocked.sum() <= 1  # a corner that the ray cuts by less than a sample's distance
                assert share == 1.0


def test_bodies_touch_walls_but_not_the_ground_they_stand_on() -> None:
    solid = np.zeros((10, 10, 6), dtype=np.bool_)
    solid[:, :, 0] = True
    solid[5, :, 1:4] = True
    town = Town(VoxelGrid(0.0, 0.0, -1.0, 1.0, 10, 10, 6), solid)
    places = np.array(
        [[2.5, 2.5, 0.0], [4.5, 2.5, 1.0], [4.8, 2.5, 1.0], [5.5, 2.5, 3.1], [5.5, 2.5, 2.8], [-50, 0, 1]]
    )
    assert town.touched_by(places).tolist() == [False, False, True, False, True, False]


def test_a_vehicle_that_flies_into_a_house_has_crashed() -> None:
    plan = town_plan()
    fleet = Fleet(plan, World.of(plan))
    town = fleet.world.town
    assert town is not None
    column, row, layer = (int(index) for index in np.argwhere(town.solid[:, :, 1:])[0] + (0, 0, 1))
    fleet.step(10.0)
    fleet.vehicles[0].arm()
    fleet.vehicles[0].take_off(10.0)
    fleet.step(10.0)
    assert not fleet.vehicles[0].crashed
    fleet.bodies.position_enu_m[0] = town.grid.centre_of((column, row, layer))
    fleet.step(0.1)
    assert fleet.vehicles[0].crashed
    assert not fleet.vehicles[0].armed
    assert fleet.crashes == 1


def test_the_same_seed_draws_the_same_town_and_its_surface_can_be_seen() -> None:
    plan = town_plan()
    one, same, other = (Town.of(p) for p in (plan, town_plan(), town_plan(seed=3)))
    assert np.array_equal(one.solid, same.solid)
    assert not np.array_equal(one.solid, other.solid)
    surface = observable_surface(plan, one)
    assert surface.sum() > 1_600  # the ground alone has as many
    assert not (surface & ~one.solid).any()


def write_mission(folder: Path, **terrain: object) -> Path:
    content = msgspec.convert(town_content(terrain={"kind": "town", **terrain}), Mission)
    path = folder / "hamlet.toml"
    path.write_text(to_toml(msgspec.to_builtins(content)))
    return path


def test_a_town_comes_from_a_file(tmp_path: Path) -> None:
    solid = np.zeros((40, 40, 18), dtype=np.bool_)
    solid[:, :, 0] = True
    solid[20:30, 20:30, 1:8] = True
    np.savez(tmp_path / "town.npz", solid=solid)
    town = World.of(load_mission(write_mission(tmp_path, file="town.npz"))).town
    assert town is not None
    assert np.array_equal(town.solid, solid)


@pytest.mark.parametrize(
    ("arrays", "sentence"),
    [
        (
            {"solid": np.ones((4, 4, 4))},
            r"`solid` is \(4, 4, 4\), but the area's voxels are \(40, 40, 18\); match them",
        ),
        ({"other": np.ones(3)}, "has no array `solid`; save the town"),
        ({"solid": np.zeros((40, 40, 18))}, "the lowest layer of `solid` is the ground"),
        (None, "does not exist; correct the path"),
    ],
)
def test_a_file_that_is_no_town_is_named(tmp_path: Path, arrays: dict[str, np.ndarray] | None, sentence: str) -> None:
    if arrays is not None:
        np.savez(tmp_path / "town.npz", **arrays)
    with pytest.raises(MissionError, match=sentence):
        World.of(load_mission(write_mission(tmp_path, file="town.npz")))


def test_a_start_inside_a_building_is_a_sentence(tmp_path: Path) -> None:
    solid = np.zeros((40, 40, 18), dtype=np.bool_)
    solid[:, :, 0] = True
    solid[8:14, 2:8, 1:8] = True
    np.savez(tmp_path / "town.npz", solid=solid)
    with pytest.raises(
        MissionError, match=r"vehicles\[1\].start_enu_m: \(10, 4\) lies inside, under or against a buil"
    ):
        World.of(load_mission(write_mission(tmp_path, file="town.npz")))


def test_a_vehicle_that_cannot_fly_over_the_roofs_is_told_how_high_they_are() -> None:
    with pytest.raises(MissionError, match=r"vehicles\[0\].max_above_terrain_m: buildings are up to 1[34] m high"):
        World.of(town_plan(terrain={"kind": "town", "block_m": 20.0, "street_m": [7.0, 9.0], "height_m": [13.0, 14.0]}))
