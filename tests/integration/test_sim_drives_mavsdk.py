"""MAVSDK drives a copter, a boat and an underwater vehicle from connecting to disarming, over real sockets."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from mavsdk.asyncio import System
from mavsdk.asyncio.plugins.action import ActionAsync as Action
from mavsdk.asyncio.plugins.mavlink_direct import MavlinkDirectAsync as MavlinkDirect
from mavsdk.asyncio.plugins.mission_raw import MissionRawAsync as MissionRaw
from mavsdk.asyncio.plugins.param import ParamAsync as Param
from mavsdk.asyncio.plugins.telemetry import TelemetryAsync as Telemetry
from mavsdk.plugins.mavlink_direct import MavlinkMessage
from mavsdk.plugins.mission_raw import MissionItem

from tests.fakes.simulator import armable, first, mavsdk, meanwhile, patient, simulated

pytestmark = pytest.mark.processes

WAYPOINT, RETURN, TAKE_OFF, FENCE_CIRCLE = 16, 20, 22, 5003
ABOVE_HOME = 3
SUB_AUTO, SUB_GUIDED, SUB_SURFACE, SUB_POSITION_HOLD = 3, 4, 9, 16


def item(
    seq: int, command: int, home: Any, north_m: float, up_m: float, kind: int = 0, first_value: float = 0.0
) -> Any:
    """A mission or fence item so far north of home and so high above it."""
    latitude_deg = home.latitude_deg + north_m / 111_100.0
    return MissionItem(
        seq, ABOVE_HOME, command, int(seq == 0 and kind == 0), 1, first_value, 0.0, 0.0, 0.0,
        round(latitude_deg * 1e7), round(home.longitude_deg * 1e7), up_m, kind,
    )  # fmt: skip


def near(home: Any, north_m: float, within_m: float = 5.0) -> Callable[[Any], bool]:
    """Tell of a position whether it lies as far north of home as a place."""
    goal_deg = home.latitude_deg + north_m / 111_100.0
    return lambda position: abs(position.latitude_deg - goal_deg) * 111_100.0 < within_m


async def reached(telemetry: Telemetry, home: Any, north_m: float) -> None:
    await first(telemetry.subscribe_position(), near(home, north_m))


async def test_a_copter_flies_a_mission_inside_its_fence_and_turns_back_at_it(
    tmp_path: Path, free_port_base: int
) -> None:
    with simulated(tmp_path, free_port_base, ("merlin", "multicopter", "ardupilot"), ground_m=10.0) as drive:
        async with mavsdk(drive.url()) as system:
            action, telemetry, param, mission = Action(system), Telemetry(system), Param(system), MissionRaw(system)
            home = await armable(telemetry)
            items = [
                item(0, WAYPOINT, home, 0.0, 0.0),
                item(1, TAKE_OFF, home, 0.0, 15.0),
                item(2, WAYPOINT, home, 30.0, 20.0),
                item(3, WAYPOINT, home, 0.0, 20.0),
            ]
            await mission.upload_mission(items)
            assert [entry.command for entry in await mission.download_mission()] == [16, 22, 16, 16]
            await mission.upload_geofence([item(0, FENCE_CIRCLE, home, 0.0, 0.0, kind=1, first_value=60.0)])
            for name in ("FENCE_TYPE", "FENCE_ENABLE"):
                await param.set_param_int(name, 4 if name == "FENCE_TYPE" else 1)

            await patient(param)
            await action.set_takeoff_altitude(15.0)
            await action.arm()
            await action.takeoff()
            await first(telemetry.subscribe_position(), lambda p: p.relative_altitude_m > 14.0)
            async with meanwhile(telemetry.subscribe_position(), near(home, 30.0)):
                await mission.start_mission()
            await first(mission.subscribe_mission_progress(), lambda progress: progress.current >= 3)
            await reached(telemetry, home, 0.0)

            beyond_deg = home.latitude_deg + 200.0 / 111_100.0
            async with meanwhile(telemetry.subscribe_status_text(), lambda status: "fence breached" in status.text):
                await action.goto_location(beyond_deg, home.longitude_deg, home.absolute_altitude_m + 20.0, 0.0)
            await first(telemetry.subscribe_flight_mode(), lambda mode: mode.name == "RETURN_TO_LAUNCH")
            await first(telemetry.subscribe_armed(), lambda armed: not armed)
        truth = drive.stop()["merlin"]
    assert not truth["crashed"]
    assert truth["distance_from_home_m"] < 1.0


async def test_a_boat_steers_to_targets_and_through_a_mission(tmp_path: Path, free_port_base: int) -> None:
    extra = "current_m_s = [0.3, 0.0]"
    with simulated(tmp_path, free_port_base, ("tern", "surface-vessel", "ardupilot"), extra=extra) as drive:
        async with mavsdk(drive.url()) as system:
            action, telemetry, param, mission = Action(system), Telemetry(system), Param(system), MissionRaw(system)
            home = await armable(telemetry)
            await param.set_param_float("WP_SPEED", 4.0)
            assert await param.get_param_float("WP_SPEED") == pytest.approx(4.0)
            await action.arm()
            altitude_m = home.absolute_altitude_m
            await action.goto_location(home.latitude_deg + 40 / 111_100.0, home.longitude_deg, altitude_m, 0.0)
            await reached(telemetry, home, 40.0)
            await action.hold()
            await first(telemetry.subscribe_flight_mode(), lambda mode: mode.name == "HOLD")

            items = [item(0, WAYPOINT, home, 0.0, 0.0), *(item(n, WAYPOINT, home, 40.0 - 30 * n, 0.0) for n in (1, 2))]
            await mission.upload_mission(items)
            await mission.start_mission()
            await reached(telemetry, home, -20.0)
            await action.return_to_launch()
            await reached(telemetry, home, 0.0)
            await action.disarm()
            await first(telemetry.subscribe_armed(), lambda armed: not armed)
        truth = drive.stop()["tern"]
    assert truth["has_flown"]
    assert not truth["crashed"]
    assert truth["position_enu_m"][2] == 0.0
    # The current has carried it on since it was disarmed.
    assert truth["distance_from_home_m"] < 80.0


class Diver:
    """Orders for an underwater vehicle, for which MAVSDK's action plugin has no modes."""

    def __init__(self, system: System) -> None:
        self._direct = MavlinkDirect(system)

    async def _send(self, name: str, **fields: float) -> None:
        content = {"target_system": 1, "target_component": 1, **fields}
        await self._direct.send_message(MavlinkMessage(message_name=name, fields_json=json.dumps(content)))

    async def set_mode(self, number: int) -> None:
        values = {f"param{place}": 0.0 for place in range(3, 8)}
        await self._send("COMMAND_LONG", command=176, confirmation=0, param1=1.0, param2=float(number), **values)

    async def go_to(self, latitude_deg: float, longitude_deg: float, depth_m: float) -> None:
        await self._send(
            "SET_POSITION_TARGET_GLOBAL_INT", time_boot_ms=0, coordinate_frame=6, type_mask=0x0DF8,
            lat_int=round(latitude_deg * 1e7), lon_int=round(longitude_deg * 1e7), alt=-depth_m,
            vx=0.0, vy=0.0, vz=0.0, afx=0.0, afy=0.0, afz=0.0, yaw=0.0, yaw_rate=0.0,
        )  # fmt: skip


