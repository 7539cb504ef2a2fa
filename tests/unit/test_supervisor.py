"""The supervisor with small real children: readiness, restarts, stopping, and nobody left behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from missions.supervisor import Change, Loss, Notice, Output, ProcessSpec, Readiness, State, Supervisor
from tests.fakes.waiting import until

REPOSITORY = Path(__file__).parents[2]
DEADLINE_S = 20.0


def child(tmp_path: Path, code: str, name: str = "child", **changes: object) -> ProcessSpec:
    argv = (sys.executable, "-I", "-S", "-c", code)
    return ProcessSpec(name=name, argv=argv, log=tmp_path / f"{name}.log", loss=Loss.ENDS_MISSION, **changes)  # type: ignore[arg-type]


def tick_until(supervisor: Supervisor, change: Change, name: str = "child") -> list[Notice]:
    """All notices up to and including the wanted one."""
    notices: list[Notice] = []

    def came() -> bool:
        notices.extend(supervisor.tick())
        return any(notice.change is change and notice.spec.name == name for notice in notices)

    until(came)
    return notices


def gone(pid: int) -> bool:
    """No such process, or only its unreaped remains."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z"
    except (FileNotFoundError, ProcessLookupError):
        return True


@pytest.fixture
def supervise():
    """A factory of supervisors whose children are killed after the test."""
    made: list[Supervisor] = []

    def make(*specs: ProcessSpec) -> Supervisor:
        made.append(Supervisor(specs))
        return made[-1]

    yield make
    for supervisor in made:
        supervisor.kill_all()


WAITS = "import time\nprint('ready', flush=True)\ntime.sleep(600)"


def test_ready_line_makes_ready_and_output_goes_to_the_log(tmp_path, supervise):
    supervisor = supervise(child(tmp_path, f"print('already')\n{WAITS}"))
    supervisor.tick()
    assert supervisor.state("child") is State.STARTING
    tick_until(supervisor, Change.READY)
    assert supervisor.state("child") is State.READY
    assert (tmp_path / "child.log").read_text() == "already\nready\n"


def test_who_said_ready_and_died_before_anybody_looked_was_ready(tmp_path, supervise):
    supervisor = supervise(child(tmp_path, "import os\nprint('ready', flush=True)\nos.kill(os.getpid(), 9)"))
    supervisor.tick()
    pid = supervisor.pids()["child"]
    until(lambda: gone(pid))
    changes = [notice.change for notice in tick_until(supervisor, Change.ENDED)]
    assert changes == [Change.READY, Change.ENDED]


def test_a_process_waits_for_those_before_it(tmp_path, supervise):
    gate = tmp_path / "gate"
    first = child(
        tmp_path,
        f"import os, time\nwhile not os.path.exists({str(gate)!r}): time.sleep(0.01)",
        "first",
        readiness=Readiness.FINISHED,
    )
    second = child(tmp_path, WAITS, "second", after=("first",))
    supervisor = supervise(first, second)
    supervisor.tick()
    supervisor.tick()
    assert supervisor.state("second") is State.WAITING
    gate.touch()
    names = [notice.spec.name for notice in tick_until(supervisor, Change.READY, "second")]
    assert names == ["first", "second"]
    assert supervisor.state("first") is State.ENDED


def test_a_failed_preparation_keeps_the_next_from_starting(tmp_path, supervise):
    first = child(
        tmp_path, "print('no kernels', flush=True); raise SystemExit(3)", "first", readiness=Readiness.FINISHED
    )
    supervisor = supervise(first, child(tmp_path, WAITS, "second", after=("first",)))
    (notice,) = tick_until(supervisor, Change.ENDED, "first")
    assert notice.exit_code == 3
    assert "no kernels" in notice.text
    supervisor.tick()
    assert supervisor.state("second") is State.WAITING


def test_not_ready_in_time_is_killed_and_told(tmp_path, supervise):
    supervisor = supervise(child(tmp_path, "import time\ntime.sleep(600)", ready_within_s=0.2))
    supervisor.tick()
    pid = supervisor.pid("child")
    assert pid is not None
    (notice,) = tick_until(supervisor, Change.NOT_READY)
    assert "0.2 s" in notice.text
    assert gone(pid)


def test_a_program_that_does_not_exist_is_told(tmp_path, supervise):
    spec = ProcessSpec(name="child", argv=("/no/such/program",), log=tmp_path / "child.log", loss=Loss.ENDS_MISSION)
    (notice,) = tick_until(supervise(spec), Change.ENDED)
    assert notice.exit_code not in (0, None)


def test_restarts_after_signals_are_bounded(tmp_path, supervise):
    dies = "import os, signal\nos.kill(os.getpid(), signal.SIGKILL)"
    supervisor = supervise(child(tmp_path, dies, readiness=Readiness.STARTED, restarts=3))
    notices = [notice for notice in tick_until(supervisor, Change.ENDED) if notice.change is not Change.READY]
    assert [notice.change for notice in notices] == [Change.RESTARTED] * 3 + [Change.ENDED]
    assert notices[-1].exit_code == -signal.SIGKILL
    assert "SIGKILL" in notices[-1].text


@pytest.mark.parametrize("exit_code", [0, 1, 2])
def test_an_exit_code_is_no_reason_to_restart(tmp_path, supervise, exit_code):
    supervisor = supervise(child(tmp_path, f"raise SystemExit({exit_code})", readiness=Readiness.STARTED, restarts=3))
    notices = tick_until(supervisor, Change.ENDED)
    assert all(notice.change is not Change.RESTARTED for notice in notices)
    assert notices[-1].exit_code == exit_code


