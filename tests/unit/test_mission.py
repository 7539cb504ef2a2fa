"""The mission file: what a good one gives, and one sentence for every bad one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from vehicle_agent.mission.load import MissionError, load_mission, plan_mission
from vehicle_agent.mission.model import Mission
from vehicle_agent.mission.plan import MissionPlan

RIDGE = Path(__file__).parents[2] / "missions" / "ridge.toml"
TEXT = """\
format = 1
name = "ridge"
title = "Two copters"
seed = 7
[datum]
latitude_deg = 36.654
longitude_deg = -84.37
[area]
cell_m = 20.0
rectangle_enu_m = [0.0, 0.0, 4000.0, 4000.0]
fence_margin_m = 10.0
[terrain]
kind = "grid"
file = "terrain/jacksboro.npz"
[task]
kind = "explore"
planner = "claims"
[[vehicles]]
name = "merlin"
start_enu_m = [200.0, 200.0]
speed_m_s = 18.0
climb_m_s = 6.0
sensor = { kind = "range", range_m = 350.0 }
min_above_terrain_m = 60.0
max_above_terrain_m = 300.0
[[vehicles]]
name = "kestrel"
start_enu_m = [240.0, 200.0]
speed_m_s = 18.0
climb_m_s = 6.0
sensor = { kind = "range", range_m = 350.0 }
min_above_terrain_m = 60.0
max_above_terrain_m = 300.0
[simulation]
speedup = 10.0
[stop]
observed_fraction = 0.997
"""
Change = Callable[[str], str]


def swap(old: str, new: str) -> Change:
    """Replace the first occurrence, which must exist."""

    def change(text: str) -> str:
        assert old in text
        return text.replace(old, new, 1)

    return change


def area(lines: str) -> Change:
    return swap("rectangle_enu_m = [0.0, 0.0, 4000.0, 4000.0]", lines)


def fleet(count: int, more: str) -> Change:
    """A mission of `count` vehicles in a row."""
    vehicle = TEXT.split("[[vehicles]]")[1]
    rows = [
        "[[vehicles]]"
        + vehicle.replace('"merlin"', f'"copter-{index}"').replace("[200.0, 200.0]", f"[{100 + 40 * index}.0, 200.0]")
        for index in range(count)
    ]
    return lambda text: text[: text.index("[[vehicles]]")] + "".join(rows) + more


def load(folder: Path, content: str | bytes) -> MissionPlan:
    file = folder / "m.toml"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    return load_mission(file)


def complaint(call: Callable[[], Any]) -> str:
    """The error's text, which must be one printable line."""
    with pytest.raises(MissionError) as caught:
        call()
    text = str(caught.value)
    assert text.isprintable()
    assert len(text) < 450
    return text


def test_ridge_is_as_its_comments_say() -> None:
    plan = load_mission(RIDGE)
    assert plan.grid.shape == (200, 200)
    assert plan.area_cells.all()
    assert plan.vehicle_names == ("merlin", "kestrel", "osprey", "harrier")
    assert [plan.system_id(index) for index in range(4)] == [1, 2, 3, 4]
    assert [plan.controller_system_id(index) for index in range(4)] == [101, 102, 103, 104]


def test_ports_and_endpoints_follow_from_a_vehicles_place(tmp_path: Path) -> None:
    plan = load(tmp_path, TEXT)
    assert plan.connection(1) == "tcpout://127.0.0.1:5770"
    assert plan.simulator_endpoint() == "tcp/127.0.0.1:7450"
    assert plan.agent_endpoint(1) == "tcp/127.0.0.1:7452"


def test_a_polygon_in_degrees_is_the_same_polygon_in_metres(tmp_path: Path) -> None:
    plan = load_mission(RIDGE)
    corners = [plan.datum.to_geodetic((east, north, 0.0)) for east, north in ((0, 0), (4000, 100), (2000, 4000))]
    degrees = ", ".join(f"[{corner.latitude_deg!r}, {corner.longitude_deg!r}]" for corner in corners)
    in_degrees = load(tmp_path, area(f"polygon_deg = [{degrees}]")(TEXT))
    in_metres = load(tmp_path, area("polygon_enu_m = [[0.0, 0.0], [4000.0, 100.0], [2000.0, 4000.0]]")(TEXT))
    np.testing.assert_allclose(in_degrees.fence_en_m, in_metres.fence_en_m, atol=1e-6)
    assert 0 < in_metres.area_cells.sum() < in_metres.grid.cells


def test_a_mark_that_editors_put_first_does_no_harm(tmp_path: Path) -> None:
    assert load(tmp_path, b"\xef\xbb\xbf" + TEXT.encode()).mission.name == "ridge"


