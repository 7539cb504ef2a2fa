"""The event loop of one agent: takes in what its ports heard, steps the agent, and carries out what it decides."""

from __future__ import annotations

import asyncio
import faulthandler
import logging
import os
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

import msgspec
import numpy as np

from vehicle_agent.domain.team_map import TeamMap
from vehicle_agent.link.counters import LinkCounters
from vehicle_agent.ports import Autopilot, Inbox, Journal, Outbox, Payload, Team, TeammateRange
from vehicle_agent.wire.messages import AnyMessage, Event, Severity, Stage

SILENT_STEP_S = 0.5
"""Wall time between steps while the autopilot is silent."""
IDLE_POLL_S = 0.05
"""Longest wall time between two looks at the autopilot."""
HUNG_AFTER_S = 20.0
"""Wall time in one step after which the process ends itself, so that its heartbeats end with it."""
KEPT_STEP_TIMES = 50_000

_log = logging.getLogger(__name__)


class Agent(Protocol):
    """What the loop needs of `vehicle_agent.agent.VehicleAgent`."""

    @property
    def stage(self) -> Stage: ...

    bytes_sent: int
    messages_dropped: int

    @property
    def map(self) -> TeamMap: ...

    @property
    def finished(self) -> bool: ...

    @property
    def first_seen_cells(self) -> float: ...

    def step(self, now_s: float, inbox: Inbox) -> Outbox: ...


class VehicleClock:
    """The vehicle's own time, carried on at the pace of the wall clock while the autopilot is silent.

    Attributes
    ----------
    now_s
        Unix seconds by the vehicle, never running backwards; 0 before the autopilot has told.
    """

    def __init__(self) -> None:
        self.now_s = 0.0
        self._heard_wall_s: float | None = None
        self._heard_s = 0.0

    @property
    def is_set(self) -> bool:
        return self._heard_wall_s is not None

    def hear(self, vehicle_s: float, wall_s: float) -> None:
        """Take the autopilot's time."""
        self._heard_wall_s, self._heard_s = wall_s, vehicle_s
        self.now_s = max(self.now_s, vehicle_s)

    def carry_on(self, wall_s: float) -> None:
        """Let time pass at the pace of the wall clock, once the autopilot has been silent for a moment."""
        if self._heard_wall_s is not None:
            silent_s = max(0.0, wall_s - self._heard_wall_s - SILENT_STEP_S)
            self.now_s = max(self.now_s, self._heard_s + silent_s)


class AgentResult(msgspec.Struct, frozen=True, kw_only=True):
    """What `result.json` says of one agent's run.

    Attributes
    ----------
    vehicle, stage
        Who, and where it stood at the end.
    known_cells, first_seen_cells
        Cells on its map, and those that it saw first (ties shared).
    bytes_sent, messages_sent, bytes_received, messages_received
        Over the team's radio.
    dropped
        Messages lost at this end, for whatever reason.
    steps, step_ms_median, step_ms_p99
        How often the agent decided and how long that took, wall time.
    """

    vehicle: str
    stage: str
    known_cells: int
    first_seen_cells: float
    bytes_sent: int
    messages_sent: int
    bytes_received: int
    messages_received: int
    dropped: int
    steps: int
    step_ms_median: float
    step_ms_p99: float


