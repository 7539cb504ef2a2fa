"""`missions run` with the real programs on a small mission: it ends by itself, and it survives what is killed."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import msgspec
import pytest
from pymavlink import mavutil

from ground_station.link import open_link
from ground_station.picture import Condition, FleetState
from ground_station.player import Player
from ground_station.recording import Recording, RecordingWriter
from ground_station.station import Station
from missions.summary import Summary
from tests.fakes.flown_runs import REPOSITORY, run_command, write_mission
from tests.fakes.hill_missions import copters, hill_mission
from tests.fakes.pictures import same_picture
from vehicle_agent.mission.load import MissionPlan, load_mission
from vehicle_agent.wire.messages import Stage

pytestmark = [pytest.mark.processes, pytest.mark.timeout(400)]

RUN_DEADLINE_S = 240.0
LOST_WITHIN_S = 4.0
PICTURE_WITHIN_S = 5.0
NAMES = ("ada", "bea", "cleo")
MISSION = hill_mission(
    seed=3,
    team=copters([(60.0, 60.0), (100.0, 60.0), (60.0, 100.0)], NAMES, range_m=110.0),
    area={"cell_m": 20.0, "rectangle_enu_m": [0.0, 0.0, 700.0, 700.0], "fence_margin_m": 5.0},
    terrain={"kind": "gaussians", "peaks": 4, "height_m": [10.0, 50.0], "sigma_m": 90.0},
    task={"kind": "explore", "step_m": 80.0},
    simulation={"speedup": 10.0, "ready_after_s": 5.0},
    stop={"time_limit_s": 900.0},
)


class FlownMission:
    """One `missions run` in its own process, and a station of the test's own that watches it."""

    def __init__(self, folder: Path, port_base: int) -> None:
        self.runs_dir = folder / "runs"
        self.output = folder / "output.txt"
        with self.output.open("wb") as output:
            self.process = subprocess.Popen(
                run_command(write_mission(MISSION, folder), self.runs_dir, port_base),
                cwd=REPOSITORY, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
            )  # fmt: skip
        self.until(lambda: bool(list(self.runs_dir.glob("*/mission.toml"))), 30.0)
        self.folder = next(self.runs_dir.iterdir())
        self.plan: MissionPlan = load_mission(self.folder / "mission.toml")

    def until(self, condition: Callable[[], bool], within_s: float = RUN_DEADLINE_S) -> float:
        """Wait for a condition and return how long it took; fails when the run ends or time passes before."""
        begin_s = time.monotonic()
        while not condition():
            waited_s = time.monotonic() - begin_s
            assert self.process.poll() is None, f"the run ended:\n{self.output.read_text()}"
            assert waited_s < within_s, f"not within {within_s} s:\n{self.output.read_text()}"
            time.sleep(0.02)
        return time.monotonic() - begin_s

    def end(self) -> int:
        return self.process.wait(RUN_DEADLINE_S)

    def summary(self) -> Summary:
        return msgspec.json.decode((self.folder / "summary.json").read_bytes(), type=Summary)

    def pids(self, *words: str) -> list[int]:
        """The run's children whose command line holds all these words."""
        found = []
        for entry in Path("/proc").glob("[0-9]*/cmdline"):
            try:
                command = entry.read_bytes().decode("utf-8", "replace").split("\0")
            except OSError:
                continue
            ours = any(str(self.folder) in word for word in command) and int(entry.parent.name) != self.process.pid
            if ours and all(word in command for word in words):
                found.append(int(entry.parent.name))
        return found

    def kill(self, *words: str) -> None:
        (pid,) = self.pids(*words)
        os.kill(pid, signal.SIGKILL)


class Watcher:
    """A ground station without a face that records what it hears."""

    def __init__(self, flown: FlownMission, name: str) -> None:
        self._closed = False
        self.file = flown.folder / f"{name}.mcap"
        recording = RecordingWriter(self.file)
        self.station = Station(flown.plan, name, os.getpid(), time.monotonic(), recording=recording)
        self.station.attach(open_link(flown.plan, name))

    def close(self) -> FleetState:
        """Take in the rest and end the recording, once; the last picture."""
        if not self._closed:
            self._closed = True
            self.station.step(time.monotonic())
            self.station.close()
        return self.station.state

    def stages(self) -> dict[str, Stage]:
        state = self.station.step(time.monotonic())
        return {vehicle.name: vehicle.status.stage for vehicle in state.vehicles if vehicle.status}

    def coverage(self) -> float:
        return self.station.step(time.monotonic()).team_map.coverage

    def condition(self, name: str) -> Condition:
        state = self.station.step(time.monotonic())
        return next(vehicle.condition for vehicle in state.vehicles if vehicle.name == name)


