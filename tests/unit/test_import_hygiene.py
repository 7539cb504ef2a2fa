"""Which libraries the ground station's parts may load: the first frame must not wait for a compiler."""

from __future__ import annotations

import subprocess
import sys

import pytest

HEAVY = {"numba", "scipy", "mavsdk", "pymavlink", "llvmlite"}
DRAWING = {"textual", "rich"}


def loaded_by(modules: str) -> set[str]:
    code = f"import {modules}, sys; print(*sorted({{name.partition('.')[0] for name in sys.modules}}))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    return set(done.stdout.split())


@pytest.mark.parametrize(
    "modules", ["ground_station.cli", "ground_station.app", "ground_station.plain", "ground_station.link"]
)
def test_the_ground_station_loads_no_compiler_and_no_autopilot_library(modules: str) -> None:
    assert not loaded_by(modules) & HEAVY


@pytest.mark.parametrize(
    "module",
    ["fleet_state", "link", "recorder", "station", "plain", "cli", "views.map_view", "views.roster_view"],
)
def test_only_the_dashboard_loads_textual(module: str) -> None:
    assert not loaded_by(f"ground_station.{module}") & DRAWING


def test_zenoh_is_loaded_only_when_the_link_is_opened() -> None:
    assert "zenoh" not in loaded_by("ground_station.cli, ground_station.link, ground_station.station")