class Runtime:
    """Runs one agent on its ports until told to stop.

    Parameters
    ----------
    name
        The vehicle's.
    agent, autopilot, team, payload, journal
        The agent and its world.
    clock
        Vehicle time; shared with whatever counts in it.
    counters
        The radio's counts so far.
    folder
        Where `result.json` and `map.npz` go; None keeps nothing.
    wall_clock
        Seconds that grow steadily.
    ranges
        What the modem makes of messages that have just been heard; nothing, with a radio that is none.
    """

    def __init__(
        self,
        name: str,
        agent: Agent,
        autopilot: Autopilot,
        team: Team,
        payload: Payload,
        journal: Journal,
        *,
        clock: VehicleClock,
        counters: Callable[[], LinkCounters],
        folder: Path | None,
        wall_clock: Callable[[], float] = time.monotonic,
        ranges: Callable[[list[AnyMessage]], list[TeammateRange]] = lambda _: [],
    ) -> None:
        self._name = name
        self._agent = agent
        self._autopilot, self._team, self._payload, self._journal = autopilot, team, payload, journal
        self._clock = clock
        self._counters = counters
        self._folder = folder
        self._wall_clock = wall_clock
        self._ranges = ranges
        self._inbox = Inbox()
        self._stepped_wall_s = wall_clock()
        self._watched_wall_s = -1e9
        self._steps = 0
        self._step_s: deque[float] = deque(maxlen=KEPT_STEP_TIMES)
        self._told_finished = False

    async def run(self, stop: asyncio.Event, news: asyncio.Event, exit_when_done: bool = False) -> None:
        """Turn until `stop` is set, or until the agent has finished if `exit_when_done`.

        A finished agent goes on turning otherwise: it still mends others' maps. Raises what the ports raise.

        Parameters
        ----------
        news
            Set when the autopilot has something to poll.
        """
        try:
            while not stop.is_set() and not (exit_when_done and self._agent.finished):
                news.clear()
                self.turn()
                if self._agent.finished and not self._told_finished:
                    self._told_finished = True
                    self.write_results()
                waiting = (asyncio.create_task(news.wait()), asyncio.create_task(stop.wait()))
                await asyncio.wait(waiting, timeout=IDLE_POLL_S, return_when=asyncio.FIRST_COMPLETED)
                for task in waiting:
                    task.cancel()
        finally:
            faulthandler.cancel_dump_traceback_later()
            self.write_results()

    def turn(self) -> bool:
        """Look at the autopilot, and step the agent when there is a new state or has been none for a while."""
        wall_s = self._wall_clock()
        self._rearm_watchdog(wall_s)
        state, results, texts = self._autopilot.poll()
        self._inbox.results += results
        self._inbox.texts += texts
        if state is not None:
            self._inbox.state = state
            self._clock.hear(state.stamp_ms / 1000.0, wall_s)
        elif wall_s - self._stepped_wall_s < SILENT_STEP_S or not self._clock.is_set:
            return False
        self._clock.carry_on(wall_s)
        self._stepped_wall_s = wall_s
        self._step()
        return True

    def write_results(self) -> None:
        """Write `result.json` and `map.npz`, each whole or not at all."""
        if self._folder is None:
            return
        self._folder.mkdir(parents=True, exist_ok=True)
        encoded = msgspec.json.format(msgspec.json.encode(self.result()), indent=2)
        _replace(self._folder / "result.json", lambda path: path.write_bytes(encoded + b"\n"))
        known = self._agent.map

        def save_map(path: Path) -> None:
            with path.open("wb") as file:
                np.savez_compressed(file, **known.arrays())  # type: ignore[arg-type]

        _replace(self._folder / "map.npz", save_map)

    def result(self) -> AgentResult:
        counts = self._counters()
        times_ms = np.array(self._step_s or [0.0]) * 1e3
        return AgentResult(
            vehicle=self._name,
            stage=self._agent.stage.name.lower(),
            known_cells=int(self._agent.map.observed.sum()),
            first_seen_cells=round(self._agent.first_seen_cells, 3),
            bytes_sent=counts.bytes_sent,
            messages_sent=counts.messages_sent,
            bytes_received=counts.bytes_received,
            messages_received=counts.messages_received,
            dropped=counts.dropped,
            steps=self._steps,
            step_ms_median=round(float(np.median(times_ms)), 3),
            step_ms_p99=round(float(np.percentile(times_ms, 99)), 3),
        )

    def _step(self) -> None:
        inbox, self._inbox = self._inbox, Inbox()
        inbox.messages = self._team.poll()
        inbox.scans = self._payload.poll()
        inbox.ranges = self._ranges(inbox.messages)
        counts = self._counters()
        self._agent.bytes_sent, self._agent.messages_dropped = counts.bytes_sent, counts.dropped
        began_s = time.perf_counter()
        outbox = self._agent.step(self._clock.now_s, inbox)
        self._step_s.append(time.perf_counter() - began_s)
        self._steps += 1
        self._journal.append(outbox.journal)
        for action in outbox.actions:
            self._autopilot.submit(action)
        for message in outbox.messages:
            if isinstance(message, Event):
                level = logging.WARNING if message.severity <= Severity.WARNING else logging.INFO
                _log.log(level, "%s: %s", message.code, message.text)
            self._team.publish(message)

    def _rearm_watchdog(self, wall_s: float) -> None:
        """Put off the end that comes over a process whose loop hangs, whatever holds it."""
        if wall_s - self._watched_wall_s >= 1.0:
            self._watched_wall_s = wall_s
            faulthandler.dump_traceback_later(HUNG_AFTER_S, exit=True)


def _replace(path: Path, write: Callable[[Path], object]) -> None:
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    write(draft)
    draft.replace(path)
