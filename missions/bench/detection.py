"""How soon a loss is on the screen, with real processes: agents killed, cut off, and cut off for two seconds only."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from missions.bench.pty_screen import Screen
from missions.bench.relay import Relay
from missions.bench.talking_fleet import mission_text
from vehicle_agent.link.profile import LEASE_MS
from vehicle_agent.mission.load import MissionPlan, load_mission

COLUMNS, ROWS = 120, 40
PATIENCE_S = 60.0
OUTAGE_S = 2.0
MOST_KILLED_S = 0.5
MOST_CUT_S = LEASE_MS / 1_000 + 0.5
MOST_PROPOSAL_S = 2.0
ALARM = b"LOST "


@dataclass(slots=True)
class Figures:
    """What was measured; seconds from the act to the text on the terminal.

    Attributes
    ----------
    outages
        How often a vehicle was cut off for two seconds.
    false_losses
        How often the screen told of a loss that was none.
    unseen
        What never came on the screen.
    """

    vehicles: int
    killed_s: list[float] = field(default_factory=list)
    cut_s: list[float] = field(default_factory=list)
    proposal_s: list[float] = field(default_factory=list)
    outages: int = 0
    false_losses: int = 0
    unseen: list[str] = field(default_factory=list)


class Agents:
    """Processes that talk, one per vehicle; they end when this one does."""

    def __init__(self, plan: MissionPlan) -> None:
        self._plan = plan
        self._base_s = int(time.time()) - 60
        self._boots = 0
        self._processes: dict[int, subprocess.Popen[bytes]] = {}

    def start(self, indices: range) -> None:
        """Start some, and wait until all of them can be heard."""
        for index in indices:
            self._boots += 1
            arguments = [str(self._plan.source), str(index), str(self._boots), str(self._base_s)]
            self._processes[index] = subprocess.Popen(
                [sys.executable, "-m", "missions.bench.talking_agent", *arguments],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            )  # fmt: skip
        for index in indices:
            out = self._processes[index].stdout
            if out is None or out.readline() != b"ready\n":
                raise RuntimeError(f"the talking agent of vehicle {index + 1} did not start")

    def kill(self, index: int) -> float:
        """Kill one at once; returns the moment."""
        process = self._processes.pop(index)
        moment_s = time.monotonic()
        process.send_signal(signal.SIGKILL)
        self._end(process)
        return moment_s

    def close(self) -> None:
        for process in self._processes.values():
            process.kill()
            self._end(process)
        self._processes.clear()

    def _end(self, process: subprocess.Popen[bytes]) -> None:
        process.wait()
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                pipe.close()


class Trial:
    """A dashboard over talking agents, and what is done to them."""

    def __init__(self, screen: Screen, agents: Agents, relay: Relay, figures: Figures) -> None:
        self._screen, self._agents, self._relay, self._figures = screen, agents, relay, figures
        self._all_live = f" {figures.vehicles} live".encode()

    def begin(self) -> None:
        self._await_all("the fleet at the start")

    def kill(self, index: int) -> None:
        """One agent dies; it is shown lost, a re-plan is proposed, and it comes back."""
        killed_s = self._agents.kill(index)
        drawn = self._note(self._figures.killed_s, killed_s, ALARM, f"the death of vehicle {index + 1}")
        self._note(self._figures.proposal_s, killed_s, b"RE-PLAN", f"a proposal without vehicle {index + 1}", drawn)
        self._screen.press(b"n", b"Re-plan")
        self._screen.type(b"n")  # leave it to the agents
        self._agents.start(range(index, index + 1))
        self._await_all(f"vehicle {index + 1} anew")

    def cut(self, index: int) -> None:
        """One line is cut until the vehicle is shown lost."""
        began_s = time.monotonic()
        self._relay.cut([index])
        self._note(self._figures.cut_s, began_s, ALARM, f"the loss of vehicle {index + 1}")
        self._relay.cut([])
        self._screen.read_for(1.0)
        self._screen.press(b"n", b"Re-plan")
        self._screen.type(b"n")
        self._await_all(f"vehicle {index + 1} again")

    def outage(self) -> None:
        """Nobody is heard for two seconds, which is no loss."""
        self._relay.cut(range(self._figures.vehicles))
        drawn = self._screen.read_for(OUTAGE_S)
        self._relay.cut([])
        drawn += self._screen.read_for(MOST_CUT_S)
        self._figures.outages += self._figures.vehicles
        self._figures.false_losses += drawn.count(ALARM)
        if ALARM in drawn:
            self._await_all("the fleet after an outage")

    def _note(self, durations_s: list[float], began_s: float, awaited: bytes, what: str, drawn: bytes = b"") -> bytes:
        """Wait until a text is drawn, unless it was, and note how long it took; returns what was drawn meanwhile."""
        if awaited not in drawn:
            drawn = self._screen.read_for(PATIENCE_S, awaited)
        if awaited in drawn:
            durations_s.append(round(time.monotonic() - began_s, 3))
        else:
            self._figures.unseen.append(what)
        return drawn

    def _await_all(self, what: str) -> None:
        if self._all_live not in self._screen.read_for(PATIENCE_S, self._all_live):
            self._figures.unseen.append(what)
        self._screen.read_for(1.0)


@contextmanager
def trial(vehicles: int) -> Iterator[tuple[Trial, Figures]]:
    """Everything running, and everything ended again."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        mission = folder / "bench.toml"
        mission.write_text(mission_text(vehicles, free_ports(vehicles + 1)), encoding="utf-8")
        plan = load_mission(mission)
        agents = Agents(plan)
        stack.callback(agents.close)
        agents.start(range(vehicles))
        host, first_port = plan.mission.radio.endpoint_host, plan.mission.radio.zenoh_port + 1
        relay = stack.enter_context(Relay([(host, first_port + index) for index in range(vehicles)]))
        endpoints = [word for port in relay.ports for word in ("--endpoint", f"tcp/127.0.0.1:{port}")]
        screen = stack.enter_context(Screen("ground_station.cli", [str(mission), *endpoints], COLUMNS, ROWS))
        figures = Figures(vehicles)
        one = Trial(screen, agents, relay, figures)
        one.begin()
        yield one, figures


