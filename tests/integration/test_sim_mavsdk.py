"""MAVSDK, which shares no code with the simulator, flies a simulated copter over real sockets."""

from __future__ import annotations

import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from mavsdk.asyncio import System
from mavsdk.asyncio.plugins.action import ActionAsync as Action
from mavsdk.asyncio.plugins.param import ParamAsync as Param
from mavsdk.asyncio.plugins.telemetry import TelemetryAsync as Telemetry

from sim_bridge.autopilot.dialect import mavlink, new_codec
from tests.fakes.simulator import DEADLINE_S, Drive, first, mavsdk, meanwhile, patient, simulated, watch, write_mission

pytestmark = pytest.mark.processes

SPEEDUP = 10.0
CONTROLLER_ID, OTHER_ID = 101, 201
COPTER = ("merlin", "multicopter", "ardupilot")


@pytest.fixture
def drive(tmp_path: Path, free_port_base: int) -> Iterator[Drive]:
    with simulated(tmp_path, free_port_base, COPTER, ground_m=350.0, speedup=SPEEDUP) as running:
        yield running


async def ready(telemetry: Telemetry) -> None:
    await watch(telemetry)
    await first(telemetry.subscribe_health_all_ok(), bool)


async def arm_and_climb(system: System, height_m: float) -> None:
    action, telemetry = Action(system), Telemetry(system)
    await patient(Param(system))
    await action.set_takeoff_altitude(height_m)
    await action.arm()
    await action.takeoff()
    await first(telemetry.subscribe_position(), lambda p: p.relative_altitude_m > height_m - 1.0)


async def test_a_flight_from_arming_to_disarming(drive: Drive) -> None:
    async with mavsdk(drive.url(), CONTROLLER_ID, 191) as system:
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

        async with meanwhile(telemetry.subscribe_velocity_ned(), lambda v: v.north_m_s < -5.0):
            await action.goto_location(home.latitude_deg - 0.002, home.longitude_deg, 390.0, 0.0)
        await action.hold()
        await first(telemetry.subscribe_velocity_ned(), lambda v: abs(v.north_m_s) < 0.05)
        await action.return_to_launch()
        await first(telemetry.subscribe_armed(), lambda armed: not armed)
        landed = await first(telemetry.subscribe_position(), lambda _: True)
        assert landed.latitude_deg == pytest.approx(home.latitude_deg, abs=5e-6)
    vehicle = drive.stop()["merlin"]
    assert vehicle["has_flown"]
    assert not vehicle["armed"]
    assert not vehicle["crashed"]
    assert vehicle["distance_from_home_m"] < 1.0


async def test_a_client_that_dies_mid_flight_disturbs_nobody(drive: Drive) -> None:
    """Neither one that vanishes nor one that never reads."""
    mute = socket.create_connection(("127.0.0.1", drive.port))
    codec = new_codec(OTHER_ID, 190)
    mute.sendall(mavlink.MAVLink_request_data_stream_message(1, 1, 0, 50, 1).pack(codec))
    try:
        async with mavsdk(f"udpout://127.0.0.1:{drive.port}", CONTROLLER_ID, 191) as system:
            telemetry = Telemetry(system)
            await ready(telemetry)
            async with mavsdk(drive.url(), OTHER_ID, 191) as other:
                await watch(Telemetry(other))
                await arm_and_climb(system, 20.0)
                await first(Telemetry(other).subscribe_in_air(), bool)
            async with mavsdk(drive.url(), OTHER_ID, 191) as again:
                await watch(Telemetry(again))
                await first(Telemetry(again).subscribe_in_air(), bool)
            await Action(system).land()
            await first(telemetry.subscribe_armed(), lambda armed: not armed)
    finally:
        mute.close()
    assert not drive.stop()["merlin"]["crashed"]


async def test_the_vehicle_returns_when_its_controller_falls_silent(drive: Drive) -> None:
    async with mavsdk(drive.url(), OTHER_ID, 191) as observer:
        telemetry = Telemetry(observer)
        await watch(telemetry)
        async with (
            meanwhile(telemetry.subscribe_status_text(), lambda status: "GCS Failsafe" in status.text),
            mavsdk(drive.url(), CONTROLLER_ID, 191) as system,
        ):
            await ready(Telemetry(system))
            param = Param(system)
            await param.set_param_int("SYSID_MYGCS", CONTROLLER_ID)
            # MAVSDK heartbeats once per real second, the vehicle counts simulated ones.
            await param.set_param_float("FS_GCS_TIMEOUT", 5.0 * SPEEDUP)
            await param.set_param_int("FS_GCS_ENABLE", 1)
            await arm_and_climb(system, 20.0)
        await first(telemetry.subscribe_armed(), lambda armed: not armed)
    vehicle = drive.stop()["merlin"]
    assert vehicle["mode"] == "RTL"
    assert vehicle["has_flown"]
    assert vehicle["distance_from_home_m"] < 1.0


def test_a_port_in_use_is_one_sentence(tmp_path: Path, free_port_base: int) -> None:
    mission = write_mission(tmp_path, COPTER)
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
