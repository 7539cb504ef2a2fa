"""The plain log: stable lines for programs and screen readers, and the program around it."""

from __future__ import annotations

import io
import json
import os
import re
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from ground_station.fleet_state import fold
from ground_station.inputs import Heard, Tick
from ground_station.notice import read_notice
from ground_station.picture import FleetState
from ground_station.plain import PlainLog, run_plain, status_line
from ground_station.recorder import RunRecorder
from ground_station.station import Station
from tests.fakes.talking_fleet import NAMES, ListLink, Voice, small_plan
from vehicle_agent.link.session import FleetLink
from vehicle_agent.wire.messages import Digest, Stage

PLAN = small_plan()
MISSION = """
format = 1
name = "meadow"
datum = { latitude_deg = 47.0, longitude_deg = 8.0 }
area = { cell_m = 10.0, rectangle_enu_m = [0.0, 0.0, 200.0, 200.0] }
terrain = { kind = "flat" }
task = { kind = "explore" }
[[vehicles]]
name = "merlin"
start_enu_m = [20.0, 20.0]
speed_m_s = 10.0
sensor = { kind = "range", range_m = 100.0 }
min_above_terrain_m = 20.0
max_above_terrain_m = 60.0
"""


@pytest.fixture
def state() -> FleetState:
    return FleetState.initial(PLAN, "station-0001", 9, 0.0)


class TestLines:
    def test_the_status_line_has_its_fields_in_order(self, state: FleetState) -> None:
        voice = Voice("merlin")
        state = fold(state, [Heard(voice.delta(range(100)), 0.0), Heard(voice.status(4.0), 0.0), Tick(0.5)])
        assert status_line(state) == (
            "status t=4.0s phase=working coverage=25.0% speedup=- bad=0 merlin=live/working/guided/87%/25.0%/0.5s "
            "kestrel=awaited/-/-/-/-/- osprey=awaited/-/-/-/-/- harrier=awaited/-/-/-/-/-"
        )

    def test_events_come_once_and_at_once_and_a_status_line_per_interval(self, state: FleetState) -> None:
        log = PlainLog(5.0, 0.0)
        voice = Voice("merlin")
        assert [line.split()[0] for line in log.lines(state)] == ["status"]
        state = fold(state, [Heard(voice.event("climbing to 60 m", 2.0, code="took-off"), 1.0), Tick(1.0)])
        assert log.lines(state) == ["event t=0.0s vehicle=merlin severity=notice code=took-off climbing to 60 m"]
        assert log.lines(state) == []
        state = fold(state, [Heard(voice.event("landed", 4.5), 5.0), Tick(5.0)])
        assert [line.split()[0] for line in log.lines(state)] == ["event", "status"]

    def test_a_mode_with_blanks_keeps_the_fields_apart(self, state: FleetState) -> None:
        state = fold(state, [Heard(Voice("merlin").status(mode="a b/c"), 0.0), Tick(0.0)])
        assert "merlin=live/working/a-b-c/" in status_line(state)

    def test_a_notice_is_told_when_it_changes(self, state: FleetState) -> None:
        log = PlainLog(5.0, 10.0)
        assert log.lines(state, "compiling \x1b[31mkernels") == ["notice compiling ?[31mkernels"]
        assert log.lines(state, "compiling \x1b[31mkernels") == []


class TestRunning:
    def test_it_ends_by_itself_when_every_vehicle_is_done(self) -> None:
        link, output = ListLink(), io.StringIO()
        link.arriving = [Voice(name).status(stage=Stage.DONE) for name in NAMES]
        run_plain(Station(PLAN, "station-0001", 9, 0.0), lambda: link, exit_when_done=True, output=output)
        last = output.getvalue().splitlines()[-1]
        assert last.startswith("status t=0.0s phase=done")

    def test_ascii_output_survives_what_is_not_ascii(self) -> None:
        raw = io.BytesIO()
        output = io.TextIOWrapper(raw, encoding="ascii")
        link = ListLink()
        link.arriving = [Voice(name).status(stage=Stage.DONE) for name in NAMES] + [Voice("merlin", 2).event("größer")]
        run_plain(Station(PLAN, "station-0001", 9, 0.0), lambda: link, exit_when_done=True, output=output)
        assert b"gr??er" in raw.getvalue()


