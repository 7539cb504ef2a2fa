"""`import missions` is quick, and every name it promises is there."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import missions


@pytest.mark.parametrize("name", missions.__all__)
def test_every_promised_name_is_there(name):
    assert getattr(missions, name) is not None
    assert name in dir(missions)


def test_other_names_are_not():
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = missions.no_such_name


def test_the_import_itself_loads_nothing_heavy():
    code = "import sys, missions; print([n for n in ('numpy', 'numba', 'zenoh', 'msgspec') if n in sys.modules])"
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=Path(__file__).parents[2], capture_output=True, text=True, check=True
    )
    assert run.stdout.strip() == "[]"


def test_a_mission_is_loaded_by_name():
    plan = missions.load_mission("ridge")
    assert plan.mission.name == "ridge"
