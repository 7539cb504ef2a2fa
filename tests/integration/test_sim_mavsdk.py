"""MAVSDK, which shares no code with the simulator, flies a simulated copter over real sockets."""

from __future__ import annotations

import asyncio
import json
import socket
import subprocess
import sys
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from mavsdk.asyncio import Configuration, Mavsdk, System
from mavsdk.asyncio.plugins.action import ActionAsync as Action
from mavsdk.asyncio.plugins.param import ParamAsync as Param
from mavsdk.asyncio.plugins.telemetry import TelemetryAsync as Telemetry

from sim_bridge.autopilot.dialect import mavlink, new_codec

pytestmark = pytest.mark.processes

DEADLINE_S = 30.0
SPEEDUP = 10.0
CONTROLLER_ID, OTHER_ID = 101, 201
MISSION = """
format = 1
name = "sim-test"
seed = 3

[datum]
latitude_deg = 36.57
longitude_deg = -84.27
altitude_amsl_m = 300.0

[area]
cell_m = 20.0
rectangle_enu_m = [0.0, 0.0, 1000.0, 1000.0]

[terrain]
kind = "flat"
elevation_amsl_m = 350.0

[task]
kind = "explore"

[[vehicles]]
name = "merlin"
start_enu_m = [200.0, 200.0]
speed_m_s = 15.0
sensor = { kind = "range", range_m = 200.0 }
min_above_terrain_m = 30.0
max_above_terrain_m = 150.0

[simulation]
ready_after_s = 5.0
"""


@dataclass
class Simulator:
    """A running `sim-bridge`."""

    process: subprocess.Popen[str]
    port: int
    run_dir: Path

    def stop(self) -> dict[str, Any]:
        self.process.terminate()
        assert self.process.wait(20) == 0
        result: dict[str, Any] = json.loads((self.run_dir / "sim_result.json").read_text())
        return result


