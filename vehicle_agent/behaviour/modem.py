"""An acoustic modem's share of time: one packet of so many bytes per period, the most urgent words first."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import msgspec

from vehicle_agent.wire.codec import Codec
from vehicle_agent.wire.messages import (
    AnyMessage,
    CommandResult,
    Event,
    LandmarkDigest,
    Landmarks,
    Orders,
    Severity,
    Status,
)

LONGEST_EVENT, LONGEST_WHY = 72, 24
"""Characters of a text that go through the water."""
MAX_WAITING = 40
_LATEST = (Status, Landmarks, LandmarkDigest, Orders)
"""Of these only the newest is worth sending."""
_SPOKEN = (*_LATEST, Event, CommandResult)


@dataclass(slots=True)
class Modem:
    """What waits for its turn.

    Attributes
    ----------
    packet_bytes, period_s
        Most that is said, and in which time.
    dropped
        Messages that never went out, because newer ones pushed them away or because they fit into no packet.
    """

    packet_bytes: int
    period_s: float
    dropped: int = 0
    _waiting: list[AnyMessage] = field(default_factory=list)
    _open_at_s: float = -math.inf
    _codec: Codec = field(default_factory=Codec)

    def is_open(self, now_s: float) -> bool:
        """Whether the next packet may go now."""
        return now_s >= self._open_at_s

    def room_bytes(self) -> int:
        """What is left of the next packet beside what waits."""
        return self.packet_bytes - sum(self.size_of(message) for message in self._waiting if _urgency(message) <= 1)

    def size_of(self, message: AnyMessage) -> int:
        return len(self._codec.encode(message))

    def put(self, messages: Iterable[AnyMessage]) -> None:
        """Let messages wait, shortened; of kinds that this radio does not carry nothing is kept."""
        for message in messages:
            if not isinstance(message, _SPOKEN):
                continue
            short = _shortened(message)
            if isinstance(short, _LATEST):
                self._waiting = [other for other in self._waiting if type(other) is not type(short)]
            if self.size_of(short) > self.packet_bytes:
                self.dropped += 1
                continue
            self._waiting.append(short)
        if len(self._waiting) > MAX_WAITING:
            self._waiting.sort(key=_urgency)
            self.dropped += len(self._waiting) - MAX_WAITING
            del self._waiting[MAX_WAITING:]

    def take(self, now_s: float) -> list[AnyMessage]:
        """The next packet's messages when it is time; the next period counts from now."""
        if not self.is_open(now_s) or not self._waiting:
            return []
        left, packet, rest = self.packet_bytes, [], []
        for message in sorted(self._waiting, key=_urgency):
            size = self.size_of(message)
            if size <= left:
                left -= size
                packet.append(message)
            else:
                rest.append(message)
        self._waiting = rest
        self._open_at_s = now_s + self.period_s
        return packet


def _urgency(message: AnyMessage) -> int:
    """Order in a packet, lower first."""
    match message:
        case CommandResult():
            return 0
        case Event(severity=severity) if severity <= Severity.WARNING:
            return 1
        case Status() | Landmarks():
            return 2
        case Orders():
            return 3
        case Event():
            return 4
        case _:
            return 5


def _shortened(message: AnyMessage) -> AnyMessage:
    match message:
        case Event(text=text):
            return msgspec.structs.replace(message, text=text[:LONGEST_EVENT])
        case CommandResult(text=text):
            return msgspec.structs.replace(message, text=text[:LONGEST_EVENT])
        case Status(why=why):
            return msgspec.structs.replace(message, why=why[:LONGEST_WHY], path_cm=())
        case _:
            return message
