"""A recording in the place of a live station: the same reducer makes the same pictures, at any pace, there and back."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

from ground_station.fleet_state import fold
from ground_station.inputs import Acknowledged, CommandSent, FleetInput, Muted, Tick
from ground_station.payload import NOTHING, Payload
from ground_station.picture import FleetState
from ground_station.recording import Recording
from ground_station.replan import Proposal
from vehicle_agent.wire.messages import Verb

KEYFRAME_S = 15.0
MAX_KEYFRAMES = 240
INPUTS_PER_STEP = 3_000
"""Bound on the work of one step, so that keys are answered while a long way is sought."""
SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)
_ENDS_BATCH = (Tick, CommandSent, Acknowledged, Muted)


@dataclass(frozen=True, slots=True)
class Keyframe:
    """A picture and where the recording goes on after it."""

    state: FleetState
    chunk: int
    place: int


class Player:
    """Plays a recording; stands where a `Station` stands.

    Attributes
    ----------
    state
        The picture at the present place.
    playing, speed
        Whether and how fast recorded time passes, in recorded seconds per second.
    target_s
        Recorded second that it is playing or seeking towards.
    """

    proposal: Proposal | None = None
    connected = True
    is_replay = True

    def __init__(self, recording: Recording, speed: float = 1.0) -> None:
        self.recording = recording
        self.state = recording.initial
        self.playing, self.speed = True, speed
        self.target_s = 0.0
        self._frames = [Keyframe(recording.initial, 0, 0)]
        self._chunk = self._place = 0
        self._inputs: list[FleetInput] = recording.inputs(0)
        self._stepped_s: float | None = None

    @property
    def position_s(self) -> float:
        """Recorded seconds from the beginning to the present picture."""
        return self.state.now_s - self.recording.initial.began_s

    @property
    def at_end(self) -> bool:
        return self._chunk >= self.recording.chunks

    def step(self, now_s: float) -> FleetState:
        """Let time pass until `now_s` on the wall's monotonic clock, and return the picture."""
        passed_s = 0.0 if self._stepped_s is None else max(0.0, now_s - self._stepped_s)
        self._stepped_s = now_s
        if self.playing and not self.at_end and self.position_s >= self.target_s - 2.0 * max(1.0, self.speed):
            self.target_s += passed_s * self.speed
        self._fold_until(self.target_s)
        return self.state

    def toggle(self) -> None:
        """Pause, or go on."""
        self.playing = not self.playing
        self.target_s = max(self.target_s, self.position_s)

    def faster(self, steps: int) -> None:
        at = min(range(len(SPEEDS)), key=lambda one: abs(SPEEDS[one] - self.speed))
        self.speed = SPEEDS[min(max(0, at + steps), len(SPEEDS) - 1)]

    def seek(self, second: float) -> None:
        """Go to a recorded second; a later `step` gets there when the way is long."""
        self.target_s = min(max(0.0, second), self.recording.length_s + 1.0)
        if self.target_s < self.position_s:
            began_s = self.recording.initial.began_s
            at = bisect_right(self._frames, self.target_s, key=lambda one: one.state.now_s - began_s)
            frame = self._frames[max(0, at - 1)]
            self.state, self._chunk, self._place = frame.state, frame.chunk, frame.place
            self._inputs = self.recording.inputs(frame.chunk) if frame.chunk < self.recording.chunks else []
        self._fold_until(self.target_s)

    def step_forward(self) -> None:
        """Pause, and show the next picture in which something was heard or done."""
        self.playing = False
        while batch := self._next_batch():
            self.state = fold(self.state, batch)
            if any(not isinstance(event, Tick) for event in batch):
                break
        self.target_s = self.position_s

    def play_to_end(self) -> FleetState:
        """The last picture of the recording."""
        while batch := self._next_batch():
            self.state = fold(self.state, batch)
        self.target_s = self.position_s
        return self.state

    def command(
        self, verb: Verb, targets: Sequence[str], now_s: float, payload: Payload = NOTHING
    ) -> int | None:  # fmt: skip
        """Nothing can be sent into the past."""
        return None

    def take(self, inputs: Sequence[FleetInput]) -> None:
        """Nothing can be changed in the past."""

    def share_out(self) -> None:
        """Nothing can be changed in the past."""

    def accept(self, now_s: float) -> None:
        """Nothing can be sent into the past."""

    def dismiss(self) -> None:
        """There is nothing to dismiss."""

    def close(self) -> None:
        self.recording.close()

    def _fold_until(self, second: float) -> None:
        began_s, budget = self.recording.initial.began_s, INPUTS_PER_STEP
        while budget > 0 and not self.at_end:
            mark = (self._chunk, self._place, self._inputs)
            batch = self._next_batch()
            last = batch[-1] if batch else None
            if isinstance(last, Tick) and last.now_s - began_s > second:
                self._chunk, self._place, self._inputs = mark
                return
            if batch:
                self.state = fold(self.state, batch)
                self._keep_frame()
            budget -= len(batch)

    def _next_batch(self) -> list[FleetInput]:
        """Inputs up to and with the next that ended a batch when it was recorded; empty at the end."""
        batch: list[FleetInput] = []
        while not self.at_end:
            while self._place < len(self._inputs):
                event = self._inputs[self._place]
                self._place += 1
                batch.append(event)
                if isinstance(event, _ENDS_BATCH):
                    self._turn_page()
                    return batch
            self._turn_page()
        return batch

    def _turn_page(self) -> None:
        if self._place >= len(self._inputs) and not self.at_end:
            self._chunk, self._place = self._chunk + 1, 0
            self._inputs = self.recording.inputs(self._chunk) if not self.at_end else []

    def _keep_frame(self) -> None:
        if self.state.now_s - self._frames[-1].state.now_s < KEYFRAME_S * max(1, len(self._frames) // 60):
            return
        self._frames.append(Keyframe(self.state, self._chunk, self._place))
        if len(self._frames) > MAX_KEYFRAMES:
            del self._frames[1::2]
