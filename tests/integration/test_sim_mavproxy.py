"""MAVProxy, driven through its terminal, flies a simulated copter, steers a boat and dives an underwater vehicle."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest

from tests.fakes.simulator import Drive, simulated
from tests.fakes.terminal import Terminal, on_terminal

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
BOAT_MISSION = """QGC WPL 110
0\t0\t0\t16\t0\t0\t0\t0\t41.181800\t-8.697614\t0\t1
1\t0\t3\t16\t0\t0\t0\t0\t41.182100\t-8.697614\t0\t1
2\t0\t3\t16\t0\t0\t0\t0\t41.181800\t-8.697614\t0\t1
"""
DIVE = """QGC WPL 110
0\t0\t0\t16\t0\t0\t0\t0\t41.181800\t-8.697136\t0\t1
1\t0\t3\t16\t0\t0\t0\t0\t41.181900\t-8.697136\t-9\t1
2\t0\t3\t16\t0\t0\t0\t0\t41.181900\t-8.697136\t-3\t1
"""
FENCE = """QGC WPL 110
0\t0\t0\t5003\t400\t0\t0\t0\t41.181800\t-8.697614\t0\t1
"""
RALLY = """QGC WPL 110
0\t0\t3\t5100\t0\t0\t0\t0\t41.181700\t-8.697614\t20\t1
"""


def mavproxy(drive: Drive, index: int = 0) -> list[str]:
    assert MAVPROXY is not None
    return [sys.executable, MAVPROXY, f"--master=tcp:127.0.0.1:{drive.port + 10 * index}", "--source-system=255"]


def load(terminal: Terminal, what: str, content: str, kind: str, folder: Path) -> None:
    """Load a mission, a fence or rally points and wait for the vehicle's yes."""
    (folder / f"{what}.txt").write_text(content)
    terminal.type(f"{what} load {what}.txt")
    terminal.expect(f"MISSION_ACK: TYPE_{kind}: ACCEPTED")


def test_a_flight_from_the_terminal(tmp_path: Path, free_port_base: int) -> None:
    with simulated(tmp_path, free_port_base, COPTER, ground_m=10.0, speedup=4.0) as drive:
        with on_terminal(mavproxy(drive), tmp_path) as terminal:
            terminal.expect(r"Received \d+ parameters", 60.0)
            terminal.ask_until("status SYS_STATUS", r"\d+: SYS_STATUS \{")
            for name, value in (("RTL_ALT", 2500), ("DISARM_DELAY", 120)):
                terminal.type(f"param set {name} {value}")
                terminal.ask_until(f"param show {name}", rf"{name}\s+{value}")
            load(terminal, "wp", MISSION, "MISSION", tmp_path)
            terminal.type("wp list")
            terminal.expect(r"Saved 4 waypoints")
            load(terminal, "fence", FENCE, "FENCE", tmp_path)
            terminal.type("fence list")
            terminal.expect("Saved 1 fence")
            load(terminal, "rally", RALLY, "RALLY", tmp_path)
            terminal.type("rally list")
            terminal.expect("Saved 1 rally")
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


def test_a_boat_and_an_underwater_vehicle_from_the_terminal(tmp_path: Path, free_port_base: int) -> None:
    """One after the other on one simulator: parameters, mission, fence, rally points, guided targets, home."""
    team = (("tern", "surface-vessel", "ardupilot"), ("seal", "underwater-vehicle", "ardupilot"))
    with simulated(tmp_path, free_port_base, *team) as drive:
        with on_terminal(mavproxy(drive), tmp_path) as terminal:
            terminal.expect(r"Received \d+ parameters", 60.0)
            terminal.type("param set WP_SPEED 4")
            terminal.ask_until("param show WP_SPEED", r"WP_SPEED\s+4")
            load(terminal, "wp", BOAT_MISSION, "MISSION", tmp_path)
            load(terminal, "fence", FENCE, "FENCE", tmp_path)
            load(terminal, "rally", RALLY, "RALLY", tmp_path)
            terminal.type("mode guided")
            terminal.expect("Mode GUIDED")
            terminal.type("arm throttle")
            terminal.expect("ARMED")
            terminal.type("guided 41.182100 -8.697614 0")
            terminal.ask_until("status GLOBAL_POSITION_INT", r"lat : 41182[01]\d\d")
            terminal.type("auto")
            terminal.expect("Mode AUTO")
            terminal.expect(r"Reached \w+ #2", 60.0)
            terminal.type("rtl")
            terminal.expect("Mode RTL")
            terminal.type("disarm")
            terminal.expect("DISARMED")
        with on_terminal(mavproxy(drive, 1), tmp_path) as terminal:
            terminal.expect(r"Received \d+ parameters", 60.0)
            for name in ("WPNAV_SPEED_DN", "WPNAV_SPEED_UP"):
                terminal.type(f"param set {name} 150")
                terminal.ask_until(f"param show {name}", rf"{name}\s+150")
            load(terminal, "wp", DIVE, "MISSION", tmp_path)
            terminal.type("mode guided")
            terminal.expect("Mode GUIDED")
            terminal.type("arm throttle")
            terminal.expect("ARMED")
            terminal.type("guided 41.181900 -8.697136 -6")
            terminal.ask_until("status GLOBAL_POSITION_INT", r"relative_alt : -(5[5-9]|6)\d\d")
            terminal.type("auto")
            terminal.expect("Mode AUTO")
            terminal.expect(r"Reached \w+ #2", 60.0)
            terminal.type("mode surface")
            terminal.expect("Mode SURFACE")
            terminal.ask_until("status GLOBAL_POSITION_INT", r"relative_alt : -?\d{1,2},")
            terminal.type("disarm")
            terminal.expect("DISARMED")
        truth = drive.stop()
    assert truth["tern"]["has_flown"]
    assert truth["seal"]["has_flown"]
    assert not truth["tern"]["crashed"]
    assert not truth["seal"]["crashed"]
