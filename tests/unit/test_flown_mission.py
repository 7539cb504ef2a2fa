"""The mission as flown reads back as the same mission, with the command line's changes and its terrain beside it."""

from __future__ import annotations

import tomllib

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from missions.catalogue import built_in_missions, load_named_mission
from missions.flown import Changes, to_toml, write_flown
from vehicle_agent.mission.load import MissionError
from vehicle_agent.mission.terrain import GridTerrain

TEXT = st.text(st.characters(exclude_categories=["Cs"]))
SCALAR = st.booleans() | st.integers(-(2**53), 2**53) | st.floats(allow_nan=False, allow_infinity=False) | TEXT
KEY = st.from_regex(r"[a-z][a-z0-9_-]{0,8}", fullmatch=True)
FLAT_TABLE = st.dictionaries(KEY, SCALAR | st.lists(SCALAR, max_size=3), min_size=1, max_size=4)
TABLE = st.dictionaries(KEY, SCALAR | st.lists(SCALAR, max_size=3) | FLAT_TABLE, min_size=1, max_size=4)


@given(st.dictionaries(KEY, SCALAR | TABLE | st.lists(TABLE, min_size=1, max_size=3), max_size=5))
def test_toml_reads_back_as_it_was_written(content):
    assert tomllib.loads(to_toml(content)) == content


@pytest.mark.parametrize("name", built_in_missions())
def test_every_mission_reads_back_as_flown(name, tmp_path):
    plan = load_named_mission(name)
    flown = write_flown(plan, tmp_path)
    assert flown.source == tmp_path / "mission.toml"
    if isinstance(plan.mission.terrain, GridTerrain):
        assert isinstance(flown.mission.terrain, GridTerrain)
        with (
            np.load(plan.source.parent / plan.mission.terrain.file) as before,
            np.load(tmp_path / flown.mission.terrain.file) as after,
        ):
            assert np.array_equal(before["elevation_amsl_m"], after["elevation_amsl_m"])
    assert msgspec.structs.replace(flown.mission, terrain=plan.mission.terrain) == plan.mission


def test_changes_of_the_command_line_are_flown():
    change = Changes(speedup=3.0, seed=11, port_base=20_000, planner="greedy").apply
    mission = load_named_mission("ridge", change).mission
    assert mission.simulation.speedup == 3.0
    assert mission.seed == 11
    assert mission.radio.zenoh_port == 20_000
    assert mission.simulation.mavlink_port == 20_100
    assert mission.task.planner == "greedy"


@pytest.mark.parametrize("changes", [Changes(speedup=float("nan")), Changes(planner="psychic"), Changes(port_base=80)])
def test_changes_that_do_not_fit_are_refused(changes):
    with pytest.raises(MissionError, match="option"):
        load_named_mission("ridge", changes.apply)