async def test_an_underwater_vehicle_dives_works_and_surfaces(tmp_path: Path, free_port_base: int) -> None:
    with simulated(tmp_path, free_port_base, ("seal", "underwater-vehicle", "ardupilot")) as drive:
        async with mavsdk(drive.url()) as system:
            action, telemetry, param, mission = Action(system), Telemetry(system), Param(system), MissionRaw(system)
            diver = Diver(system)
            home = await armable(telemetry)
            assert home.absolute_altitude_m == 0.0
            for name, value in (("WPNAV_SPEED", 200.0), ("WPNAV_SPEED_UP", 150.0), ("WPNAV_SPEED_DN", 150.0)):
                await param.set_param_float(name, value)
            await action.arm()
            await diver.set_mode(SUB_GUIDED)
            await first(telemetry.subscribe_flight_mode(), lambda mode: mode.name != "UNKNOWN")
            await diver.go_to(home.latitude_deg + 20 / 111_100.0, home.longitude_deg, 8.0)
            await first(telemetry.subscribe_position(), lambda p: p.relative_altitude_m < -7.5)
            await reached(telemetry, home, 20.0)
            await diver.set_mode(SUB_POSITION_HOLD)
            await first(telemetry.subscribe_velocity_ned(), lambda v: abs(v.north_m_s) < 0.1 and abs(v.down_m_s) < 0.1)

            await mission.upload_mission([
                item(0, WAYPOINT, home, 0.0, 0.0), item(1, WAYPOINT, home, 10.0, -12.0),
                item(2, WAYPOINT, home, 0.0, -4.0),
            ])  # fmt: skip
            async with meanwhile(telemetry.subscribe_position(), lambda p: p.relative_altitude_m < -10.0):
                await diver.set_mode(SUB_AUTO)
            await first(telemetry.subscribe_position(), lambda p: p.relative_altitude_m > -5.0)
            await diver.set_mode(SUB_SURFACE)
            await first(telemetry.subscribe_position(), lambda p: p.relative_altitude_m > -0.2)
            await action.disarm()
            await first(telemetry.subscribe_armed(), lambda armed: not armed)
        truth = drive.stop()["seal"]
    assert truth["has_flown"]
    assert not truth["crashed"]
    assert truth["position_enu_m"][2] == pytest.approx(0.0, abs=0.2)
