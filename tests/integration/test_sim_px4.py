"""MAVSDK flies a simulated PX4 over real sockets: packed modes, bytewise parameters, take-off height, offboard."""

from __future__ import annotations

from pathlib import Path

import pytest
from mavsdk.asyncio.plugins.action import ActionAsync as Action
from mavsdk.asyncio.plugins.offboard import OffboardAsync as Offboard
from mavsdk.asyncio.plugins.param import ParamAsync as Param
from mavsdk.asyncio.plugins.telemetry import TelemetryAsync as Telemetry
from mavsdk.plugins.offboard import VelocityNedYaw

from tests.fakes.simulator import armable, first, mavsdk, simulated

pytestmark = pytest.mark.processes


async def test_px4_from_arming_to_disarming(tmp_path: Path, free_port_base: int) -> None:
    with simulated(tmp_path, free_port_base, ("gull", "multicopter", "px4")) as drive:
        async with mavsdk(drive.url()) as system:
            action, telemetry, param = Action(system), Telemetry(system), Param(system)
            home = await armable(telemetry)
            assert await param.get_param_int("MAV_SYS_ID") == 1
            await param.set_param_int("COM_OBL_RC_ACT", 3)
            assert await param.get_param_int("COM_OBL_RC_ACT") == 3
            # As many simulated seconds pass quickly while a busy machine does something else.
            await param.set_param_float("COM_OF_LOSS_T", 50.0)
            await param.set_param_float("COM_DISARM_PRFLT", -1.0)
            await action.set_takeoff_altitude(15.0)
            assert await action.get_takeoff_altitude() == pytest.approx(15.0)
            await action.arm()
            await action.takeoff()
            await first(telemetry.subscribe_position(), lambda p: p.relative_altitude_m > 14.0)
            await first(telemetry.subscribe_flight_mode(), lambda mode: mode.name == "HOLD")

            north_deg = home.latitude_deg + 0.0003
            await action.goto_location(north_deg, home.longitude_deg, home.absolute_altitude_m + 20.0, 0.0)
            await first(telemetry.subscribe_position(), lambda p: abs(p.latitude_deg - north_deg) < 3e-6)
            await action.hold()

            offboard = Offboard(system)
            await offboard.set_velocity_ned(VelocityNedYaw(0.0, 3.0, 0.0, 0.0))
            await offboard.start()
            await first(telemetry.subscribe_velocity_ned(), lambda v: v.east_m_s > 2.5)
            await offboard.stop()
            await action.return_to_launch()
            await first(telemetry.subscribe_flight_mode(), lambda mode: mode.name == "RETURN_TO_LAUNCH")
            await first(telemetry.subscribe_armed(), lambda armed: not armed)
        truth = drive.stop()["gull"]
    assert truth["has_flown"]
    assert not truth["crashed"]
    assert truth["distance_from_home_m"] < 1.0