class TestRecorder:
    def test_statuses_and_events_become_json_lines_once(self, tmp_path: Path) -> None:
        voice = Voice("merlin")
        status, event = voice.status(1.0, stage=Stage.LANDING), voice.event("landed", code="landed")
        recorder = RunRecorder(tmp_path / "run")
        recorder.record([status, event, event, voice.delta([1])])
        recorder.close()
        (status_object,) = map(json.loads, (tmp_path / "run" / "status.jsonl").read_text().splitlines())
        (event_object,) = map(json.loads, (tmp_path / "run" / "events.jsonl").read_text().splitlines())
        assert (status_object["kind"], status_object["stage"], status_object["sender"]) == (
            "status",
            "landing",
            "merlin",
        )
        assert (event_object["code"], event_object["severity"]) == ("landed", "notice")

    def test_a_second_recorder_appends(self, tmp_path: Path) -> None:
        for boot_id in (1, 2):
            recorder = RunRecorder(tmp_path)
            recorder.record([Voice("merlin", boot_id).event("x")])
            recorder.close()
        assert len((tmp_path / "events.jsonl").read_text().splitlines()) == 2


class TestNotice:
    def test_the_first_line_of_the_file(self, tmp_path: Path) -> None:
        file = tmp_path / "notice"
        assert read_notice(file) == ""
        assert read_notice(None) == ""
        file.write_bytes(b"compiling kernels\nmore\n")
        assert read_notice(file) == "compiling kernels"
        file.write_bytes(b"\xff\xfe")
        assert read_notice(file)
        file.write_bytes(b"")
        assert read_notice(file) == ""


@pytest.fixture
def mission_file(tmp_path: Path) -> Path:
    file = tmp_path / "meadow.toml"
    file.write_text(MISSION)
    return file


def start(*arguments: str | Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "ground_station.cli", *map(str, arguments)],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
    )  # fmt: skip


@pytest.mark.processes
class TestProgram:
    @pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
    def test_without_a_terminal_it_writes_lines_and_stops_cleanly(
        self, mission_file: Path, free_port_base: int, number: signal.Signals
    ) -> None:
        program = start(mission_file, "--zenoh-port", str(free_port_base))
        guard = threading.Timer(60, program.kill)
        guard.start()
        assert program.stdout is not None
        assert re.match(r"status t=0\.0s phase=waiting .*merlin=awaited", program.stdout.readline())
        program.send_signal(number)
        rest, errors = program.communicate()
        guard.cancel()
        assert program.returncode == 0
        assert rest.startswith("status ")
        assert errors == ""

    def test_it_hears_a_vehicle_over_zenoh_and_ends_when_that_is_done(
        self, mission_file: Path, free_port_base: int
    ) -> None:
        link = FleetLink.open("meadow", "merlin", listen=[f"tcp/127.0.0.1:{free_port_base + 1}"])
        link.declare_alive()
        link.subscribe("digest")
        program = start(mission_file, "--exit-when-done", "--zenoh-port", str(free_port_base))
        guard = threading.Timer(60, program.kill)
        guard.start()
        voice = Voice("merlin")
        asked = False
        while program.poll() is None:
            asked = asked or any(isinstance(message, Digest) for message in link.poll())
            link.publish(voice.status(float(voice.sequence), stage=Stage.DONE if asked else Stage.WORKING))
            threading.Event().wait(0.05)
        guard.cancel()
        link.close()
        lines, errors = program.communicate()
        assert (program.returncode, errors, asked) == (0, "", True)
        assert "vehicle=merlin severity=info code=heard" in lines
        assert "merlin=live/done/guided/87%" in lines.splitlines()[-1]

    def test_a_reader_that_goes_away_is_no_error(self, mission_file: Path, free_port_base: int) -> None:
        program = start(mission_file, "--interval", "0.1", "--zenoh-port", str(free_port_base))
        guard = threading.Timer(60, program.kill)
        guard.start()
        assert program.stdout is not None
        assert program.stderr is not None
        program.stdout.readline()
        program.stdout.close()
        errors = program.stderr.read()
        program.stderr.close()
        code = program.wait()
        guard.cancel()
        assert (code, errors) == (0, "")

    def test_a_missing_mission_is_one_sentence_and_exit_code_2(self, tmp_path: Path) -> None:
        program = start(tmp_path / "nowhere.toml")
        _, errors = program.communicate(timeout=60)
        assert program.returncode == 2
        assert len(errors.splitlines()) == 1
        assert "nowhere.toml: no such file" in errors
