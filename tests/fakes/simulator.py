"""A running `sim-bridge` program, and MAVSDK as people use it, for end-to-end drives."""

from __future__ import annotations

import asyncio
import json
import subprocess
import sys
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mavsdk.asyncio import Configuration, Mavsdk, System
from mavsdk.asyncio.plugins.param import ParamAsync as Param
from mavsdk.asyncio.plugins.telemetry import TelemetryAsync as Telemetry

DEADLINE_S = 40.0
HEAD = """
format = 1
name = "sim-drive"
seed = 3

[datum]
latitude_deg = 41.18
longitude_deg = -8.7

[area]
cell_m = 20.0
rectangle_enu_m = [0.0, 0.0, {size_m}, {size_m}]

[terrain]
kind = "flat"
elevation_amsl_m = {ground_m}

[task]
kind = "explore"
"""
VEHICLE = """
[[vehicles]]
name = "{name}"
type = "{type}"
autopilot = "{autopilot}"
start_enu_m = [{east_m}, 200.0]
speed_m_s = 10.0
sensor = {{ kind = "range", range_m = 200.0, period_s = {scan_period_s} }}
min_above_terrain_m = 10.0
max_above_terrain_m = 150.0
"""


@dataclass(frozen=True)
class Drive:
    """A running simulator.

    Attributes
    ----------
    port
        First MAVLink port; vehicle n listens on `port + 10 n`.
    """

    process: subprocess.Popen[str]
    port: int
    folder: Path

    def url(self, index: int = 0) -> str:
        return f"tcpout://127.0.0.1:{self.port + 10 * index}"

    def stop(self) -> dict[str, Any]:
        """End it and return the truth that it leaves behind, per vehicle."""
        self.process.terminate()
        assert self.process.wait(20) == 0
        result: dict[str, Any] = json.loads((self.folder / "sim_result.json").read_text())["vehicles"]
        return result


def write_mission(
    folder: Path,
    *team: tuple[str, str, str],
    ground_m: float = -30.0,
    speedup: float = 8.0,
    extra: str = "",
    size_m: float = 1000.0,
    scan_period_s: float = 3600.0,
) -> Path:
    """A mission file for a team of (name, type, autopilot); `extra` ends it, inside [simulation]."""
    text = HEAD.format(ground_m=ground_m, size_m=size_m)
    for number, (name, kind, autopilot) in enumerate(team):
        text += VEHICLE.format(
            name=name, type=kind, autopilot=autopilot, east_m=200.0 + 40.0 * number, scan_period_s=scan_period_s
        )
    mission = folder / "mission.toml"
    mission.write_text(text + f"\n[simulation]\nready_after_s = 4.0\nspeedup = {speedup}\n{extra}\n")
    return mission


@contextmanager
def simulated(folder: Path, port_base: int, *team: tuple[str, str, str], **changes: Any) -> Iterator[Drive]:
    """Run a team of (name, type, autopilot); `changes` are those of `write_mission`."""
    mission = write_mission(folder, *team, **changes)
    port = port_base + 100
    options = {"--mavlink-port": port, "--zenoh-port": port_base, "--run-dir": folder, "--tlog-dir": folder}
    arguments = [str(text) for pair in options.items() for text in pair]
    process = subprocess.Popen(
        [sys.executable, "-m", "sim_bridge.cli", str(mission), *arguments], stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        yield Drive(process, port, folder)
    finally:
        process.kill()
        process.wait()


@asynccontextmanager
async def mavsdk(url: str, system_id: int = 245, component_id: int = 190) -> AsyncIterator[System]:
    """A MAVSDK client that is connected to the one autopilot behind a URL."""
    async with Mavsdk(Configuration.create_manual(system_id, component_id, True)) as client:
        await client.add_any_connection(url)
        system = await client.first_autopilot(timeout_s=DEADLINE_S)
        assert system is not None
        yield system


async def first(stream: AsyncIterator[Any], wanted: Callable[[Any], bool] = lambda _: True) -> Any:
    """First item of a stream that satisfies `wanted`."""
    async with asyncio.timeout(DEADLINE_S):
        async for item in stream:
            if wanted(item):
                return item
    raise AssertionError("the stream ended")


@asynccontextmanager
async def meanwhile(stream: AsyncIterator[Any], wanted: Callable[[Any], bool]) -> AsyncIterator[None]:
    """Listen while the orders of the block are given, and wait after it until something wanted has been heard.

    What passes quickly is then not missed on a machine that is slow to run the next line.
    """
    heard = asyncio.create_task(first(stream, wanted))
    await asyncio.sleep(0)  # lets it subscribe
    try:
        yield
    except BaseException:
        heard.cancel()
        raise
    await heard


async def patient(param: Param) -> None:
    """Keep a copter from disarming between two lines of a test that count as many simulated seconds."""
    await param.set_param_int("DISARM_DELAY", 120)


async def watch(telemetry: Telemetry) -> None:
    """Ask for the streams that MAVSDK's telemetry needs; it asks for none by itself."""
    await telemetry.set_rate_position(10.0)
    await telemetry.set_rate_velocity_ned(10.0)
    await telemetry.set_rate_landed_state(10.0)
    await telemetry.set_rate_battery(2.0)
    await telemetry.set_rate_home(2.0)
    await telemetry.set_rate_health(10.0)


async def armable(telemetry: Telemetry) -> Any:
    """Wait until the vehicle would arm; returns its home."""
    await watch(telemetry)
    await first(telemetry.subscribe_health(), lambda health: health.is_armable and health.is_home_position_ok)
    return await first(telemetry.subscribe_home())
