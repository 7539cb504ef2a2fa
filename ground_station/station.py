"""A station without a face: folds what arrives into the picture, asks for what is missing, and re-plans."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ground_station.fleet_state import digest_streams, fold
from ground_station.inputs import CommandSent, FleetInput, Heard, Tick
from ground_station.link import Link, StationLink
from ground_station.payload import NOTHING, Payload
from ground_station.picture import FleetState
from ground_station.recorder import RunRecorder
from ground_station.replan import Proposal, ReplanPolicy
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.wire.messages import Verb

if TYPE_CHECKING:  # a dashboard that records nothing need not load MCAP
    from ground_station.mavlink_ears import MavlinkEars
    from ground_station.recording import RecordingWriter

DIGEST_PERIOD_S = 3.0
"""Wall time between two digests when nothing is known to be missing."""
REPAIR_PERIOD_S = 0.5
"""And when something is, or an agent has just come within reach."""


class Station:
    """Owns the link and the one `FleetState`; both faces (dashboard and plain log) call `step` and show `state`.

    Parameters
    ----------
    recorder
        Keeps what is heard as JSON lines.
    recording
        Keeps every input of the picture, so that it can be replayed.
    ears
        Hear the autopilots themselves.

    Attributes
    ----------
    state
        The newest picture.
    proposal
        What the policy wants to have sent and nobody has decided on yet.
    """

    def __init__(
        self,
        plan: MissionPlan,
        name: str,
        boot_id: int,
        now_s: float,
        recorder: RunRecorder | None = None,
        recording: RecordingWriter | None = None,
        ears: MavlinkEars | None = None,
    ) -> None:
        self.state = FleetState.initial(plan, name, boot_id, now_s)
        self.proposal: Proposal | None = None
        self._policy = ReplanPolicy()
        self._link: StationLink | None = None
        self._recorder = recorder
        self._recording = recording
        self._ears = ears
        self._digest_due_s = now_s
        self._reached: frozenset[str] = frozenset()
        if recording is not None:
            recording.begin(self.state)

    @property
    def connected(self) -> bool:
        return self._link is not None

    @property
    def is_replay(self) -> bool:
        return False

    def attach(self, link: Link) -> None:
        """Begin to listen and speak."""
        self._link = StationLink(link, self.state.station, self.state.station_boot_id)

    def step(self, now_s: float) -> FleetState:
        """Fold everything that arrived and say what is due; returns the new picture."""
        inputs: list[FleetInput] = self._link.poll(now_s) if self._link else []
        inputs += self._ears.poll(now_s) if self._ears else []
        if self._recorder is not None:
            self._recorder.record(event.message for event in inputs if isinstance(event, Heard))
        earlier = self.state
        self.take([*inputs, Tick(now_s)])
        self._ask_for_missing(now_s)
        self._replan(earlier, now_s)
        return self.state

    def take(self, inputs: Sequence[FleetInput]) -> None:
        """Fold inputs into the picture, and keep them."""
        self.state = fold(self.state, inputs)
        if self._recording is not None:
            self._recording.write(inputs)

    def command(
        self, verb: Verb, targets: Sequence[str], now_s: float, payload: Payload = NOTHING
    ) -> int | None:  # fmt: skip
        """Send an order and return its number; None while there is no link."""
        if self._link is None:
            return None
        command = self._link.send_command(verb, targets, self.state.newest_ms, payload)
        self.take([CommandSent(command, now_s)])
        return command.command_id

    def share_out(self) -> None:
        """Propose to share the rest of the area out."""
        self.proposal = self._policy.share(self.state) or self.proposal

    def accept(self, now_s: float) -> None:
        """Send what is proposed, once."""
        proposal, self.proposal = self.proposal, None
        for step in proposal.steps if proposal is not None else ():
            self.command(step.verb, step.targets, now_s, step.payload)

    def dismiss(self) -> None:
        """Leave it to the agents."""
        self.proposal = None

    def close(self) -> None:
        if self._link is not None:
            self._link.close()
        if self._ears is not None:
            self._ears.close()
        if self._recorder is not None:
            self._recorder.close()
        if self._recording is not None:
            self._recording.close()

    def _replan(self, earlier: FleetState, now_s: float) -> None:
        mode = self.state.plan.mission.replan.mode
        fresh = self._policy.propose(earlier, self.state) if mode != "off" else None
        if fresh is None:
            return
        self.proposal = fresh
        if mode == "auto":
            self.accept(now_s)
            self.proposal = None

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
