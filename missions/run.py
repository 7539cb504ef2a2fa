"""Flies a mission with real processes: dashboard first, then kernels, simulator and agents; then the summary."""

from __future__ import annotations

import os
import signal
import sys
import time
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from missions import processes
from missions.ending import Ending
from missions.flown import write_flown
from missions.free_ports import check_ports
from missions.interrupts import Interrupts
from missions.memory import proportional_set_bytes
from missions.observer import Observer
from missions.report import RunFacts, summarise
from missions.summary import summary_text, write_summary
from missions.supervisor import Change, Loss, Notice, Supervisor
from missions.terminal import Terminal
from missions.yardstick import observable
from vehicle_agent.mission.load import MissionError, MissionPlan

TICK_S = 0.1
MEMORY_PERIOD_S = 2.0
COMPILING_SHOWS_AFTER_S = 1.5
"""Loading cached kernels takes less."""
COMPILING = "compiling kernels (first start only)"
USER_ERROR = 2
OPERATOR_INTERRUPT = 128 + int(signal.SIGINT)
"""Exit code with which the dashboard tells that the operator wants everything to stop."""


def new_run_dir(runs_dir: Path, name: str, when: datetime) -> Path:
    """Create `<UTC yyyymmdd-hhmmss>-<name>` in the runs folder; raises MissionError when it cannot."""
    stem = f"{when.astimezone(UTC):%Y%m%d-%H%M%S}-{name}"
    for suffix in ("", *(f"-{number}" for number in range(2, 100))):
        try:
            (runs_dir / f"{stem}{suffix}").mkdir(parents=True)
        except FileExistsError:
            if runs_dir.is_dir():
                continue
            raise MissionError(f"{runs_dir}: is not a folder; choose another with --runs-dir") from None
        except OSError as error:
            raise MissionError(f"{runs_dir}: {error.strerror}; choose another folder with --runs-dir") from None
        return runs_dir / f"{stem}{suffix}"
    raise MissionError(f"{runs_dir}: has 99 runs of this second; wait a second")


def run_mission(plan: MissionPlan, runs_dir: Path, plain: bool) -> int:
    """Fly a checked mission to its end and return the exit code: 0 aim reached, 1 not, 128 + signal when stopped.

    Raises MissionError, one sentence, when the fleet cannot be started; nothing runs any more then.
    """
    if processes.simulated_names(plan):
        from sim_bridge.world import World  # loads numba: only where a world is simulated

        World.of(plan)
    check_ports(plan)
    run_dir = new_run_dir(runs_dir, plan.mission.name, datetime.now(UTC))
    with Interrupts() as interrupts:
        run = MissionRun(write_flown(plan, run_dir), run_dir, None if plain else Terminal.grab(), interrupts)
        return run.fly()


