"""Scripts of the kind that people write with pymavlink's mavutil drive a copter, a boat and an underwater vehicle."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

os.environ.setdefault("MAVLINK20", "1")

import pytest
from pymavlink import mavutil, mavwp

from tests.fakes.simulator import DEADLINE_S, simulated

pytestmark = pytest.mark.processes

mavlink = mavutil.mavlink


class Script:
    """A connection and the handful of helpers that such scripts have."""

    def __init__(self, url: str) -> None:
        self.link = mavutil.mavlink_connection(url, source_system=250, source_component=190, autoreconnect=False)
        assert self.link.wait_heartbeat(timeout=DEADLINE_S) is not None
        self.link.mav.request_data_stream_send(self.link.target_system, 1, mavlink.MAV_DATA_STREAM_ALL, 10, 1)

    def wait(self, kind: str, wanted: Callable[[Any], bool] = lambda message: True) -> Any:
        end_s = time.monotonic() + DEADLINE_S
        while time.monotonic() < end_s:
            message = self.link.recv_match(type=kind, blocking=True, timeout=1.0)
            if message is not None and wanted(message):
                return message
        raise AssertionError(f"no such {kind}")

    def command(self, number: int, *values: float) -> int:
        self.link.mav.command_long_send(
            self.link.target_system, 1, number, 0, *values, *[0.0] * (7 - len(values))
        )  # fmt: skip
        return int(self.wait("COMMAND_ACK", lambda ack: ack.command == number).result)

    def set_parameter(self, name: str, value: float) -> None:
        self.link.param_set_send(name, value)
        self.wait("PARAM_VALUE", lambda p: p.param_id == name and abs(p.param_value - value) < 1e-3)

    def until_armable(self) -> Any:
        prearm = mavlink.MAV_SYS_STATUS_PREARM_CHECK
        self.wait("SYS_STATUS", lambda status: status.onboard_control_sensors_health & prearm)
        return self.wait("GLOBAL_POSITION_INT", lambda position: position.lat != 0)

    def set_mode(self, name: str) -> None:
        number = self.link.mode_mapping()[name]
        self.link.set_mode(number)
        self.wait("HEARTBEAT", lambda beat: beat.get_srcComponent() == 1 and beat.custom_mode == number)

    def arm(self) -> None:
        self.link.arducopter_arm()
        self.link.motors_armed_wait()

    def go_to(self, start: Any, north_m: float, up_m: float) -> None:
        self.link.mav.set_position_target_global_int_send(
            0, self.link.target_system, 1, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT, 0x0DF8,
            start.lat + round(north_m * 90), start.lon, up_m, 0, 0, 0, 0, 0, 0, 0, 0,
        )  # fmt: skip

    def reached(self, start: Any, north_m: float, up_m: float | None = None) -> None:
        def there(position: Any) -> bool:
            level = up_m is None or abs(position.relative_alt / 1000.0 - up_m) < 1.5
            return abs(position.lat - start.lat - north_m * 90) < 5.0 * 90 and level

        self.wait("GLOBAL_POSITION_INT", there)

    def upload(self, start: Any, *waypoints: tuple[float, float]) -> None:
        """Load waypoints (metres north of the start, metres up) with pymavlink's own loader."""
        loader = mavwp.MAVWPLoader()
        for number, (north_m, up_m) in enumerate([(0.0, 0.0), *waypoints]):
            loader.add(
                mavlink.MAVLink_mission_item_int_message(
                    self.link.target_system, 1, number, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT,
                    mavlink.MAV_CMD_NAV_WAYPOINT, 0, 1, 0, 0, 0, 0, start.lat + round(north_m * 90), start.lon, up_m,
                )
            )  # fmt: skip
        self.link.mav.mission_count_send(self.link.target_system, 1, loader.count(), 0)
        while True:
            asked = self.link.recv_match(
                type=["MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_ACK"], blocking=True, timeout=DEADLINE_S
            )
            assert asked is not None
            if asked.get_type() == "MISSION_ACK":
                assert asked.type == mavlink.MAV_MISSION_ACCEPTED
                return
            self.link.mav.send(loader.item(asked.seq))


@contextmanager
def script(url: str) -> Iterator[Script]:
    one = Script(url)
    try:
        yield one
    finally:
        one.link.close()


def mavutil_url(url: str) -> str:
    return url.replace("tcpout://", "tcp:")


