"""Stand-ins for the programs of a fleet that say the right things and fly nothing, each as its own process.

`python stand_in_fleet.py run MISSION RUNS_DIR` is `missions run` with stand-ins in its process table. What a stand-in
does wrong comes from the environment variable STAND_IN_<NAME>: `refuse` (a sentence and exit code 2 before ready),
`mute` (never ready), `die` (SIGKILL in mid-flight), `hover` (never done), `wait` (done when the run's folder holds a
file `land`).
"""

from __future__ import annotations

import os
import signal
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from missions import processes
from missions.run import run_mission
from missions.supervisor import ProcessSpec
from vehicle_agent.domain.elevation import ElevationMap
from vehicle_agent.link.session import FleetLink
from vehicle_agent.mission.load import MissionError, MissionPlan, load_mission
from vehicle_agent.wire.messages import AnyMessage, BodyReport, Stage, Status

FLIGHT_S = float(os.environ.get("STAND_IN_FLIGHT_S", "1.5"))
TICK_S = 0.05


def stand_in(spec: ProcessSpec, plan: MissionPlan) -> ProcessSpec:
    argv = (sys.executable, __file__, spec.name, str(plan.source), str(plan.source.parent))
    return replace(spec, argv=argv, ready_within_s=5.0)


def run(mission: str, runs_dir: str) -> int:
    tables = (processes.fleet_table, processes.line_log_spec)
    processes.fleet_table = lambda plan, folder: tuple(stand_in(spec, plan) for spec in tables[0](plan, folder))
    processes.line_log_spec = lambda plan, folder, notice: stand_in(tables[1](plan, folder, notice), plan)
    try:
        return run_mission(load_mission(Path(mission)), Path(runs_dir), plain=True)
    except MissionError as error:
        print(f"missions: {error}", file=sys.stderr)
        return 2


class Voice:
    """Says messages once per tick until told to stop."""

    def __init__(self, name: str, plan: MissionPlan, endpoint: str) -> None:
        self.fault = os.environ.get(f"STAND_IN_{name.upper().replace('-', '_')}", "")
        if self.fault == "refuse":
            print(f"{name}: cannot do it; do something else", file=sys.stderr)
            sys.exit(2)
        self.link = FleetLink.open(plan.mission.name, name, listen=[endpoint])
        self.sequence = 0
        self.stopped = False
        for what in (signal.SIGTERM, signal.SIGINT):
            signal.signal(what, self._stop)
        if self.fault != "mute":
            print("ready", flush=True)
        self.begin_s = time.monotonic()

    def _stop(self, *_: object) -> None:
        self.stopped = True

    def head(self, name: str) -> dict[str, object]:
        self.sequence += 1
        return {"sender": name, "boot_id": 1, "sequence": self.sequence, "stamp_ms": round(1000 * self.elapsed_s) + 1}

    @property
    def elapsed_s(self) -> float:
        return time.monotonic() - self.begin_s

    def say(self, *messages: AnyMessage) -> None:
        for message in messages:
            self.link.publish(message)
        if self.fault == "die" and self.elapsed_s > FLIGHT_S / 2:
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(TICK_S)


def at_start(plan: MissionPlan, name: str) -> tuple[int, int, int]:
    east_m, north_m = plan.vehicle(name).start_enu_m[:2]
    return (round(100 * east_m), round(100 * north_m), 0)


def simulator(plan: MissionPlan, folder: Path) -> None:
    voice = Voice("sim-bridge", plan, plan.simulator_endpoint())
    while not voice.stopped:
        armed = voice.elapsed_s < FLIGHT_S
        voice.say(
            *(
                BodyReport(
                    **voice.head("sim-bridge"), vehicle=name, position_cm=at_start(plan, name), armed=armed,
                    has_flown=True, crashed=False, mode="guided",
                )
                for name in plan.vehicle_names
            )
        )  # fmt: skip
    (folder / "sim_result.json").write_text('{"min_separation_m": 40.0, "fence_breaches": 0, "crashes": 0}')


def agent(plan: MissionPlan, name: str, folder: Path) -> None:
    voice = Voice(name, plan, plan.agent_endpoint(plan.index_of(name)))
    here = at_start(plan, name)
    while not voice.stopped:
        waits = voice.fault == "wait" and not (folder / "land").exists()
        flying = voice.elapsed_s < FLIGHT_S or voice.fault == "hover" or waits
        voice.say(
            Status(
                **voice.head(name), stage=Stage.WORKING if flying else Stage.DONE, mode="guided", armed=flying,
                position_cm=here, velocity_cm_s=(0, 0, 0), heading_deg=0, battery_permille=900, leg_end_cm=here,
                home_cm=here, known_permille=0, first_seen_cells=0, bytes_sent=1000, messages_dropped=0, why="",
            )
        )  # fmt: skip
    seen = ElevationMap(plan.grid)
    shown = {"first_stamp_ms": seen.first_stamp_ms, "observers": seen.observers, "elevation_dm": seen.elevation_dm}
    for array, value in zip(shown.values(), (1, 1 << plan.index_of(name), 0), strict=True):
        array[...] = value
    (folder / name).mkdir(exist_ok=True)
    np.savez(folder / name / "map.npz", **shown)


def main(role: str, mission: str, folder: str) -> int:
    if role == "run":
        return run(mission, folder)
    if role == processes.LINE_LOG:
        print("line log", flush=True)
        signal.pause()
    elif role == processes.SIMULATOR:
        simulator(load_mission(Path(mission)), Path(folder))
    elif role != processes.KERNELS:
        agent(load_mission(Path(mission)), role, Path(folder))
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