def test_a_mission_built_in_python_meets_the_same_checks() -> None:
    mission = load_mission(RIDGE).mission
    assert plan_mission(mission).mission == mission
    for wrong, key in (
        (msgspec.structs.replace(mission, seed=-1), "seed"),
        (msgspec.structs.replace(mission, name="Ridge"), "name"),
        (msgspec.structs.replace(mission, vehicles=()), "vehicles"),
        (msgspec.structs.replace(mission, seed=object()), "object"),
        (
            msgspec.structs.replace(
                mission, simulation=msgspec.structs.replace(mission.simulation, speedup=float("nan"))
            ),
            "simulation.speedup",
        ),
    ):
        assert key in complaint(lambda wrong=wrong: plan_mission(wrong))  # type: ignore[misc]


def test_a_change_from_the_command_line_is_checked_too() -> None:
    def faster(mission: Mission) -> Mission:
        return msgspec.structs.replace(mission, simulation=msgspec.structs.replace(mission.simulation, speedup=1e9))

    assert "simulation.speedup: expected a number <= 100.0" in complaint(lambda: load_mission(RIDGE, faster))


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        # Syntax and encoding.
        (lambda _: "", "format: missing"),
        (lambda text: text + "\n[stop]\n", "is not TOML"),
        (swap("seed = 7", "seed = "), "is not TOML"),
        (swap("seed = 7", "seed = 1" + "0" * 5_000), "is not TOML"),
        (swap("seed = 7", "x = " + "[" * 5_000), "nested too deeply"),
        (lambda text: text.encode() + b"\n# caf\xe9\n", "is not UTF-8 text"),
        (lambda text: text.encode("utf-16"), "is not UTF-8 text"),
        (lambda _: "\0\0\0\0", "is not TOML"),
        (lambda text: text + "#" * 1_000_001, "is larger than"),
        # Keys.
        (swap("seed = 7", "sed = 7"), "sed: unknown key"),
        (swap("range_m = 350.0", "range_m = 350.0, colour = 1"), "vehicles[0].sensor.colour: unknown key"),
        (swap("range_m = 350.0", 'range_m = 350.0, "a`b - at `c\\n\\u001b[2J" = 1'), "\\n\\x1b[2J: unknown key"),
        (swap("cell_m = 20.0", ""), "area.cell_m: missing"),
        (swap('kind = "explore"', ""), "task.kind: missing"),
        (swap('kind = "range", ', ""), "vehicles[0].sensor.kind: missing"),
        (swap('kind = "grid"', ""), "terrain.kind: missing"),
        (lambda text: text[: text.index("[[vehicles]]")], "vehicles: missing"),
        # Types and bounds.
        (swap("format = 1", "format = 2"), "format: 2 is not known; choose 1"),
        (swap("format = 1", 'format = "1"'), "format: expected a whole number, got a string"),
        (swap("seed = 7", "seed = 7.5"), "seed: expected a whole number"),
        (swap("seed = 7", "seed = -1"), "seed: expected a whole number >= 0"),
        (swap("speed_m_s = 18.0", "speed_m_s = nan"), "vehicles[0].speed_m_s: nan is not a quantity"),
        (swap("climb_m_s = 6.0", "climb_m_s = inf"), "vehicles[0].climb_m_s: inf is not a quantity"),
        (swap("0.0, 4000.0, 4000.0]", "0.0, 4000.0, -inf]"), "area.rectangle_enu_m[3]: -inf is not a quantity"),
        (swap("speed_m_s = 18.0", "speed_m_s = 0"), "vehicles[0].speed_m_s: expected a number >= 0.1"),
        (swap("speed_m_s = 18.0", "speed_m_s = true"), "vehicles[0].speed_m_s: expected a number, got a boolean"),
        (swap("speed_m_s = 18.0", "speed_m_s = 1" + "0" * 400), "vehicles[0].speed_m_s: number out of range"),
        (swap("speed_m_s = 18.0", "speed_m_s = 2026-01-01"), "vehicles[0].speed_m_s: expected a number, got `date`"),
        (swap("[datum]", "[[datum]]"), "datum: expected a table, got an array"),
        (swap("latitude_deg = 36.654", "latitude_deg = 89.5"), "datum.latitude_deg"),
        (swap('"claims"', '"magic"'), "task.planner: 'magic' is not known; choose 'cao', 'claims'"),
        (swap('kind = "grid"', 'kind = "moon"'), "'moon' is not known; choose 'grid', 'gaussians', 'flat'"),
        (swap('kind = "range"', 'kind = "sonar"'), "vehicles[0].sensor.kind: 'sonar' is not known; choose 'range'"),
        (swap('kind = "explore"', 'kind = "loiter"'), "task.kind: 'loiter' is not known; choose 'explore', 'cover'"),
        (swap("[200.0, 200.0]", "[200.0]"), "vehicles[0].start_enu_m: expected an array of length >= 2"),
        (swap("[200.0, 200.0]", "[200.0, 200.0, 0.0, 1.0]"), "vehicles[0].start_enu_m: expected an array"),
        (swap('file = "terrain/jacksboro.npz"', 'file = ""'), "terrain.file"),
        (swap('file = "terrain/jacksboro.npz"', 'file = "a\\u0000b"'), "terrain.file: must be one line"),
        (swap("speedup = 10.0", "speedup = 0.0"), "simulation.speedup: expected a number >= 0.1"),
        (swap("observed_fraction = 0.997", "observed_fraction = 1.1"), "stop.observed_fraction"),
        # Names and addresses.
        (swap('name = "ridge"', 'name = "ridge\\n"'), "name: must be at most 31 lower-case letters"),
        (swap('name = "ridge"', 'name = "rid\\tge"'), "name: must be at most 31 lower-case letters"),
        (swap('name = "ridge"', 'name = "../ridge"'), "name: must be at most 31 lower-case letters"),
        (swap('name = "ridge"', 'name = ""'), "name: must be at most 31 lower-case letters"),
        (swap('"merlin"', '"a/b"'), "vehicles[0].name: must be at most 31"),
        (swap('"merlin"', '"kestrel"'), "vehicles[1].name: 'kestrel' is also that of vehicles[0]"),
        (swap('"merlin"', '"station-1"'), "vehicles[0].name: 'station-1' is kept for stations"),
        (swap('title = "Two', 'title = "Two\\u001b[2J'), "title: must be one line"),
        (swap("[simulation]", '[radio]\nendpoint_host = "a b"\n[simulation]'), "radio.endpoint_host: must be a host"),
        (swap("climb_m_s = 6.0", 'connection = "com3"'), "vehicles[0].connection: must be a MAVSDK connection URL"),
        # Area.
        (area(""), "area: give exactly one of"),
        (area("rectangle_enu_m = [0, 0, 9, 9]\npolygon_enu_m = [[0, 0], [1, 0], [1, 1]]"), "area: give exactly one of"),
        (area("rectangle_enu_m = [0, 0, 9]"), "area.rectangle_enu_m: expected an array of length 4, got 3"),
        (area("rectangle_enu_m = [9, 0, 0, 9]"), "area.rectangle_enu_m: must be [west, south, east, north]"),
        (area("rectangle_enu_m = [0, 0, 0, 9]"), "area.rectangle_enu_m: must be [west, south, east, north]"),
        (area("rectangle_enu_m = [0, 0, 1e5, 1e5]"), "area.rectangle_enu_m: reaches 141 km from the datum"),
        (area("rectangle_enu_m = [0, 0, 9e4, 2e4]"), "area.cell_m: 20 m makes 4500000 cells; choose"),
        (swap("cell_m = 20.0", "cell_m = 1e-300"), "area.cell_m: expected a number >= 0.01"),
        (swap("cell_m = 20.0", "cell_m = 0.01"), "area.cell_m: 0.01 m makes 160000000000 cells"),
        (swap("cell_m = 20.0", "cell_m = 20000.0"), "area: holds no cell centre"),
        (area("polygon_enu_m = [[0, 0], [9, 0]]"), "area.polygon_enu_m: expected an array of length >= 3"),
        (area("polygon_enu_m = [[0, 0], [5, 5], [9, 9]]"), "area.polygon_enu_m: encloses no ground"),
        (area("polygon_enu_m = [[1, 1], [1, 1], [1, 1]]"), "area.polygon_enu_m: corners 2 and 0 are the same point"),
        (area("polygon_enu_m = [[0, 0], [9, 9], [9, 0], [0, 9]]"), "corner 0 meets the one that begins at corner 2"),
        (area("polygon_enu_m = [[0, 0], [9, 0], [9, 9], [0, 0]]"), "corners 3 and 0 are the same point"),
        (area("polygon_enu_m = [[0, 0], [9, 0], [9, 1]]"), "area: holds no cell centre"),
        (area("polygon_deg = [[36.6, -84.4], [36.6, -84.3], [95.0, -84.3]]"), "area.polygon_deg[2][0]: expected"),
        (area("polygon_deg = [[36.6, -84.4], [36.6, -84.3], [40.0, -84.3]]"), "area.polygon_deg: reaches 371 km"),
        # Team.
        (swap("[240.0, 200.0]", "[200.5, 200.0]"), "vehicles[1].start_enu_m: is 0.5 m from vehicles[0]'s start"),
        (swap("[200.0, 200.0]", "[-200.0, 200.0]"), "vehicles[0].start_enu_m: lies outside the area"),
        (swap("[200.0, 200.0]", "[200.0, 9.0]"), "vehicles[0].start_enu_m: lies 9.0 m from the area's border"),
        (swap("fence_margin_m = 10.0", "fence_margin_m = 2500.0"), "inside area.fence_margin_m (2500 m)"),
        (swap("climb_m_s = 6.0", "system_id = 2"), "vehicles[1].system_id: '2' is also that of vehicles[0]"),
        (swap("climb_m_s = 6.0", "system_id = 100"), "vehicles[0].system_id: expected a whole number <= 99"),
        (swap("max_above_terrain_m = 300.0", "max_above_terrain_m = 60.0"), "vehicles[0].max_above_terrain_m"),
        (swap("min_above_terrain_m = 60.0", "min_above_terrain_m = 350.0"), "vehicles[0].max_above_terrain_m"),
        (swap("range_m = 350.0", "range_m = 60.0"), "vehicles[0].sensor.range_m: 60 m does not reach the ground"),
        (
            lambda text: text.replace("climb_m_s = 6.0", 'connection = "udpin://0.0.0.0:14540"', 2),
            "vehicles[1].connection: 'udpin://0.0.0.0:14540' is also that of vehicles[0]",
        ),
        (fleet(65, ""), "vehicles: expected an array of length <= 64"),
        # Terrain.
        (
            swap(
                'kind = "grid"\nfile = "terrain/jacksboro.npz"',
                'kind = "gaussians"\npeaks = 1\nheight_m = [9.0, 1.0]\nsigma_m = 9.0',
            ),
            "terrain.height_m: must be [lowest, highest]",
        ),
        # Ports.
        (fleet(64, "[simulation]\nmavlink_port = 64950\n"), "mavlink_port: 64 vehicles need ports up to 65580"),
        (fleet(64, "[radio]\nzenoh_port = 65500\n"), "radio.zenoh_port: 64 vehicles need ports up to 65564"),
        (fleet(4, "[radio]\nzenoh_port = 5768\n"), "radio.zenoh_port: ports 5768 to 5772 include MAVLink port 5770"),
        (fleet(4, "[simulation]\nmavlink_port = 80\n"), "simulation.mavlink_port: expected a whole number >= 1024"),
    ],
)  # fmt: skip
def test_every_bad_file_gets_one_sentence(tmp_path: Path, change: Callable[[str], str | bytes], expected: str) -> None:
    text = complaint(lambda: load(tmp_path, change(TEXT)))
    assert text.startswith(f"{tmp_path / 'm.toml'}: ")
    assert expected in text


