"""A station without a face: folds what arrives into the picture and asks for what is missing."""

from __future__ import annotations

from collections.abc import Sequence

from ground_station.fleet_state import digest_streams, fold
from ground_station.inputs import CommandSent, FleetInput, Heard, Tick
from ground_station.link import Link, StationLink
from ground_station.picture import FleetState
from ground_station.recorder import RunRecorder
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.wire.messages import Verb

DIGEST_PERIOD_S = 3.0
"""Wall time between two digests when nothing is known to be missing."""
REPAIR_PERIOD_S = 0.5
"""And when something is, or an agent has just come within reach."""


class Station:
    """Owns the link and the one `FleetState`; both faces (dashboard and plain log) call `step` and show `state`.

    Attributes
    ----------
    state
        The newest picture.
    """

    def __init__(
        self, plan: MissionPlan, name: str, boot_id: int, now_s: float, recorder: RunRecorder | None = None
    ) -> None:
        self.state = FleetState.initial(plan, name, boot_id, now_s)
        self._link: StationLink | None = None
        self._recorder = recorder
        self._digest_due_s = now_s
        self._reached: frozenset[str] = frozenset()

    @property
    def connected(self) -> bool:
        return self._link is not None

    def attach(self, link: Link) -> None:
        """Begin to listen and speak."""
        self._link = StationLink(link, self.state.station, self.state.station_boot_id)

    def step(self, now_s: float) -> FleetState:
        """Fold everything that arrived and say what is due; returns the new picture."""
        inputs: list[FleetInput] = self._link.poll(now_s) if self._link else []
        if self._recorder is not None:
            self._recorder.record(event.message for event in inputs if isinstance(event, Heard))
        self.state = fold(self.state, [*inputs, Tick(now_s)])
        self._ask_for_missing(now_s)
        return self.state

    def command(self, verb: Verb, targets: Sequence[str], now_s: float) -> int | None:
        """Send an order and return its number; None while there is no link."""
        if self._link is None:
            return None
        command = self._link.send_command(verb, targets, self.state.newest_ms)
        self.state = fold(self.state, [CommandSent(command, now_s)])
        return command.command_id

    def close(self) -> None:
        if self._link is not None:
            self._link.close()
        if self._recorder is not None:
            self._recorder.close()

    def _ask_for_missing(self, now_s: float) -> None:
        if self._link is None:
            return
        reached = frozenset(vehicle.name for vehicle in self.state.vehicles if vehicle.alive or vehicle.status)
        if reached > self._reached or self.state.records_missing:  # newcomers have not heard the last digest
            self._digest_due_s = min(self._digest_due_s, now_s + REPAIR_PERIOD_S)
        self._reached = reached
        if now_s >= self._digest_due_s:
            self._link.send_digest(digest_streams(self.state), self.state.newest_ms)
            self._digest_due_s = now_s + DIGEST_PERIOD_S
