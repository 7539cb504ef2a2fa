"""The ground station without a terminal: one line per event, one status line per interval."""

from __future__ import annotations

import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from ground_station.link import Link
from ground_station.notice import read_notice
from ground_station.picture import FleetState, LogEntry, VehiclePicture
from ground_station.station import Station
from ground_station.text import clean
from vehicle_agent.wire.messages import Severity

if TYPE_CHECKING:
    from ground_station.player import Player

STEP_S = 0.1


def event_line(entry: LogEntry, started_ms: int) -> str:
    """`event t=83.0s vehicle=merlin severity=notice code=took-off climbing to 60 m`."""
    elapsed_s = max(0, entry.stamp_ms - started_ms) / 1_000 if entry.stamp_ms else 0.0
    severity = Severity(entry.severity).name.lower()
    return f"event t={elapsed_s:.1f}s vehicle={entry.source} severity={severity} code={entry.code} {entry.text}"


def status_line(state: FleetState) -> str:
    """`status t=85.0s phase=working coverage=12.3% speedup=10.0 bad=0 merlin=live/working/guided/87%/31.0%/0.2s ...`.

    Per vehicle: condition, stage, mode, battery, share of the area seen first, age of the last status; `-` where
    nothing is known. Vehicles come in the mission's order.
    """
    speedup = "-" if state.speedup is None else f"{state.speedup:.1f}"
    fields = [
        f"status t={state.elapsed_s:.1f}s phase={state.phase.value} coverage={100 * state.coverage:.1f}%",
        f"speedup={speedup} bad={state.counters.bad}",
        *(_vehicle_field(state, vehicle) for vehicle in state.vehicles),
    ]
    return " ".join(fields)


def _vehicle_field(state: FleetState, vehicle: VehiclePicture) -> str:
    status, silence_s = vehicle.status, vehicle.age_s(state.now_s)
    if status is None or silence_s is None:
        return f"{vehicle.name}={vehicle.condition.value}/-/-/-/-/-"
    battery = "-" if status.battery_permille < 0 else f"{status.battery_permille / 10:.0f}%"
    share = 100 * state.team_map.first_seen_share(vehicle.index)
    stage = status.stage.name.lower().replace("_", "-")
    mode = status.mode.replace(" ", "-").replace("/", "-") or "-"
    return f"{vehicle.name}={vehicle.condition.value}/{stage}/{mode}/{battery}/{share:.1f}%/{silence_s:.1f}s"


class PlainLog:
    """Turns pictures into lines: what is new in the log at once, a status line every `interval_s` of wall time."""

    def __init__(self, interval_s: float, now_s: float) -> None:
        self._interval_s = interval_s
        self._due_s = now_s
        self._written = 0
        self._notice = ""

    def lines(self, state: FleetState, notice: str = "") -> list[str]:
        lines = []
        if notice and notice != self._notice:
            lines.append(f"notice {clean(notice)}")
        self._notice = notice
        fresh = state.log_total - self._written
        if fresh:
            lines += [event_line(entry, state.started_ms) for entry in state.log[-fresh:]]
            self._written = state.log_total
        if state.now_s >= self._due_s:
            lines.append(status_line(state))
            self._due_s = state.now_s + self._interval_s
        return lines


def replay_lines(player: Player, interval_s: float) -> Iterator[str]:
    """The lines of a recording as fast as they can be made, a status line every `interval_s` of recorded time."""
    log = PlainLog(interval_s, player.state.now_s)
    second = 0.0
    while not player.at_end:
        second += STEP_S
        player.seek(second)
        yield from log.lines(player.state)
        second = max(second, player.position_s)
    yield status_line(player.state)
    if not player.recording.complete:
        yield f"notice {player.recording.path} is cut off: this is all that there is"


def run_plain(
    station: Station,
    connect: Callable[[], Link],
    *,
    interval_s: float = 5.0,
    notice_file: Path | None = None,
    exit_when_done: bool = False,
    clock: Callable[[], float] = time.monotonic,
    output: TextIO | None = None,
) -> None:
    """Write lines until every vehicle is done (if so asked), SIGINT or SIGTERM; raises LinkError, BrokenPipeError."""
    output = output or sys.stdout
    stop = threading.Event()
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    former = [signal.signal(number, lambda *_: stop.set()) for number in numbers]
    try:
        station.attach(connect())
        log = PlainLog(interval_s, clock())
        stopping = False
        while not stopping:
            state = station.step(clock())
            stopping = stop.is_set() or (exit_when_done and state.finished)
            lines = log.lines(state, "" if state.heard_any else read_notice(notice_file))
            if stopping:
                lines.append(status_line(state))
            for line in lines:
                print(_encodable(line, output), file=output)
            if lines:
                output.flush()
            stop.wait(0.0 if stopping else STEP_S)
    finally:
        for number, handler in zip(numbers, former, strict=True):
            signal.signal(number, handler)


def _encodable(line: str, output: TextIO) -> str:
    encoding = output.encoding or "utf-8"
    return line.encode(encoding, "replace").decode(encoding)
