"""MAVProxy, driven through its terminal, flies a simulated copter, alone and with others on the same vehicle."""

from __future__ import annotations

import asyncio
import shutil
import sys
from pathlib import Path

import pytest
from mavsdk.asyncio.plugins.action import ActionAsync as Action
from mavsdk.asyncio.plugins.param import ParamAsync as Param
from mavsdk.asyncio.plugins.telemetry import TelemetryAsync as Telemetry

from tests.fakes.simulator import Drive, armable, first, mavsdk, simulated
from tests.fakes.terminal import on_terminal

MAVPROXY = shutil.which("mavproxy.py", path=str(Path(sys.executable).parent))
pytestmark = [
    pytest.mark.processes,
    pytest.mark.skipif(MAVPROXY is None, reason="MAVProxy is not installed; pip install -e .[test] brings it"),
]
COPTER = ("merlin", "multicopter", "ardupilot")
MISSION = """QGC WPL 110
0\t0\t0\t16\t0\t0\t0\t0\t41.181800\t-8.697614\t10\t1
1\t0\t3\t22\t0\t0\t0\t0\t0\t0\t15\t1
2\t0\t3\t16\t0\t0\t0\t0\t41.182000\t-8.697614\t25\t1
3\t0\t3\t20\t0\t0\t0\t0\t0\t0\t0\t1
"""
FENCE = """QGC WPL 110
0\t0\t0\t5003\t400\t0\t0\t0\t41.181800\t-8.697614\t0\t1
"""


def mavproxy(drive: Drive, folder: Path) -> list[str]:
    assert MAVPROXY is not None
    (folder / "mission.txt").write_text(MISSION)
    (folder / "fence.txt").write_text(FENCE)
    return [sys.executable, MAVPROXY, f"--master=tcp:127.0.0.1:{drive.port}", "--source-system=255"]


def test_a_flight_from_the_terminal(tmp_path: Path, free_port_base: int) -> None:
    with simulated(tmp_path, free_port_base, COPTER, ground_m=10.0, speedup=4.0) as drive:
        with on_terminal(mavproxy(drive, tmp_path), tmp_path) as terminal:
            terminal.expect(r"Received \d+ parameters", 60.0)
            terminal.type("status SYS_STATUS")
            terminal.expect("SYS_STATUS")
            terminal.type("param set RTL_ALT 2500")
            terminal.type("param show RTL_ALT")
            terminal.expect(r"RTL_ALT\s+2500")
            terminal.type("wp load mission.txt")
            terminal.expect("MISSION_ACK: TYPE_MISSION: ACCEPTED")
            terminal.type("wp list")
            terminal.expect(r"Saved 4 waypoints")
            terminal.type("fence load fence.txt")
            terminal.expect("MISSION_ACK: TYPE_FENCE: ACCEPTED")
            terminal.type("fence list")
            terminal.expect("Saved 1 fence")
            terminal.type("rally list")
            terminal.expect("Requesting 0 rally items")
            terminal.type("ftp list")
            terminal.expect("@PARAM")
            terminal.type("mode guided")
            terminal.expect("Mode GUIDED")
            terminal.type("arm throttle")
            terminal.expect("ARMED")
            terminal.type("takeoff 15")
            terminal.expect("NAV_TAKEOFF: ACCEPTED")
            terminal.expect(r"height [1-9]\d")
            terminal.type("auto")
            terminal.expect("Mode AUTO")
            terminal.expect("waypoint 2|Reached waypoint|waypoint 3")
            terminal.type("rtl")
            terminal.expect("Mode RTL")
            terminal.expect("DISARMED", 60.0)
        truth = drive.stop()["merlin"]
    assert truth["has_flown"]
    assert not truth["crashed"]
    assert truth["distance_from_home_m"] < 1.0


async def test_an_agent_two_stations_and_mavproxy_on_one_vehicle(tmp_path: Path, free_port_base: int) -> None:
    """The agent flies; two stations watch, one sets a parameter; MAVProxy loads its parameters and lists."""
    with simulated(tmp_path, free_port_base, COPTER, ground_m=10.0, speedup=4.0) as drive:
        async with (
            mavsdk(drive.url(), 101, 191) as agent,
            mavsdk(drive.url(), 245) as station,
            mavsdk(f"udpout://127.0.0.1:{drive.port}", 246) as other,
        ):
            with on_terminal(mavproxy(drive, tmp_path), tmp_path) as terminal:
                action, telemetry, watching = Action(agent), Telemetry(agent), Telemetry(station)
                home = await armable(telemetry)
                await watching.set_rate_position(5.0)
                await Telemetry(other).set_rate_position(5.0)
                await asyncio.to_thread(terminal.expect, r"Received \d+ parameters", 60.0)
                await action.set_takeoff_altitude(15.0)
                await action.arm()
                await action.takeoff()
                for place in (telemetry, watching, Telemetry(other)):
                    await first(place.subscribe_position(), lambda p: p.relative_altitude_m > 14.0)
                await Param(other).set_param_int("RTL_ALT", 1800)
                assert await Param(station).get_param_int("RTL_ALT") == 1800
                north_deg = home.latitude_deg + 0.0003
                await action.goto_location(north_deg, home.longitude_deg, home.absolute_altitude_m + 20.0, 0.0)
                terminal.type("wp list")
                await first(watching.subscribe_position(), lambda p: abs(p.latitude_deg - north_deg) < 3e-6)
                await asyncio.to_thread(terminal.expect, "Requesting 0 waypoints|No waypoints|Saved 0")
                await action.return_to_launch()
                await first(telemetry.subscribe_armed(), lambda armed: not armed)
                await asyncio.to_thread(terminal.expect, "DISARMED")
        assert not drive.stop()["merlin"]["crashed"]
