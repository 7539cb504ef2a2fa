"""Listens to a running mission without being part of it: fills the run's log and follows when it is over."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

from ground_station.recorder import RunRecorder
from missions.ending import MissionWatch
from missions.processes import simulated_names
from vehicle_agent.link.session import FleetLink, LinkError
from vehicle_agent.mission.load import MissionError, MissionPlan


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
            self._link = FleetLink.open(plan.mission.name, f"observer-{secrets.token_hex(2)}", connect=endpoints)
        except LinkError as error:
            raise MissionError(f"{plan.source}: {error}") from None
        self._recorder = RunRecorder(run_dir)
        for topic in ("status", "event", "command", "result", "body"):
            self._link.subscribe(topic)

    def poll(self) -> None:
        """Take in what arrived since the last call."""
        messages = self._link.poll()
        self.watch.hear(messages, self._now())
        self._recorder.record(messages)

    def __enter__(self) -> Observer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._link.close()
        self._recorder.close()