def test_a_restarted_process_must_get_ready_again(tmp_path, supervise):
    supervisor = supervise(child(tmp_path, WAITS, restarts=1))
    tick_until(supervisor, Change.READY)
    pid = supervisor.pid("child")
    assert pid is not None
    os.kill(pid, signal.SIGKILL)
    tick_until(supervisor, Change.RESTARTED)
    assert supervisor.state("child") is not State.READY
    tick_until(supervisor, Change.READY)
    assert supervisor.pid("child") not in (None, pid)


def test_stop_asks_first_and_kills_who_does_not_listen(tmp_path, supervise):
    polite = child(tmp_path, WAITS, "polite")
    ignores = "import signal\nsignal.signal(signal.SIGTERM, signal.SIG_IGN)\n" + WAITS
    deaf = child(tmp_path, ignores, "deaf", stop_within_s=0.3)
    supervisor = supervise(polite, deaf)
    notices = tick_until(supervisor, Change.READY, "polite")
    if not any(notice.spec.name == "deaf" for notice in notices):
        tick_until(supervisor, Change.READY, "deaf")
    pids = supervisor.pids()
    supervisor.stop_all()
    assert supervisor.exit_code("polite") == -signal.SIGTERM
    assert supervisor.exit_code("deaf") == -signal.SIGKILL
    assert all(gone(pid) for pid in pids.values())
    assert supervisor.tick() == []  # an asked-for end is nobody's loss


def test_hurry_kills_at_once(tmp_path, supervise):
    ignores = "import signal\nsignal.signal(signal.SIGTERM, signal.SIG_IGN)\n" + WAITS
    supervisor = supervise(child(tmp_path, ignores, stop_within_s=3600.0))
    tick_until(supervisor, Change.READY)
    supervisor.stop_all(hurry=lambda: True)
    assert supervisor.exit_code("child") == -signal.SIGKILL


def test_the_environment_of_the_table_reaches_the_process(tmp_path, supervise):
    code = "import os\nprint(os.environ['FLEET_TEST'], flush=True)\n" + WAITS
    supervisor = supervise(child(tmp_path, code, environment={"FLEET_TEST": "seen"}))
    tick_until(supervisor, Change.READY)
    assert (tmp_path / "child.log").read_text().startswith("seen\n")


def test_a_name_is_taken_once(tmp_path):
    spec = child(tmp_path, WAITS)
    with pytest.raises(ValueError, match="child"):
        Supervisor((spec, spec))


PARENT = """
import sys, time
from pathlib import Path
from missions.interrupts import Interrupts
from missions.supervisor import *
code = "import signal, time; signal.signal(signal.SIGINT, signal.SIG_IGN); print('ready', flush=True); time.sleep(600)"
specs = [
    ProcessSpec(name=f"child-{i}", argv=(sys.executable, "-I", "-S", "-c", code),
                log=Path(sys.argv[1]) / f"{i}.log", loss=Loss.ENDS_MISSION)
    for i in range(3)
]
supervisor = Supervisor(specs)
ready = 0
with Interrupts() as interrupts:
    while interrupts.first is None:
        ready += sum(notice.change is Change.READY for notice in supervisor.tick())
        if ready == 3:
            print(*supervisor.pids().values(), flush=True)
            ready = 0
        time.sleep(0.01)
    supervisor.stop_all(interrupts.in_hurry)
sys.exit(interrupts.exit_code)
"""


@pytest.mark.parametrize(
    ("what", "exit_code"),
    [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129), (signal.SIGKILL, -9)],
)
def test_no_child_outlives_its_parent(tmp_path, what, exit_code):
    parent = subprocess.Popen(
        [sys.executable, "-c", PARENT, str(tmp_path)], cwd=REPOSITORY, stdout=subprocess.PIPE, text=True
    )
    try:
        assert parent.stdout is not None
        pids = [int(word) for word in parent.stdout.readline().split()]
        assert len(pids) == 3
        assert not any(gone(pid) for pid in pids)
        parent.send_signal(what)
        assert parent.wait(timeout=DEADLINE_S) == exit_code
        until(lambda: all(gone(pid) for pid in pids))
    finally:
        parent.kill()
        parent.wait()


def test_a_parent_that_died_before_the_launcher_looked_leaves_no_child(tmp_path):
    launcher = REPOSITORY / "missions" / "launch.py"
    mark = tmp_path / "ran"
    nobody = "1" if os.getpid() != 1 else "2"
    program = [sys.executable, "-I", "-S", "-c", f"open({str(mark)!r}, 'w')"]
    launched = subprocess.run([sys.executable, "-I", "-S", str(launcher), nobody, "9", *program], check=False)
    assert launched.returncode == 1
    assert not mark.exists()


def test_lines_go_to_our_standard_output(tmp_path, supervise, capfd):
    code = "import sys\nprint('seen by people', flush=True)\nprint('kept', file=sys.stderr, flush=True)"
    supervisor = supervise(child(tmp_path, code, output=Output.LINES, readiness=Readiness.STARTED))
    tick_until(supervisor, Change.ENDED)
    assert capfd.readouterr().out == "seen by people\n"
    assert (tmp_path / "child.log").read_text() == "kept\n"
