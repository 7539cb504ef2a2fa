"""An agent at work, two stations on MAVSDK and MAVProxy on one simulated vehicle: none disturbs another."""

from __future__ import annotations

import asyncio
import itertools
import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from mavsdk.asyncio import System
from mavsdk.asyncio.plugins.mavlink_direct import MavlinkDirectAsync as MavlinkDirect
from mavsdk.asyncio.plugins.mission_raw import MissionRawAsync as MissionRaw
from mavsdk.asyncio.plugins.param import ParamAsync as Param
from mavsdk.asyncio.plugins.telemetry import TelemetryAsync as Telemetry

from tests.fakes.simulator import Drive, first, mavsdk, simulated
from tests.fakes.terminal import on_terminal

MAVPROXY = shutil.which("mavproxy.py", path=str(Path(sys.executable).parent))
pytestmark = [
    pytest.mark.processes,
    pytest.mark.skipif(MAVPROXY is None, reason="MAVProxy is not installed; pip install -e .[test] brings it"),
]
COPTER = ("merlin", "multicopter", "ardupilot")
MISSION_S = 120.0
"""Real seconds within which the agent ends its mission on a busy machine."""
RATES_HZ = {245: 10.0, 246: 2.0}
"""At which the stations, by their system ids, ask for the position."""


@contextmanager
def agent(drive: Drive, zenoh_port: int) -> Iterator[subprocess.Popen[str]]:
    """The agent program at work on the first vehicle; it ends by itself after landing."""
    options = ["--vehicle", "merlin", "--run-dir", str(drive.folder), "--exit-when-done"]
    ports = ["--mavlink-port", str(drive.port), "--zenoh-port", str(zenoh_port)]
    process = subprocess.Popen(
        [sys.executable, "-m", "vehicle_agent.cli", str(drive.folder / "mission.toml"), *options, *ports],
        stdout=subprocess.PIPE, stderr=(drive.folder / "agent.log").open("w"), text=True,
    )  # fmt: skip
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        yield process
    finally:
        process.kill()
        process.wait()


async def intervals_ms(system: System, count: int) -> list[int]:
    """Simulated milliseconds between positions as a station gets them."""
    stamps: list[int] = []

    def note(message: Any) -> bool:
        stamps.append(json.loads(message.fields_json)["time_boot_ms"])
        return len(stamps) > count

    await first(MavlinkDirect(system).subscribe_message("GLOBAL_POSITION_INT"), note)
    return [late - early for early, late in itertools.pairwise(stamps)]


async def test_an_agent_two_stations_and_mavproxy_on_one_vehicle(tmp_path: Path, free_port_base: int) -> None:
    """The agent flies its mission; the stations watch at rates of their own; MAVProxy loads, lists and sets."""
    extra = "[stop]\nobserved_fraction = 0.99"
    where = {"ground_m": 10.0, "speedup": 5.0, "size_m": 450.0, "scan_period_s": 1.0}
    with simulated(tmp_path, free_port_base, COPTER, extra=extra, **where) as drive:
        assert MAVPROXY is not None
        command = [sys.executable, MAVPROXY, f"--master=tcp:127.0.0.1:{drive.port}", "--source-system=255"]
        async with (
            mavsdk(drive.url(), 245) as station,
            mavsdk(f"udpout://127.0.0.1:{drive.port}", 246) as other,
        ):
            for system, rate_hz in zip((station, other), RATES_HZ.values(), strict=True):
                await Telemetry(system).set_rate_position(rate_hz)
                await Telemetry(system).set_rate_landed_state(2.0)
            with on_terminal(command, tmp_path) as terminal, agent(drive, free_port_base) as flying:
                in_air = Telemetry(station).subscribe_in_air()
                await asyncio.to_thread(terminal.expect, r"Received \d+ parameters", 60.0)
                await first(in_air, bool)
                for system, rate_hz in zip((station, other), RATES_HZ.values(), strict=True):
                    steady = sorted(await intervals_ms(system, 10))
                    assert steady[len(steady) // 2] == 1000 / rate_hz
                await Param(other).set_param_int("LOG_FILE_TIMEOUT", 7)
                assert await Param(station).get_param_int("LOG_FILE_TIMEOUT") == 7
                assert await MissionRaw(other).download_mission() == []
                terminal.type("param set FENCE_RADIUS 432")
                await asyncio.to_thread(terminal.ask_until, "param show FENCE_RADIUS", r"FENCE_RADIUS\s+432")
                terminal.type("wp list")
                await asyncio.to_thread(terminal.expect, "Requesting 0 waypoints|No waypoints|Saved 0")
                assert await asyncio.to_thread(flying.wait, MISSION_S) == 0
                await asyncio.to_thread(terminal.expect, "DISARMED")
                for system in (station, other):
                    await first(Telemetry(system).subscribe_armed(), lambda armed: not armed)
        truth = drive.stop()["merlin"]
    result = json.loads((tmp_path / "merlin" / "result.json").read_text())
    assert result["stage"] == "done"
    assert truth["has_flown"]
    assert not truth["crashed"]
    assert truth["distance_from_home_m"] < 3.0
