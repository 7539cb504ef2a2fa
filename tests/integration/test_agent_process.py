"""The agent program and its adapters against the simulator program: a real flight, and the ways it can end."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.fakes.waiting import until
from vehicle_agent.adapters.file_journal import FileJournal, JournalHeader
from vehicle_agent.adapters.mavsdk_autopilot import MavsdkAutopilot
from vehicle_agent.link.session import FleetLink
from vehicle_agent.mission.load import MissionPlan, load_mission
from vehicle_agent.ports import (
    Action,
    Arm,
    FlightMode,
    GoTo,
    Hold,
    Landed,
    Order,
    ReturnHome,
    SetParameter,
    TakeOff,
    VehicleState,
)
from vehicle_agent.wire.messages import BodyReport, Stage, Status

pytestmark = pytest.mark.processes
DEADLINE_S = 90.0

MISSION = """
format = 1
name = "trial"
seed = 3
[datum]
latitude_deg = 36.57
longitude_deg = -84.27
[area]
cell_m = 20.0
rectangle_enu_m = [0.0, 0.0, {size_m}, {size_m}]
fence_margin_m = 10.0
[terrain]
kind = "flat"
elevation_amsl_m = 300.0
[task]
kind = "explore"
[[vehicles]]
name = "merlin"
start_enu_m = [200.0, 200.0]
speed_m_s = 18.0
climb_m_s = 6.0
sensor = {{ kind = "range", range_m = 150.0 }}
min_above_terrain_m = 40.0
max_above_terrain_m = 120.0
[radio]
zenoh_port = {zenoh_port}
[simulation]
speedup = {speedup}
ready_after_s = 2.0
mavlink_port = {mavlink_port}
"""


def make_plan(folder: Path, port_base: int, speedup: float, size_m: float = 1_500.0) -> MissionPlan:
    path = folder / "mission.toml"
    ports = {"zenoh_port": port_base, "mavlink_port": port_base + 100}
    path.write_text(MISSION.format(size_m=size_m, speedup=speedup, **ports))
    return load_mission(path)


@contextmanager
def program(module: str, *arguments: str) -> Iterator[subprocess.Popen[str]]:
    """One of our programs, ready to be used; killed at the end."""
    process = subprocess.Popen(
        [sys.executable, "-m", module, *arguments], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    assert process.stdout is not None
    try:
        assert process.stdout.readline() == "ready\n"
        yield process
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


@contextmanager
def simulator(plan: MissionPlan) -> Iterator[subprocess.Popen[str]]:
    with program("sim_bridge.cli", str(plan.source)) as process:
        yield process


class Referee:
    """Hears where the body truly is and what its agent says."""

    def __init__(self, plan: MissionPlan) -> None:
        endpoints = [plan.simulator_endpoint(), plan.agent_endpoint(0)]
        self.link = FleetLink.open(plan.mission.name, "referee", connect=endpoints)
        self.link.subscribe("body")
        self.link.subscribe("status")
        self.body: BodyReport | None = None
        self.status: Status | None = None

    def sees(self, condition: Callable[[BodyReport], bool]) -> bool:
        self._listen()
        return self.body is not None and condition(self.body)

    def hears(self, condition: Callable[[Status], bool]) -> bool:
        self._listen()
        return self.status is not None and condition(self.status)

    def _listen(self) -> None:
        for message in self.link.poll():
            if isinstance(message, BodyReport):
                self.body = message
            elif isinstance(message, Status):
                self.status = message


@contextmanager
def referee(plan: MissionPlan) -> Iterator[Referee]:
    watcher = Referee(plan)
    try:
        yield watcher
    finally:
        watcher.link.close()


class Pilot:
    """Gives one order after the other through the adapter and waits for what they bring about."""

    def __init__(self, autopilot: MavsdkAutopilot) -> None:
        self.autopilot = autopilot
        self.state: VehicleState | None = None
        self._accepted: dict[int, bool] = {}
        self._actions = 0

    def until(self, condition: Callable[[VehicleState], bool], what: str) -> None:
        def check() -> bool:
            state, results, _ = self.autopilot.poll()
            self.state = state or self.state
            self._accepted |= {result.action_id: result.accepted for result in results}
            return self.state is not None and condition(self.state)

        until(check, what)

    def order(self, order: Order) -> None:
        self._actions += 1
        self.autopilot.submit(Action(self._actions, order))
        self.until(lambda _state: self._actions in self._accepted, f"an answer to {order}")
        assert self._accepted[self._actions], order


@pytest.mark.parametrize("speedup", [1.0, 10.0])
def test_the_adapter_flies_the_simulated_copter(tmp_path: Path, free_port_base: int, speedup: float) -> None:
    plan = make_plan(tmp_path, free_port_base, speedup)
    with simulator(plan):
        autopilot = MavsdkAutopilot(plan.connection(0), plan.system_id(0), plan.controller_system_id(0), plan.datum)
        pilot = Pilot(autopilot)
        try:
            pilot.until(lambda state: state.ready_to_arm, "the copter to be ready")
            for name, value in (("SYSID_MYGCS", 101.0), ("FS_GCS_ENABLE", 1.0), ("FS_GCS_TIMEOUT", 5.0)):
                pilot.order(SetParameter(name, value))
            pilot.order(Arm())
            pilot.until(lambda state: state.armed and state.mode is FlightMode.GUIDED, "armed in guided flight")
            assert pilot.state is not None
            assert pilot.state.home_enu_m == pytest.approx((200.0, 200.0, 300.0), abs=0.1)
            pilot.order(TakeOff(10.0))
            pilot.until(lambda state: state.position_enu_m[2] > 309.0, "ten metres")
            target = (230.0, 180.0, 315.0)
            pilot.order(GoTo(target))
            pilot.until(lambda state: state.position_enu_m == pytest.approx(target, abs=1.0), "the target")
            pilot.order(Hold())
            pilot.until(lambda state: state.mode is FlightMode.HOLD, "holding")
            pilot.order(ReturnHome())
            pilot.until(lambda state: state.mode is FlightMode.RETURN, "returning")
            if speedup > 1.0:
                pilot.until(lambda state: not state.armed and state.landed is Landed.ON_GROUND, "home")
        finally:
            autopilot.close()


@pytest.mark.parametrize("blow", [signal.SIGKILL, signal.SIGTERM])
def test_the_death_of_an_agent_in_flight_brings_its_vehicle_home(
    tmp_path: Path, free_port_base: int, blow: signal.Signals
) -> None:
    plan = make_plan(tmp_path, free_port_base, 10.0, size_m=1_000.0)
    folder = tmp_path / "run" / "merlin"
    arguments = (str(plan.source), "--vehicle", "merlin", "--run-dir", str(tmp_path / "run"))
    with simulator(plan), program("vehicle_agent.cli", *arguments) as agent, referee(plan) as watcher:
        until(lambda: watcher.hears(lambda status: status.stage is Stage.WORKING), "work in the air")
        until(lambda: watcher.hears(lambda status: status.known_permille > 200), "a fifth of the map")
        os.kill(agent.pid, blow)
        exit_code = agent.wait(DEADLINE_S)
        until(lambda: watcher.sees(lambda body: body.mode == "RTL"), "the failsafe")
        until(lambda: watcher.sees(lambda body: not body.armed), "the landing")
        assert watcher.body is not None
        assert watcher.body.position_cm[:2] == pytest.approx((20_000, 20_000), abs=300)
    journal = FileJournal.open(folder / "journal.bin", JournalHeader.of(plan, "merlin"))
    assert len(list(journal.records())) > 5
    journal.close()
    assert (folder / "result.json").exists() == (blow is signal.SIGTERM)
    assert exit_code == (0 if blow is signal.SIGTERM else -signal.SIGKILL)


def test_a_whole_mission_of_one_agent_ends_by_itself(tmp_path: Path, free_port_base: int) -> None:
    plan = make_plan(tmp_path, free_port_base, 20.0, size_m=500.0)
    arguments = (str(plan.source), "--vehicle", "merlin", "--run-dir", str(tmp_path), "--exit-when-done")
    with simulator(plan), program("vehicle_agent.cli", *arguments) as agent:
        assert agent.wait(DEADLINE_S) == 0
    result = json.loads((tmp_path / "merlin" / "result.json").read_text())
    assert result["stage"] == "done"
    assert result["known_cells"] >= 0.99 * plan.grid.cells


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--vehicle", "nobody"), "there is no vehicle 'nobody'; the mission has merlin"),
        (("--vehicle", "merlin", "--connection", "smoke://signals"), "smoke://signals: not a usable connection"),
        (("--vehicle", "merlin", "--run-dir", "{folder}/taken"), "taken/merlin"),
    ],
)
def test_user_errors_are_one_sentence_and_exit_code_2(
    tmp_path: Path, free_port_base: int, options: tuple[str, ...], words: str
) -> None:
    plan = make_plan(tmp_path, free_port_base, 1.0)
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "merlin").write_text("a file where a folder should be")
    filled = [option.format(folder=tmp_path) for option in options]
    command = [sys.executable, "-m", "vehicle_agent.cli", str(plan.source), "--run-dir", str(tmp_path), *filled]
    outcome = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE_S)
    assert outcome.returncode == 2
    assert outcome.stdout in ("", "ready\n")
    sentences = outcome.stderr.splitlines()
    assert words in sentences[-1]
    assert "Traceback" not in outcome.stderr


def test_a_port_in_use_is_one_sentence_and_exit_code_2(tmp_path: Path, free_port_base: int) -> None:
    plan = make_plan(tmp_path, free_port_base, 1.0)
    holder = FleetLink.open("other", "holder", listen=[plan.agent_endpoint(0)])
    try:
        command = [sys.executable, "-m", "vehicle_agent.cli", str(plan.source), "--vehicle", "merlin"]
        outcome = subprocess.run(
            [*command, "--run-dir", str(tmp_path)], capture_output=True, text=True, timeout=DEADLINE_S
        )
    finally:
        holder.close()
    assert outcome.returncode == 2
    assert f"{plan.agent_endpoint(0)}: the port is in use" in outcome.stderr
    assert "Traceback" not in outcome.stderr