def free_ports(count: int) -> int:
    """The first of so many neighbouring TCP ports that nobody uses now."""
    for first in range(20_000 + os.getpid() % 8_000, 60_000, count):
        probes: list[socket.socket] = []
        try:
            probes.extend(socket.create_server(("127.0.0.1", port)) for port in range(first, first + count))
        except OSError:
            continue
        finally:
            for probe in probes:
                probe.close()
        return first
    raise RuntimeError("no free ports")


def detect(vehicles: int, kills: int, cuts: int, outages: int) -> Figures:
    """Do all that, one after the other, each to the next vehicle."""
    with trial(vehicles) as (one, figures):
        for number in range(kills):
            one.kill(number % vehicles)
        for number in range(cuts):
            one.cut(number % vehicles)
        for _ in range(outages):
            one.outage()
    return figures


def missed(figures: Figures) -> list[str]:
    """The bars that were not held."""
    failed = [f"never shown: {what}" for what in figures.unseen]
    for name, values, share, most_s in (
        ("killed to lost, p99", figures.killed_s, 99, MOST_KILLED_S),
        ("cut off to lost, longest", figures.cut_s, 100, MOST_CUT_S),
        ("lost to proposal, longest", figures.proposal_s, 100, MOST_PROPOSAL_S),
    ):
        if values and np.percentile(values, share) > most_s:
            failed.append(f"{name}: {np.percentile(values, share):.2f} s > {most_s:g} s")
    if figures.false_losses:
        failed.append(f"{figures.false_losses} false losses in outages of {OUTAGE_S:g} s")
    return failed


def table(figures: Figures) -> str:
    """The figures as lines for people."""
    lines = [f"{'seconds':<22}{'trials':>7}{'median':>8}{'p99':>8}{'longest':>8}{'bar':>7}"]
    for name, values, most_s in (
        ("killed to lost", figures.killed_s, MOST_KILLED_S),
        ("cut off to lost", figures.cut_s, MOST_CUT_S),
        ("killed to proposal", figures.proposal_s, MOST_PROPOSAL_S),
    ):
        if values:
            median, p99, longest = np.percentile(values, (50, 99, 100))
            lines.append(f"{name:<22}{len(values):>7}{median:>8.2f}{p99:>8.2f}{longest:>8.2f}{most_s:>7.1f}")
    lines.append(f"{figures.outages} outages of {OUTAGE_S:g} s: {figures.false_losses} false losses")
    return "\n".join([*lines, *(f"missed: {text}" for text in missed(figures))])


def bench_detection(vehicles: int, kills: int, cuts: int, outages: int, json_file: Path | None) -> int:
    """Measure, print, keep; 0 when every bar is held, else 1."""
    figures = detect(vehicles, kills, cuts, outages)
    print(table(figures))
    load = {"cores": os.cpu_count(), "load_average": round(os.getloadavg()[0], 1)}
    print(f"load average {load['load_average']} on {load['cores']} cores")
    if json_file is not None:
        content = {**asdict(figures), **load, "missed": missed(figures)}
        json_file.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    return int(bool(missed(figures)))