def test_a_script_flies_a_copter(tmp_path: Path, free_port_base: int) -> None:
    team = ("merlin", "multicopter", "ardupilot")
    with simulated(tmp_path, free_port_base, team, ground_m=10.0) as drive, script(mavutil_url(drive.url())) as pilot:
        start = pilot.until_armable()
        for name, value in (("RTL_ALT", 2000), ("DISARM_DELAY", 120)):
            pilot.set_parameter(name, value)
        pilot.set_mode("GUIDED")
        pilot.arm()
        assert pilot.command(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, 15.0) == mavlink.MAV_RESULT_ACCEPTED
        pilot.reached(start, 0.0, 15.0)
        pilot.go_to(start, 30.0, 20.0)
        pilot.reached(start, 30.0, 20.0)
        pilot.upload(start, (10.0, 25.0), (40.0, 25.0))
        pilot.set_mode("AUTO")
        pilot.wait("MISSION_ITEM_REACHED", lambda told: told.seq == 2)
        pilot.set_mode("RTL")
        pilot.link.motors_disarmed_wait()
        truth = drive.stop()["merlin"]
    assert not truth["crashed"]
    assert truth["distance_from_home_m"] < 1.0
    log = mavutil.mavlink_connection(str(tmp_path / "merlin.tlog"))
    kept = list(iter(log.recv_msg, None))
    assert not [message for message in kept if message.get_type() == "BAD_DATA"]
    assert {message.get_type() for message in kept} >= {"HEARTBEAT", "COMMAND_LONG", "MISSION_ITEM_INT", "PARAM_SET"}
    last = [message for message in kept if message.get_type() == "SYSTEM_TIME"][-1]
    assert last._timestamp == pytest.approx(last.time_unix_usec * 1e-6, abs=1e-3)
    log.close()


def test_a_script_steers_a_boat(tmp_path: Path, free_port_base: int) -> None:
    team = ("tern", "surface-vessel", "ardupilot")
    with simulated(tmp_path, free_port_base, team) as drive, script(mavutil_url(drive.url())) as pilot:
        start = pilot.until_armable()
        pilot.set_parameter("WP_SPEED", 4.0)
        pilot.set_mode("GUIDED")
        pilot.arm()
        pilot.go_to(start, 30.0, 0.0)
        pilot.reached(start, 30.0)
        pilot.upload(start, (50.0, 0.0), (20.0, 0.0))
        pilot.set_mode("AUTO")
        pilot.wait("MISSION_ITEM_REACHED", lambda told: told.seq == 2)
        pilot.set_mode("RTL")
        pilot.reached(start, 0.0)
        pilot.link.arducopter_disarm()
        pilot.link.motors_disarmed_wait()
        assert not drive.stop()["tern"]["crashed"]


def test_a_script_dives_and_a_leak_brings_the_vehicle_up(tmp_path: Path, free_port_base: int) -> None:
    team = ("seal", "underwater-vehicle", "ardupilot")
    with simulated(tmp_path, free_port_base, team) as drive, script(mavutil_url(drive.url())) as pilot:
        start = pilot.until_armable()
        for name, value in (("WPNAV_SPEED_DN", 150), ("WPNAV_SPEED_UP", 150), ("FS_LEAK_ENABLE", 2)):
            pilot.set_parameter(name, value)
        pilot.set_mode("GUIDED")
        pilot.arm()
        pilot.go_to(start, 10.0, -10.0)
        pilot.reached(start, 10.0, -10.0)
        pilot.set_mode("ALT_HOLD")
        endpoint = f"127.0.0.1:{drive.port - 1}"
        done = subprocess.run(
            [sys.executable, "-m", "sim_bridge.cli", "inject", "seal", "leak", "--endpoint", endpoint],
            capture_output=True, text=True, timeout=DEADLINE_S, check=False,
        )  # fmt: skip
        assert (done.returncode, done.stdout) == (0, "seal: leak set\n")
        pilot.wait("STATUSTEXT", lambda status: "Leak Detected" in status.text)
        pilot.wait("GLOBAL_POSITION_INT", lambda position: position.relative_alt > -200)
        pilot.link.arducopter_disarm()
        pilot.link.motors_disarmed_wait()
        assert not drive.stop()["seal"]["crashed"]


def test_a_lost_link_comes_back(tmp_path: Path, free_port_base: int) -> None:
    team = ("merlin", "multicopter", "ardupilot")
    lost = '[[simulation.faults]]\nat_s = 50.0\nvehicle = "merlin"\nfault = "link-loss"\nfor_s = 20.0'
    with simulated(tmp_path, free_port_base, team, extra=lost) as drive, script(mavutil_url(drive.url())) as pilot:
        before = pilot.wait("SYSTEM_TIME", lambda told: told.time_boot_ms > 49_000)
        after = pilot.wait("SYSTEM_TIME", lambda told: told.time_boot_ms > 51_000)
        assert after.time_boot_ms - before.time_boot_ms > 18_000


def test_an_order_to_nobody_says_so() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "sim_bridge.cli", "inject", "seal", "leak", "--endpoint", "127.0.0.1:1"],
        capture_output=True, text=True, timeout=DEADLINE_S, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert "127.0.0.1:1" in done.stderr
    assert done.stderr.count("\n") == 1
