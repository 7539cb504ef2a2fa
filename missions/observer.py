"""Listens to a running mission without being part of it: fills the run's log and follows when it is over."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

from ground_station.inputs import AliveChanged, Heard, Tick
from ground_station.link import LISTENED_TOPICS
from ground_station.picture import FleetState
from ground_station.recorder import RunRecorder
from ground_station.recording import FILE_NAME, RecordingWriter
from missions.ending import MissionWatch
from missions.processes import simulated_names
from vehicle_agent.link.session import FleetLink, LinkError
from vehicle_agent.link.tls import TlsFiles
from vehicle_agent.mission.load import MissionError, MissionPlan
from vehicle_agent.wire.messages import BodyReport


class Observer:
    """A station that says nothing. Raises MissionError when its link cannot be opened.

    Attributes
    ----------
    watch
        What was heard so far, and whether the mission is over.
    """

    def __init__(self, plan: MissionPlan, run_dir: Path, now: Callable[[], float]) -> None:
        self._now = now
        self.watch = MissionWatch.of(plan, now())
        endpoints = [plan.agent_endpoint(index) for index in range(len(plan.vehicle_names))]
        if simulated_names(plan):
            endpoints.append(plan.simulator_endpoint())
        try:
            name = f"observer-{secrets.token_hex(2)}"
            tls = TlsFiles.of(plan.tls_paths(name))
            self._link = FleetLink.open(plan.mission.name, name, connect=endpoints, tls=tls)
        except LinkError as error:
            raise MissionError(f"{plan.source}: {error}") from None
        self._recorder = RunRecorder(run_dir)
        self._recording = RecordingWriter(run_dir / FILE_NAME)
        self._recording.begin(FleetState.initial(plan, "observer", 0, now()))
        self._link.watch_alive()
        for topic in (*LISTENED_TOPICS, "command", "body"):
            self._link.subscribe(topic)

    def poll(self) -> None:
        """Take in what arrived since the last call."""
        messages, now_s = self._link.poll(), self._now()
        self.watch.hear(messages, now_s)
        self._recorder.record(messages)
        heard = [Heard(message, now_s) for message in messages if not isinstance(message, BodyReport)]
        alive = [AliveChanged(name, alive, now_s) for name, alive in self._link.poll_alive()]
        self._recording.write([*heard, *alive, Tick(now_s)])

    def __enter__(self) -> Observer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._link.close()
        self._recorder.close()
        self._recording.close()
