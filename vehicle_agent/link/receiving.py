"""The queue between Zenoh's threads and the one thread that polls."""

from __future__ import annotations

import heapq
import threading
from collections import deque
from dataclasses import dataclass

MAX_QUEUED_MESSAGES = 4_096
MAX_QUEUED_BYTES = 32_000_000


@dataclass(frozen=True, slots=True)
class Arrival:
    """One sample as it came in: its place in the order of arrival, its key and its bytes."""

    order: int
    key_text: str
    payload: bytes


class ReceiveQueue:
    """A bounded queue that gives up its oldest telemetry before it gives up anything that is not said again.

    Attributes
    ----------
    overflowed
        Arrivals pushed out so far.
    """

    def __init__(self, max_messages: int = MAX_QUEUED_MESSAGES, max_bytes: int = MAX_QUEUED_BYTES) -> None:
        self.overflowed = 0
        self._max_messages = max_messages
        self._max_bytes = max_bytes
        self._lock = threading.Lock()
        self._order = 0
        self._bytes = 0
        self._expendable: deque[Arrival] = deque()
        self._precious: deque[Arrival] = deque()

    def put(self, key_text: str, payload: bytes, expendable: bool) -> None:
        """Append an arrival; `expendable` ones (said again soon) make room first."""
        with self._lock:
            self._order += 1
            (self._expendable if expendable else self._precious).append(Arrival(self._order, key_text, payload))
            self._bytes += len(payload)
            while len(self._expendable) + len(self._precious) > self._max_messages or (
                self._bytes > self._max_bytes and len(self._expendable) + len(self._precious) > 1
            ):
                oldest = (self._expendable or self._precious).popleft()
                self._bytes -= len(oldest.payload)
                self.overflowed += 1

    def take_all(self) -> list[Arrival]:
        """Empty the queue, in order of arrival."""
        with self._lock:
            expendable, precious = self._expendable, self._precious
            self._expendable, self._precious = deque(), deque()
            self._bytes = 0
        return list(heapq.merge(expendable, precious, key=lambda arrival: arrival.order))
