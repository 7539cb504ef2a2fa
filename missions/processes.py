"""The process table of a mission: which programs run, in which order, and what the death of each means."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

from missions.supervisor import Loss, Output, ProcessSpec, Readiness
from vehicle_agent.mission.load import MissionPlan

KERNELS = "kernels"
SIMULATOR = "sim-bridge"
DASHBOARD = "dashboard"
LINE_LOG = "line-log"

_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
"""A fleet on one machine has a process per vehicle; more threads in each only fight over the cores."""


def is_simulated(plan: MissionPlan, index: int) -> bool:
    """Tell whether a vehicle's body is the simulator's."""
    return plan.mission.vehicles[index].connection is None


def simulated_names(plan: MissionPlan) -> tuple[str, ...]:
    """Names of the vehicles whose bodies are the simulator's."""
    return tuple(name for index, name in enumerate(plan.vehicle_names) if is_simulated(plan, index))


def fleet_table(plan: MissionPlan, run_dir: Path) -> tuple[ProcessSpec, ...]:
    """Everything that flies: compiled kernels first, then the simulator, then one agent per vehicle.

    `plan` is the mission as flown, loaded from the run folder. An agent is never started anew: its vehicle is under
    its own failsafe by then, and a new agent's orders would surprise it.
    """
    kernels = ProcessSpec(
        name=KERNELS,
        argv=_module("missions.kernels", *(["town"] if plan.voxel_grid is not None else [])),
        log=run_dir / "kernels.log",
        loss=Loss.ENDS_MISSION,
        readiness=Readiness.FINISHED,
        ready_within_s=300.0,
    )
    simulator = ProcessSpec(
        name=SIMULATOR,
        argv=_module("sim_bridge.cli", str(plan.source), "--run-dir", str(run_dir), "--tlog-dir", str(run_dir)),
        log=run_dir / "sim.log",
        loss=Loss.ENDS_MISSION,
        after=(KERNELS,),
        environment=_ONE_THREAD,
    )
    needs_simulator = bool(simulated_names(plan))
    agents = tuple(
        ProcessSpec(
            name=name,
            argv=_module("vehicle_agent.cli", str(plan.source), "--vehicle", name, "--run-dir", str(run_dir)),
            log=run_dir / name / "agent.log",
            loss=Loss.LOSES_VEHICLE,
            after=(SIMULATOR,) if is_simulated(plan, index) else (KERNELS,),
            ready_within_s=60.0,
            environment=_ONE_THREAD,
        )
        for index, name in enumerate(plan.vehicle_names)
    )
    return (kernels, simulator, *agents) if needs_simulator else (kernels, *agents)


def dashboard_spec(plan: MissionPlan, run_dir: Path, notice_file: Path) -> ProcessSpec:
    """The dashboard on the terminal. SIGTERM on our death, so that it can give the terminal back."""
    return ProcessSpec(
        name=DASHBOARD,
        argv=_module("ground_station.cli", str(plan.source), "--notice-file", str(notice_file), "--stops-mission"),
        log=run_dir / "ground-station.log",
        loss=Loss.LOSES_VIEW,
        readiness=Readiness.STARTED,
        restarts=3,
        output=Output.TERMINAL,
        death_signal=signal.SIGTERM,
    )


def line_log_spec(plan: MissionPlan, run_dir: Path, notice_file: Path) -> ProcessSpec:
    """The same picture as lines on standard output."""
    return ProcessSpec(
        name=LINE_LOG,
        argv=_module("ground_station.cli", str(plan.source), "--plain", "--notice-file", str(notice_file)),
        log=run_dir / "ground-station.log",
        loss=Loss.LOSES_VIEW,
        readiness=Readiness.STARTED,
        restarts=3,
        output=Output.LINES,
    )


def _module(name: str, *arguments: str) -> tuple[str, ...]:
    return (sys.executable, "-m", name, *arguments)