@pytest.fixture
def flown(tmp_path: Path, free_port_base: int) -> Iterator[FlownMission]:
    mission = FlownMission(tmp_path, free_port_base)
    yield mission
    mission.process.kill()
    mission.process.wait()
    deadline_s = time.monotonic() + 10.0
    while left := mission.pids():
        assert time.monotonic() < deadline_s, f"left behind: {left}"
        time.sleep(0.05)


@pytest.fixture
def watch(flown: FlownMission) -> Iterator[Callable[[str], Watcher]]:
    watchers: list[Watcher] = []

    def make(name: str) -> Watcher:
        watchers.append(Watcher(flown, name))
        return watchers[-1]

    yield make
    for watcher in watchers:
        watcher.close()


def test_a_mission_ends_by_itself_though_its_ground_station_is_killed(flown, watch):
    first = watch("station-one")
    flown.until(lambda: first.coverage() > 0.4)
    flown.kill("--plain")
    known = first.coverage()
    second = watch("station-two")
    took_s = flown.until(lambda: second.coverage() >= known, PICTURE_WITHIN_S)
    print(f"a new station had the picture after {took_s:.2f} s")
    assert flown.end() == 0, flown.output.read_text()
    summary = flown.summary()
    assert summary.observed_fraction >= 0.99
    assert all(vehicle.home_and_disarmed for vehicle in summary.vehicles)
    assert not any(vehicle.agent_lost for vehicle in summary.vehicles)
    assert all(vehicle.bytes_per_s < 2_000 for vehicle in summary.vehicles)
    assert summary.min_separation_m is not None
    assert summary.min_separation_m >= 5.0
    assert (summary.fence_breaches, summary.crashes) == (0, 0)
    for name in NAMES:
        log = mavutil.mavlink_connection(str(flown.folder / f"{name}.tlog"))
        assert log.recv_match(type="COMMAND_ACK") is not None
        log.close()
    assert any("line-log was killed by SIGKILL; started anew" in warning for warning in summary.warnings)


def test_the_others_finish_when_an_agent_is_killed_in_mid_flight(flown, watch):
    station = watch("station-one")
    flown.until(lambda: station.coverage() > 0.25 and station.stages().get("bea") is Stage.WORKING)
    flown.kill("--vehicle", "bea")
    took_s = flown.until(lambda: station.condition("bea") is Condition.LOST, LOST_WITHIN_S)
    print(f"shown lost after {took_s:.2f} s")
    assert flown.end() == 0, flown.output.read_text()
    summary = flown.summary()
    assert summary.observed_fraction >= 0.99
    assert {vehicle.name: vehicle.agent_lost for vehicle in summary.vehicles} == {
        "ada": False, "bea": True, "cleo": False,
    }  # fmt: skip
    assert all(vehicle.home_and_disarmed for vehicle in summary.vehicles)  # the lost one by its own failsafe
    assert summary.min_separation_m is not None
    assert summary.min_separation_m >= 5.0
    assert summary.crashes == 0
    live = station.close()
    replayed = Player(Recording(station.file))
    assert same_picture(replayed.play_to_end(), live)
    assert replayed.recording.complete
    assert any(entry.code == "lost" and entry.source == "bea" for entry in live.log)


def test_ctrl_c_in_flight_keeps_what_was_seen_and_leaves_nobody(flown, watch):
    station = watch("station-one")
    flown.until(lambda: station.coverage() > 0.1)
    flown.process.send_signal(signal.SIGINT)
    assert flown.end() == 130
    assert flown.pids() == []
    summary = flown.summary()
    assert summary.ending == "stopped"
    assert summary.observed_fraction > 0.1
    assert summary.fence_breaches == 0
