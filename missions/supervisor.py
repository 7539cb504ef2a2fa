"""Starts, watches, restarts and stops the processes of a table in one reconcile loop.

`tick` looks at every process once and moves it one step along; it never blocks, and it tells what changed as notices.
What a notice means for the mission is the caller's business.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path

LAUNCHER = Path(__file__).with_name("launch.py")
READY_LINE = "ready"


class Readiness(Enum):
    """How a process shows that others may rely on it."""

    STARTED = "started"
    """It counts as ready at once."""
    READY_LINE = "ready-line"
    """A line `ready` in its output."""
    FINISHED = "finished"
    """It has done its work and ended with exit code 0."""


class Output(Enum):
    """Where a process writes."""

    LOG = "log"
    """Standard output and error into its log file."""
    LINES = "lines"
    """Standard output is ours, standard error goes into its log file."""
    TERMINAL = "terminal"
    """It has the whole terminal, keyboard included."""


class Loss(Enum):
    """What the end of a process means for the mission."""

    ENDS_MISSION = "ends-mission"
    LOSES_VEHICLE = "loses-vehicle"
    LOSES_VIEW = "loses-view"


@dataclass(frozen=True, slots=True)
class ProcessSpec:
    """One line of the process table.

    Attributes
    ----------
    name
        Unique in the table.
    argv
        Absolute program path and its arguments.
    log
        File for its output, appended to.
    loss
        What its unplanned end means.
    readiness, ready_within_s
        How it shows that it is ready, and the wall time it has for that.
    after
        Processes that must be ready before it starts.
    restarts
        How often it is started anew after it was killed by a signal.
    output
        Where it writes.
    stop_signal, stop_within_s
        How it is asked to stop, and the wall time it has until it is killed.
    death_signal
        What the kernel sends it when its parent dies.
    environment
        Variables added to ours.
    """

    name: str
    argv: tuple[str, ...]
    log: Path
    loss: Loss
    readiness: Readiness = Readiness.READY_LINE
    ready_within_s: float = 30.0
    after: tuple[str, ...] = ()
    restarts: int = 0
    output: Output = Output.LOG
    stop_signal: signal.Signals = signal.SIGTERM
    stop_within_s: float = 5.0
    death_signal: signal.Signals = signal.SIGKILL
    environment: Mapping[str, str] = field(default_factory=dict)


class Change(Enum):
    """What happened to a process."""

    READY = "ready"
    RESTARTED = "restarted"
    ENDED = "ended"
    """It is gone for good; `Notice.exit_code` tells how."""
    NOT_READY = "not-ready"
    """It did not get ready in time and was killed."""
    NOT_STARTED = "not-started"
    """The operating system refused to start it."""


@dataclass(frozen=True, slots=True)
class Notice:
    """One change, with a sentence for people; `exit_code` is negative for a signal, as in `subprocess`."""

    spec: ProcessSpec
    change: Change
    text: str
    exit_code: int | None = None


class State(Enum):
    """Where a process stands."""

    WAITING = "waiting"
    STARTING = "starting"
    READY = "ready"
    STOPPING = "stopping"
    ENDED = "ended"


@dataclass(slots=True)
class _Child:
    spec: ProcessSpec
    state: State = State.WAITING
    process: subprocess.Popen[bytes] | None = None
    started_s: float = 0.0
    log_offset: int = 0
    restarts_used: int = 0
    kill_at_s: float = 0.0


class Supervisor:
    """Runs a table of processes. Use it from the main thread: children die with the thread that started them.

    Parameters
    ----------
    specs
        The table; a process that others wait for stands before them.
    now
        Monotonic wall clock, seconds.
    """

    def __init__(self, specs: Iterable[ProcessSpec], now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._children: dict[str, _Child] = {}
        for spec in specs:
            self.add(spec)

    def add(self, spec: ProcessSpec) -> None:
        """Add a process to the table; it starts with the next tick. Raises ValueError on a name that is taken."""
        if spec.name in self._children:
            raise ValueError(f"the process table already has '{spec.name}'")
        self._children[spec.name] = _Child(spec)

    def has(self, name: str) -> bool:
        return name in self._children

    def state(self, name: str) -> State:
        return self._children[name].state

    def pid(self, name: str) -> int | None:
        """Process id of a process that runs, else None."""
        child = self._children[name]
        running = child.state in (State.STARTING, State.READY, State.STOPPING)
        return child.process.pid if running and child.process else None

    def pids(self) -> dict[str, int]:
        """Process ids of everything that runs, by name."""
        return {name: pid for name in self._children if (pid := self.pid(name)) is not None}

    def exit_code(self, name: str) -> int | None:
        """Exit code of a process that ended, negative for a signal; None while it runs, or has not been started."""
        child = self._children.get(name)
        return None if child is None or child.process is None else child.process.poll()

    def tick(self) -> list[Notice]:
        """Move every process one step along and tell what changed."""
        notices: list[Notice] = []
        for child in list(self._children.values()):
            if child.state is State.WAITING and self._may_start(child):
                notices += self._start(child)
            if child.state in (State.STARTING, State.READY):
                notices += self._watch(child)
            elif child.state is State.STOPPING:
                self._see_off(child)
        return notices

    def stop(self, name: str) -> None:
        """Ask one process to stop; `tick` kills it when its time is over. Harmless when it does not run."""
        child = self._children[name]
        if child.state is State.WAITING:
            child.state = State.ENDED
        if child.state in (State.STARTING, State.READY):
            _send(child, child.spec.stop_signal)
            child.kill_at_s = self._now() + child.spec.stop_within_s
            child.state = State.STOPPING

    def stop_all(self, hurry: Callable[[], bool] = lambda: False) -> None:
        """Stop everything and wait for it: asked first, killed after `stop_within_s`, at once when `hurry` says so."""
        for name in self._children:
            self.stop(name)
        self.wait_ended(tuple(self._children), hurry)

    def wait_ended(self, names: Iterable[str], hurry: Callable[[], bool] = lambda: False) -> None:
        """Wait until processes that were asked to stop are gone."""
        waiting = [self._children[name] for name in names]
        while any(child.state is State.STOPPING for child in waiting):
            for child in waiting:
                if child.state is State.STOPPING:
                    if hurry():
                        child.kill_at_s = self._now()
                    self._see_off(child)
            time.sleep(0.02)

    def kill_all(self) -> None:
        """Kill whatever still runs, for the way out of an error."""
        for child in self._children.values():
            if child.process is not None and child.process.poll() is None:
                child.process.kill()
                child.process.wait()
            child.state = State.ENDED

    def _may_start(self, child: _Child) -> bool:
        return all(self._is_ready(self._children[name]) for name in child.spec.after)

    @staticmethod
    def _is_ready(child: _Child) -> bool:
        if child.spec.readiness is Readiness.FINISHED:
            return child.state is State.ENDED and child.process is not None and child.process.returncode == 0
        return child.state is State.READY

    def _start(self, child: _Child) -> list[Notice]:
        spec = child.spec
        launcher = (sys.executable, "-I", "-S", str(LAUNCHER), str(os.getpid()), str(int(spec.death_signal)))
        environment = {**os.environ, "PYTHONUNBUFFERED": "1", **spec.environment}
        try:
            spec.log.parent.mkdir(parents=True, exist_ok=True)
            with spec.log.open("ab") as log:
                child.log_offset = log.tell()
                child.process = subprocess.Popen(
                    [*launcher, *spec.argv],
                    stdin=None if spec.output is Output.TERMINAL else subprocess.DEVNULL,
                    stdout=log if spec.output is Output.LOG else None,
                    stderr=None if spec.output is Output.TERMINAL else log,
                    env=environment,
                    # Ctrl-C is ours to hand on in order, except for the process that owns the keyboard.
                    start_new_session=spec.output is not Output.TERMINAL,
                )
        except OSError as error:
            child.state = State.ENDED
            return [Notice(spec, Change.NOT_STARTED, f"{spec.name} cannot be started ({error})")]
        child.started_s = self._now()
        child.state = State.STARTING
        return []

    def _watch(self, child: _Child) -> list[Notice]:
        spec, process = child.spec, child.process
        assert process is not None
        exit_code = process.poll()
        if child.state is State.STARTING and self._shows_ready(child, exit_code):
            child.state = State.ENDED if spec.readiness is Readiness.FINISHED else State.READY
            return [Notice(spec, Change.READY, f"{spec.name} is ready", exit_code)]
        if exit_code is not None:
            return [self._bury(child, exit_code)]
        if child.state is State.STARTING and self._now() - child.started_s > spec.ready_within_s:
            process.kill()
            process.wait()
            child.state = State.ENDED
            text = f"{spec.name} was not ready within {spec.ready_within_s:g} s; {self._last_words(child)}"
            return [Notice(spec, Change.NOT_READY, text)]
        return []

    def _bury(self, child: _Child, exit_code: int) -> Notice:
        spec = child.spec
        how = _how_it_ended(exit_code)
        if exit_code < 0 and child.restarts_used < spec.restarts:
            child.restarts_used += 1
            child.state = State.WAITING
            text = f"{spec.name} {how}; started anew ({child.restarts_used} of {spec.restarts})"
            return Notice(spec, Change.RESTARTED, text, exit_code)
        child.state = State.ENDED
        why = f"see {spec.log}" if exit_code < 0 else self._last_words(child)
        return Notice(spec, Change.ENDED, f"{spec.name} {how}; {why}", exit_code)

    @staticmethod
    def _shows_ready(child: _Child, exit_code: int | None) -> bool:
        readiness = child.spec.readiness
        if readiness is Readiness.FINISHED:
            return exit_code == 0
        if readiness is Readiness.STARTED:
            return exit_code is None
        # Its word counts also when it died before anybody looked: what died was a working program.
        return any(line.strip() == READY_LINE for line in _log_lines(child))

    @staticmethod
    def _last_words(child: _Child) -> str:
        """Its last line, which for our programs is the sentence that tells the mend; else where to look."""
        lines = [line.strip() for line in _log_lines(child) if line.strip() and line.strip() != READY_LINE]
        return f'it said "{lines[-1][:400]}" ({child.spec.log})' if lines else f"see {child.spec.log}"

    def _see_off(self, child: _Child) -> None:
        assert child.process is not None
        if child.process.poll() is not None:
            child.state = State.ENDED
        elif self._now() >= child.kill_at_s:
            child.process.kill()


def _send(child: _Child, what: signal.Signals) -> None:
    assert child.process is not None
    child.process.send_signal(what)  # does nothing when it has already been reaped


def _log_lines(child: _Child) -> list[str]:
    """Complete lines that this start of the process has written."""
    with child.spec.log.open("rb") as log:
        log.seek(child.log_offset)
        return log.read().decode("utf-8", "replace").split("\n")[:-1]


def _how_it_ended(exit_code: int) -> str:
    if exit_code < 0:
        try:
            return f"was killed by {signal.Signals(-exit_code).name}"
        except ValueError:
            return f"was killed by signal {-exit_code}"
    return f"ended with exit code {exit_code}"
