"""What simulated autopilots cost: CPU per simulated second and vehicle, and how fast a fleet can be flown.

Every vehicle is a flying copter with one TCP client that asks for all streams at 4 Hz and reads them. The simulator is
the program that users start; its CPU time comes from the kernel, late ticks from what it leaves behind.
"""

from __future__ import annotations

import json
import os
import selectors
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from missions.bench.results import save_rows, work_through
from sim_bridge.autopilot.dialect import mavlink, new_codec
from vehicle_agent.mission.load import MissionError

TEAM_SIZES = (1, 4, 16, 50)
STREAM_RATE_HZ = 4
COST_BAR_S = 0.004
"""CPU-seconds per simulated second and vehicle; a real ArduPilot build costs 0.015 to 0.020."""
FLEET_BAR = (50, 5.0)
"""So many vehicles at this speed-up without a late tick."""
SETTLE_WALL_S = 3.0
MEASURED_WALL_S = 5.0
FASTEST = 100.0
SLOWER = 0.8
"""A speed-up that was too fast is followed by this share of it."""
TIME_TOLD_BYTES = 8_192
"""At the end of what a client has read there is a position, with its time."""
TRIES = 2
"""A machine that does something else meanwhile makes late ticks that are not the simulator's."""
CONTROLLER_ID = 255
MODE_GUIDED = 4


@dataclass(frozen=True, slots=True)
class Measurement:
    """One run of the simulator.

    Attributes
    ----------
    cpu_s
        CPU time of the simulator while it was measured.
    simulated_s
        Simulated seconds in that time, as the first vehicle tells them: fewer than were asked for when it is late.
    late_ticks
        Steps that ran more than 50 ms late, from start to end.
    bytes_heard
        By all clients while it was measured.
    """

    vehicles: int
    speedup: float
    cpu_s: float
    simulated_s: float
    late_ticks: int
    bytes_heard: int

    @property
    def cost_s(self) -> float:
        """CPU-seconds per simulated second and vehicle."""
        return self.cpu_s / (self.simulated_s * self.vehicles)

    @property
    def sustained(self) -> bool:
        return self.late_ticks == 0


def bench_autopilot(json_file: Path | None) -> int:
    """Measure, print a table, and tell by the exit code whether the bars are kept."""
    rows, interrupted = work_through(TEAM_SIZES, _row, "autopilots")
    print("vehicles   CPU-s per simulated s and vehicle   highest sustained speed-up   kB/s per vehicle")
    for row in rows:
        print(
            f"{row['vehicles']:8d}   {row['cpu_s_per_simulated_s']:35.5f}   {row['sustained_speedup']:25.1f}x"
            f"   {row['bytes_per_simulated_s'] / 1000:16.1f}"
        )
    if json_file is not None:
        save_rows(json_file, "autopilot", 0, rows)
    kept = not interrupted and all(row["kept"] for row in rows)
    bars = f"at most {COST_BAR_S} CPU-s; {FLEET_BAR[0]} vehicles at {FLEET_BAR[1]:g}x"
    print(f"bars: {bars}: {'kept' if kept else 'MISSED'}")
    return 0 if kept else 1


def _row(vehicles: int) -> dict[str, Any]:
    fleet_size, fleet_speedup = FLEET_BAR
    speedup = fleet_speedup if vehicles == fleet_size else min(FASTEST, 0.25 / (COST_BAR_S * vehicles))
    base = measure(vehicles, speedup)
    if not base.sustained:
        base = measure(vehicles, speedup)
    best = fastest_sustained(vehicles, base)
    return {
        "vehicles": vehicles,
        "speedup_measured": speedup,
        "cpu_s_per_simulated_s": round(base.cost_s, 6),
        "late_ticks": base.late_ticks,
        "sustained_speedup": best,
        "bytes_per_simulated_s": round(base.bytes_heard / base.simulated_s / vehicles, 1),
        "kept": base.cost_s <= COST_BAR_S and (vehicles != fleet_size or best >= fleet_speedup),
    }


def fastest_sustained(vehicles: int, base: Measurement) -> float:
    """Highest speed-up without a late tick, tried downwards from what one core could do; 0 when there is none."""
    speedup = min(FASTEST, 0.95 / (base.cost_s * vehicles))
    while speedup > 0.5:
        speedup = round(speedup, 1)
        if base.sustained and speedup <= base.speedup:
            return base.speedup
        if any(measure(vehicles, speedup).sustained for _ in range(TRIES)):
            return speedup
        speedup *= SLOWER
    return 0.0