@pytest.fixture
def simulator(tmp_path: Path, free_port_base: int) -> Iterator[Simulator]:
    mission = tmp_path / "mission.toml"
    mission.write_text(MISSION)
    port = free_port_base + 100
    options = {"--speedup": SPEEDUP, "--mavlink-port": port, "--zenoh-port": free_port_base, "--run-dir": tmp_path}
    arguments = [str(text) for pair in options.items() for text in pair]
    process = subprocess.Popen(
        [sys.executable, "-m", "sim_bridge.cli", str(mission), *arguments], stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        yield Simulator(process, port, tmp_path)
    finally:
        process.kill()
        process.wait()


@asynccontextmanager
async def connected(url: str, system_id: int) -> AsyncIterator[System]:
    async with Mavsdk(Configuration.create_manual(system_id, 191, True)) as mavsdk:
        await mavsdk.add_any_connection(url)
        system = await mavsdk.first_autopilot(timeout_s=DEADLINE_S)
        assert system is not None
        yield system


async def first(stream: AsyncIterator[Any], wanted: Any) -> Any:
    """First item of a stream that satisfies `wanted`."""
    async with asyncio.timeout(DEADLINE_S):
        async for item in stream:
            if wanted(item):
                return item
    raise AssertionError("the stream ended")


async def watch(telemetry: Telemetry) -> None:
    """Ask for the streams that MAVSDK's telemetry needs; it asks for none by itself."""
    await telemetry.set_rate_position(10.0)
    await telemetry.set_rate_velocity_ned(10.0)
    await telemetry.set_rate_landed_state(10.0)
    await telemetry.set_rate_battery(2.0)
    await telemetry.set_rate_home(2.0)
    await telemetry.set_rate_health(5.0)


async def ready(telemetry: Telemetry) -> None:
    await watch(telemetry)
    await first(telemetry.subscribe_health_all_ok(), bool)


async def arm_and_climb(system: System, height_m: float) -> None:
    action, telemetry = Action(system), Telemetry(system)
    await action.set_takeoff_altitude(height_m)
    await action.arm()
    await action.takeoff()
    await first(telemetry.subscribe_position(), lambda p: p.relative_altitude_m > height_m - 1.0)


async def test_a_flight_from_arming_to_disarming(simulator: Simulator) -> None:
    async with connected(f"tcpout://127.0.0.1:{simulator.port}", CONTROLLER_ID) as system:
        action, telemetry, param = Action(system), Telemetry(system), Param(system)
        await ready(telemetry)
        for name, value in (("SYSID_MYGCS", CONTROLLER_ID), ("RTL_ALT", 4000)):
            await param.set_param_int(name, value)
            assert await param.get_param_int(name) == value
        await param.set_param_float("WPNAV_SPEED", 1500.0)
        home = await first(telemetry.subscribe_home(), lambda _: True)
        assert home.absolute_altitude_m == pytest.approx(350.0, abs=0.01)
        battery = await first(telemetry.subscribe_battery(), lambda _: True)
        assert battery.remaining_percent == pytest.approx(100.0, abs=1.0)

        await arm_and_climb(system, 30.0)
        north_deg = home.latitude_deg + 0.001
        await action.goto_location(north_deg, home.longitude_deg, 390.0, 0.0)
        there = await first(
            telemetry.subscribe_position(),
            lambda p: abs(p.latitude_deg - north_deg) < 2e-6 and abs(p.absolute_altitude_m - 390.0) < 0.3,
        )
        assert there.longitude_deg == pytest.approx(home.longitude_deg, abs=1e-6)

        await action.goto_location(home.latitude_deg, home.longitude_deg, 390.0, 0.0)
        await first(telemetry.subscribe_velocity_ned(), lambda v: v.north_m_s < -5.0)
        await action.hold()
        await first(telemetry.subscribe_velocity_ned(), lambda v: abs(v.north_m_s) < 0.05)
        await action.return_to_launch()
        await first(telemetry.subscribe_armed(), lambda armed: not armed)
        landed = await first(telemetry.subscribe_position(), lambda _: True)
        assert landed.latitude_deg == pytest.approx(home.latitude_deg, abs=5e-6)
    vehicle = simulator.stop()["vehicles"]["merlin"]
    assert vehicle["has_flown"]
    assert not vehicle["armed"]
    assert not vehicle["crashed"]
    assert vehicle["distance_from_home_m"] < 1.0


async def test_a_client_that_dies_mid_flight_disturbs_nobody(simulator: Simulator) -> None:
    """Neither one that vanishes nor one that never reads."""
    mute = socket.create_connection(("127.0.0.1", simulator.port))
    codec = new_codec(OTHER_ID, 190)
    mute.sendall(mavlink.MAVLink_request_data_stream_message(1, 1, 0, 50, 1).pack(codec))
    try:
        async with connected(f"udpout://127.0.0.1:{simulator.port}", CONTROLLER_ID) as system:
            telemetry = Telemetry(system)
            await ready(telemetry)
            async with connected(f"tcpout://127.0.0.1:{simulator.port}", OTHER_ID) as other:
                await watch(Telemetry(other))
                await arm_and_climb(system, 20.0)
                await first(Telemetry(other).subscribe_in_air(), bool)
            async with connected(f"tcpout://127.0.0.1:{simulator.port}", OTHER_ID) as again:
                await watch(Telemetry(again))
                await first(Telemetry(again).subscribe_in_air(), bool)
            await Action(system).land()
            await first(telemetry.subscribe_armed(), lambda armed: not armed)
    finally:
        mute.close()
    assert not simulator.stop()["vehicles"]["merlin"]["crashed"]


async def test_the_vehicle_returns_when_its_controller_falls_silent(simulator: Simulator) -> None:
    async with connected(f"tcpout://127.0.0.1:{simulator.port}", OTHER_ID) as observer:
        telemetry = Telemetry(observer)
        await watch(telemetry)
        async with connected(f"tcpout://127.0.0.1:{simulator.port}", CONTROLLER_ID) as system:
            await ready(Telemetry(system))
            param = Param(system)
            await param.set_param_int("SYSID_MYGCS", CONTROLLER_ID)
            # MAVSDK heartbeats once per real second, the vehicle counts simulated ones.
            await param.set_param_float("FS_GCS_TIMEOUT", 3.0 * SPEEDUP)
            await param.set_param_int("FS_GCS_ENABLE", 1)
            await arm_and_climb(system, 20.0)
            texts = telemetry.subscribe_status_text()
            announced = asyncio.create_task(first(texts, lambda status: "GCS Failsafe" in status.text))
        await announced
        await first(telemetry.subscribe_armed(), lambda armed: not armed)
    vehicle = simulator.stop()["vehicles"]["merlin"]
    assert vehicle["mode"] == "RTL"
    assert vehicle["has_flown"]
    assert vehicle["distance_from_home_m"] < 1.0


def test_a_port_in_use_is_one_sentence(tmp_path: Path, free_port_base: int) -> None:
    mission = tmp_path / "mission.toml"
    mission.write_text(MISSION)
    port = free_port_base + 100
    with socket.create_server(("127.0.0.1", port)):
        done = subprocess.run(
            [sys.executable, "-m", "sim_bridge.cli", str(mission), "--mavlink-port", str(port),
             "--zenoh-port", str(free_port_base)],
            capture_output=True, text=True, timeout=DEADLINE_S, check=False,
        )  # fmt: skip
    assert done.returncode == 2
    assert str(port) in done.stderr
    assert done.stderr.count("\n") == 1