@dataclass(slots=True)
class MissionRun:
    """One run.

    Attributes
    ----------
    plan
        The mission as flown, loaded from the run folder.
    terminal
        The terminal for the dashboard; None for lines on standard output.
    interrupts
        Requests to stop.
    """

    plan: MissionPlan
    run_dir: Path
    terminal: Terminal | None
    interrupts: Interrupts
    started_s: float = field(default_factory=time.monotonic)
    supervisor: Supervisor = field(default_factory=lambda: Supervisor(()))
    warnings: list[str] = field(default_factory=list)
    peak_memory_bytes: int = 0
    _over: tuple[Ending, str] | None = None
    _ready: set[str] = field(default_factory=set)
    _notice: str = ""
    _memory_due_s: float = 0.0
    _terminal_lent: bool = False

    def fly(self) -> int:
        """Start everything, wait for the end, stop everything, judge."""
        try:
            return self._fly()
        finally:
            self.supervisor.kill_all()
            self._reclaim_terminal()

    def _fly(self) -> int:
        self._show_notice("starting")
        view = processes.line_log_spec if self.terminal is None else processes.dashboard_spec
        with Observer(self.plan, self.run_dir, time.monotonic) as observer:
            self.supervisor.add(view(self.plan, self.run_dir, self._notice_file))
            for spec in processes.fleet_table(self.plan, self.run_dir):
                self.supervisor.add(spec)
            while self._over is None:
                self._turn(observer)
                time.sleep(TICK_S)
            self._stop_fleet()
        return self._judge(observer)

    @property
    def _notice_file(self) -> Path:
        return self.run_dir / "notice.txt"

    def _turn(self, observer: Observer) -> None:
        for notice in self.supervisor.tick():
            self._take(notice, observer)
        observer.poll()
        now_s = time.monotonic()
        self._show_progress(now_s)
        if now_s >= self._memory_due_s:
            self._memory_due_s = now_s + MEMORY_PERIOD_S
            pids = (*self.supervisor.pids().values(), os.getpid())
            self.peak_memory_bytes = max(self.peak_memory_bytes, proportional_set_bytes(pids))
        if self.interrupts.first is not None:
            self._over = self._over or (Ending.STOPPED, f"stopped by {self.interrupts.cause}")
        self._over = self._over or observer.watch.ending(now_s)

    def _take(self, notice: Notice, observer: Observer) -> None:
        spec = notice.spec
        if notice.change is Change.READY:
            self._ready.add(spec.name)
            self._terminal_lent |= spec.name == processes.DASHBOARD
        elif spec.loss is Loss.LOSES_VIEW:
            self._view_changed(notice)
        elif spec.loss is Loss.ENDS_MISSION or spec.name not in self._ready:
            if spec.name not in self._ready:  # it never worked: a fault of the set-up, not of the mission
                raise MissionError(notice.text)
            self._over = (Ending.BROKEN, notice.text)
        else:
            observer.watch.agent_ended(spec.name)
            self._warn(f"agent {notice.text}")

    def _view_changed(self, notice: Notice) -> None:
        """Go on without a dashboard when it is gone."""
        self._reclaim_terminal(notice.exit_code)
        if notice.change is Change.RESTARTED:
            self._warn(notice.text)
        elif notice.exit_code == OPERATOR_INTERRUPT:
            self.interrupts.request(signal.SIGINT)
        elif notice.spec.name == processes.DASHBOARD:
            self.supervisor.add(processes.line_log_spec(self.plan, self.run_dir, self._notice_file))
            if notice.exit_code == 0:
                self._say(
                    f"dashboard closed; the mission goes on, Ctrl-C stops it, and "
                    f"`ground-station {self.plan.source}` opens another"
                )
            else:
                self._warn(f"{notice.text}; the mission goes on without it")
        else:
            self._warn(f"{notice.text}; the mission goes on unseen")

    def _reclaim_terminal(self, exit_code: int | None = None) -> None:
        """Take the terminal back from a dashboard that has ended; a killed one has left it in a mess."""
        if exit_code is None:
            exit_code = self.supervisor.exit_code(processes.DASHBOARD)
        if self.terminal is not None and self._terminal_lent and exit_code is not None and exit_code < 0:
            self.terminal.restore()
        self._terminal_lent = False

    def _show_progress(self, now_s: float) -> None:
        if processes.KERNELS not in self._ready:
            compiling = now_s - self.started_s > COMPILING_SHOWS_AFTER_S
            self._show_notice(COMPILING if compiling else "starting")
        elif len(self._ready & set(self.plan.vehicle_names)) < len(self.plan.vehicle_names):
            self._show_notice("starting the vehicles")
        else:
            self._show_notice("")

    def _show_notice(self, text: str) -> None:
        if text != self._notice:
            self._notice = text
            fresh = self._notice_file.with_suffix(".new")
            fresh.write_text(f"{text}\n", encoding="utf-8")
            fresh.replace(self._notice_file)

    def _stop_fleet(self) -> None:
        """View first, while its last picture is whole; then the agents, which write their maps; then the simulator."""
        views = [name for name in (processes.DASHBOARD, processes.LINE_LOG) if self.supervisor.has(name)]
        for names in (views, self.plan.vehicle_names):
            for name in names:
                self.supervisor.stop(name)
            self.supervisor.wait_ended(names, self.interrupts.in_hurry)
        self._reclaim_terminal()
        self.supervisor.stop_all(self.interrupts.in_hurry)
        self._notice_file.unlink(missing_ok=True)

    def _judge(self, observer: Observer) -> int:
        assert self._over is not None
        watch, (ending, ending_text) = observer.watch, self._over
        airborne_s = watch.first_airborne_s
        facts = RunFacts(
            ending=ending,
            ending_text=ending_text,
            wall_s=time.monotonic() - self.started_s,
            first_airborne_wall_s=None if airborne_s is None else airborne_s - self.started_s,
            peak_memory_bytes=self.peak_memory_bytes,
            warnings=tuple(self.warnings),
        )
        reachable = elevation_m = solid = None
        if processes.simulated_names(self.plan):
            from sim_bridge.world import World

            world = World.of(self.plan)
            elevation_m, reachable = world.elevation_m, observable(self.plan, world)
            solid = None if world.town is None else world.town.solid
        summary = summarise(self.plan, self.run_dir, watch, facts, reachable, elevation_m, solid)
        write_summary(summary, self.run_dir)
        print(summary_text(summary, self.run_dir), flush=True)
        stopped = self.interrupts.exit_code
        return stopped if stopped is not None else int(summary.verdict is not None)

    def _warn(self, text: str) -> None:
        self.warnings.append(text)
        self._say(text)

    def _say(self, text: str) -> None:
        if not self._terminal_lent:
            print(f"missions: {text}", file=sys.stderr, flush=True)