def measure(vehicles: int, speedup: float) -> Measurement:
    """Run the simulator with clients at a speed-up for some seconds."""
    with tempfile.TemporaryDirectory() as folder:
        ports = _free_ports(vehicles)
        mission = Path(folder) / "mission.toml"
        mission.write_text(_mission(vehicles, speedup, ports))
        with _simulator(mission, Path(folder)) as process, _clients(vehicles, ports) as sockets:
            _take_off(sockets)
            _, began_s = _drain(sockets, SETTLE_WALL_S)
            before_s = _cpu_s(process.pid)
            heard, ended_s = _drain(sockets, MEASURED_WALL_S)
            cpu_s = _cpu_s(process.pid) - before_s
        result = json.loads((Path(folder) / "sim_result.json").read_text())
    return Measurement(vehicles, speedup, cpu_s, ended_s - began_s, int(result["late_ticks"]), heard)


def _mission(vehicles: int, speedup: float, first_port: int) -> str:
    team = "".join(
        f"""
[[vehicles]]
name = "copter-{number}"
start_enu_m = [{100.0 + 40.0 * (number % 8)}, {100.0 + 40.0 * (number // 8)}]
speed_m_s = 15.0
sensor = {{ kind = "range", range_m = 200.0, period_s = 3600.0 }}
min_above_terrain_m = 30.0
max_above_terrain_m = 150.0
"""
        for number in range(vehicles)
    )
    return f"""
format = 1
name = "bench"
[datum]
latitude_deg = 36.57
longitude_deg = -84.27
[area]
cell_m = 20.0
rectangle_enu_m = [0.0, 0.0, 1000.0, 1000.0]
[terrain]
kind = "flat"
[task]
kind = "explore"
{team}
[radio]
zenoh_port = {first_port + 10 * vehicles}
[simulation]
speedup = {speedup}
ready_after_s = 0.0
mavlink_port = {first_port}
endurance_s = 1e6
"""


def _free_ports(vehicles: int) -> int:
    """First of a block of ports of which none is in use; ports that come and go are left to the system."""
    needed = range(0, 10 * vehicles + vehicles + 2, 10)
    for first in range(20_001, 30_000, 701):
        try:
            for offset in needed:
                with socket.socket() as probe:
                    probe.bind(("127.0.0.1", first + offset))
        except OSError:
            continue
        return first
    raise MissionError("no free ports between 20001 and 30000; stop what uses them")


@contextmanager
def _simulator(mission: Path, folder: Path) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-m", "sim_bridge.cli", str(mission), "--run-dir", str(folder)]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
    try:
        assert process.stdout is not None
        if process.stdout.readline() != "ready\n":
            raise MissionError("the simulator did not start; its own message says why")
        yield process
        process.send_signal(signal.SIGTERM)
        process.wait(30)
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()


@contextmanager
def _clients(vehicles: int, first_port: int) -> Iterator[list[socket.socket]]:
    sockets = [socket.create_connection(("127.0.0.1", first_port + 10 * number), 10) for number in range(vehicles)]
    try:
        yield sockets
    finally:
        for connection in sockets:
            connection.close()


def _take_off(sockets: Sequence[socket.socket]) -> None:
    """Ask for the streams and put every vehicle into the air."""
    for number, connection in enumerate(sockets):
        codec = new_codec(CONTROLLER_ID, 190)
        target = number + 1
        messages = (
            mavlink.MAVLink_request_data_stream_message(target, 1, 0, STREAM_RATE_HZ, 1),
            _command(target, mavlink.MAV_CMD_DO_SET_MODE, 1, MODE_GUIDED),
            _command(target, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1),
            _command(target, mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, 50),
        )
        connection.sendall(b"".join(message.pack(codec) for message in messages))
        connection.setblocking(False)


def _command(target: int, number: int, *parameters: float) -> Any:
    values = [*parameters, *[0.0] * (7 - len(parameters))]
    return mavlink.MAVLink_command_long_message(target, 1, number, 0, *values)


def _drain(sockets: Sequence[socket.socket], seconds: float) -> tuple[int, float]:
    """Read what comes for so long; returns the number of bytes and the first vehicle's time at the end, seconds."""
    end_s, heard, last = time.monotonic() + seconds, 0, b""
    with selectors.DefaultSelector() as selector:
        for connection in sockets:
            selector.register(connection, selectors.EVENT_READ)
        while (left_s := end_s - time.monotonic()) > 0:
            # Gathering for a while keeps the clients' own cost, which is not measured, off the two cores.
            time.sleep(min(left_s, 0.02))
            for ready, _ in selector.select(0):
                data = os.read(ready.fd, 1 << 20)
                if not data:
                    raise MissionError("the simulator closed a connection; see its own message")
                heard += len(data)
                if ready.fileobj is sockets[0]:
                    last = (last + data)[-TIME_TOLD_BYTES:]
    stamps = [m.time_boot_ms for m in new_codec(0).parse_buffer(last) or () if m.get_type() == "GLOBAL_POSITION_INT"]
    if not stamps:
        raise MissionError("the simulator sent no positions; see its own message")
    return heard, stamps[-1] / 1000.0


def _cpu_s(pid: int) -> float:
    """CPU time of a process so far, from the kernel."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    except OSError:
        raise MissionError("CPU time cannot be read from /proc; run this bench on Linux") from None
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
