"""The `missions` program as people call it: what it prints, and how it refuses."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from missions.cli import main

MISSION = """
format = 1
name = "meadow"
title = "Two copters over a meadow"
[datum]
latitude_deg = 47.0
longitude_deg = 8.0
[area]
cell_m = 20.0
rectangle_enu_m = [0.0, 0.0, 400.0, 400.0]
[terrain]
kind = "flat"
elevation_amsl_m = 100.0
[task]
kind = "explore"
[[vehicles]]
name = "one"
start_enu_m = [50.0, 50.0]
speed_m_s = 10.0
sensor = { kind = "range", range_m = 120.0 }
min_above_terrain_m = 30.0
max_above_terrain_m = 100.0
[[vehicles]]
name = "two"
start_enu_m = [90.0, 50.0]
speed_m_s = 10.0
sensor = { kind = "range", range_m = 120.0 }
min_above_terrain_m = 30.0
max_above_terrain_m = 100.0
"""


@pytest.fixture
def mission(tmp_path: Path) -> Path:
    path = tmp_path / "meadow.toml"
    path.write_text(MISSION)
    return path


def call(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def refused(*arguments: object) -> str:
    """The one sentence with which a call is refused."""
    result = call(*arguments)
    assert result.exit_code == 2
    assert isinstance(result.exception, SystemExit)
    assert "Traceback" not in result.stderr
    assert result.stderr.count("\n") == 1
    return result.stderr


def test_list_names_every_mission_that_comes_with_the_package():
    result = call("list")
    assert result.exit_code == 0
    names = [line.split()[0] for line in result.stdout.splitlines()]
    assert names == sorted(path.stem for path in Path(__file__).parents[2].glob("missions/*.toml"))
    assert "ridge" in names


def test_list_loads_nothing_heavy():
    code = (
        "import sys\nfrom missions.cli import main\n"
        "main(['list'], standalone_mode=False)\n"
        "print([name for name in ('numba', 'scipy', 'zenoh', 'mavsdk', 'pymavlink', 'textual') if name in sys.modules])"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=Path(__file__).parents[2], capture_output=True, text=True, check=True
    )
    assert run.stdout.splitlines()[-1] == "[]"


def test_check_tells_what_the_mission_will_do(mission):
    result = call("check", mission)
    assert result.exit_code == 0
    assert "400 m x 400 m" in result.stdout
    assert "one: multicopter 1 (simulated) from (50, 50) on 100 m" in result.stdout
    assert "reachable 100.00 %" in result.stdout


def test_schema_is_json_schema_of_the_mission():
    schema = json.loads(call("schema").stdout)
    assert "Mission" in json.dumps(schema)


@pytest.mark.parametrize("command", ["run", "check"])
def test_an_unknown_mission_is_refused_with_the_names_that_there_are(command):
    assert "ridge" in refused(command, "atlantis")


@pytest.mark.parametrize("command", ["run", "check"])
def test_a_missing_file_is_refused(command, tmp_path):
    assert "no such file" in refused(command, tmp_path / "nothing.toml")


def test_a_folder_is_refused(tmp_path):
    assert str(tmp_path) in refused("check", tmp_path)


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ("cell_m = 20.0", "cell_m = 20.0\ncolour = 3", "area.colour"),
        ("start_enu_m = [50.0, 50.0]", "start_enu_m = [50.0, 50.0, 20.0]", "vehicles[0].start_enu_m"),
        ("start_enu_m = [50.0, 50.0]", "start_enu_m = [-50.0, 50.0]", "vehicles[0].start_enu_m"),
        ('kind = "flat"\nelevation_amsl_m = 100.0', 'kind = "grid"\nfile = "nowhere.npz"', "nowhere.npz"),
    ],
)
@pytest.mark.parametrize("command", ["run", "check"])
def test_a_mission_that_cannot_be_flown_is_refused_by_key(command, old, new, named, mission):
    assert old in MISSION
    mission.write_text(MISSION.replace(old, new))
    assert named in refused(command, mission)


@pytest.mark.parametrize(
    ("kind", "offset", "key"),
    [("tcp", 0, "radio.zenoh_port"), ("tcp", 2, "radio.zenoh_port"), ("tcp", 100, "simulation.mavlink_port"),
     ("udp", 110, "simulation.mavlink_port")],
)  # fmt: skip
def test_a_port_in_use_is_refused_by_number_and_key(kind, offset, key, mission, tmp_path, free_port_base):
    taken = socket.socket(socket.AF_INET, socket.SOCK_STREAM if kind == "tcp" else socket.SOCK_DGRAM)
    with taken:
        taken.bind(("127.0.0.1", free_port_base + offset))
        if kind == "tcp":
            taken.listen()
        sentence = refused("run", mission, "--port-base", free_port_base, "--runs-dir", tmp_path / "runs")
    assert f"{kind.upper()} port {free_port_base + offset}" in sentence
    assert key in sentence
    assert "--port-base" in sentence
    assert not (tmp_path / "runs").exists()


def test_a_runs_folder_that_is_a_file_is_refused(mission, tmp_path, free_port_base):
    occupied = tmp_path / "occupied"
    occupied.touch()
    assert str(occupied) in refused("run", mission, "--port-base", free_port_base, "--runs-dir", occupied)


@pytest.mark.parametrize("speedup", ["0", "-3", "101", "nan", "fast"])
def test_an_impossible_speedup_is_refused(mission, speedup):
    result = call("run", mission, "--speedup", speedup)
    assert result.exit_code == 2
    assert isinstance(result.exception, SystemExit)


def test_report_of_a_folder_without_a_summary_is_refused(tmp_path):
    assert "summary.json" in refused("report", tmp_path)


@pytest.mark.parametrize("text", ["", "{", "[]", '{"format": 1}', "\x00"])
def test_report_of_a_broken_summary_is_refused(tmp_path, text):
    (tmp_path / "summary.json").write_text(text)
    assert "summary.json" in refused("report", tmp_path)


def test_simulate_tells_and_keeps_the_outcome(mission, tmp_path):
    out = tmp_path / "result"
    result = call("simulate", mission, "--seed", 5, "--out", out)
    assert result.exit_code == 0
    assert result.stdout.startswith("meadow: ")
    assert "seed 5" in result.stdout
    assert json.loads((out / "summary.json").read_text())["observed_fraction"] >= 0.99


def test_simulate_several_seeds_writes_a_line_and_a_folder_each(mission, tmp_path):
    out = tmp_path / "result"
    result = call("simulate", mission, "--seeds", "3,1-2,2", "--out", out, "--planner", "closest-frontier")
    assert result.exit_code == 0
    lines = result.stdout.splitlines()
    assert [line.split()[1] for line in lines[1:4]] == ["3", "1", "2"]
    assert lines[4].endswith("3 of 3 seeds good")
    assert sorted(path.name for path in out.iterdir()) == ["seed-1", "seed-2", "seed-3"]


@pytest.mark.parametrize("seeds", ["", "x", "5-1", "1-", "-3", "1,,2", "1-99999999", "4294967296", "²"])
def test_impossible_seeds_are_refused(mission, seeds):
    result = call("simulate", mission, f"--seeds={seeds}")
    assert result.exit_code == 2
    assert isinstance(result.exception, SystemExit)


def test_one_seed_and_several_exclude_each_other(mission):
    assert call("simulate", mission, "--seed", 1, "--seeds", "1-2").exit_code == 2


def test_an_unknown_planner_is_refused(mission):
    assert "planner" in refused("simulate", mission, "--planner", "psychic")


def test_results_that_cannot_be_kept_are_refused(mission, tmp_path):
    occupied = tmp_path / "occupied"
    occupied.touch()
    assert str(occupied) in refused("simulate", mission, "--out", occupied / "below")