def test_paths_that_are_no_files(tmp_path: Path) -> None:
    assert "no such file; `missions list`" in complaint(lambda: load_mission(tmp_path / "none.toml"))
    assert "is a folder" in complaint(lambda: load_mission(tmp_path))
    assert "cannot be read (Not a directory)" in complaint(lambda: load_mission(RIDGE / "x.toml"))
    assert "cannot be read (File name too long)" in complaint(lambda: load_mission(Path("x" * 256)))
    assert "is not a path" in complaint(lambda: load_mission(Path("a\0b")))
    assert "\\n" in complaint(lambda: load_mission(tmp_path / "a\nb.toml"))


def test_an_endless_file_is_not_read_to_its_end() -> None:
    if not Path("/dev/zero").exists():
        pytest.skip("this system has no endless file")
    assert "is larger than" in complaint(lambda: load_mission(Path("/dev/zero")))


def test_ports_between_one_another_are_no_conflict(tmp_path: Path) -> None:
    plan = load(tmp_path, fleet(4, "[simulation]\nmavlink_port = 7445\n")(TEXT))
    assert [plan.mavlink_port(index) for index in range(4)] == [7445, 7455, 7465, 7475]
    assert plan.agent_endpoint(3).endswith(":7454")


def test_sixty_four_vehicles_fit(tmp_path: Path) -> None:
    plan = load(tmp_path, fleet(64, "")(TEXT))
    ports = {plan.mavlink_port(index) for index in range(64)}
    ports |= {int(plan.agent_endpoint(index).rsplit(":", 1)[1]) for index in range(64)}
    ids = {plan.system_id(index) for index in range(64)} | {plan.controller_system_id(index) for index in range(64)}
    assert len(ports) == len(ids) == 128
    assert max(ids) < 255


def test_an_unknown_vehicle_is_a_sentence_too() -> None:
    text = complaint(lambda: load_mission(RIDGE).vehicle("falcon"))
    assert "there is no vehicle 'falcon'; the mission has merlin, kestrel" in text
