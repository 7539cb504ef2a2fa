"""Sending below a declared rate: a token bucket, and a thread that sends bulk when the bucket allows."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

MAX_QUEUED_BULK = 512
LONGEST_NAP_S = 0.05


class TokenBucket:
    """Bytes that may be sent by now. Telemetry may overdraw it; bulk waits until the debt is paid.

    Parameters
    ----------
    rate_bytes_s
        Bytes allowed per second of `clock`.
    burst_s
        How many seconds' worth may be saved up.
    """

    def __init__(self, rate_bytes_s: float, clock: Callable[[], float], burst_s: float = 1.0) -> None:
        if rate_bytes_s <= 0:
            raise ValueError("rate_bytes_s must be positive")
        self._rate = rate_bytes_s
        self._burst = rate_bytes_s * burst_s
        self._clock = clock
        self._lock = threading.Lock()
        self._balance = self._burst
        self._last_s = clock()

    def charge(self, size_bytes: int) -> None:
        """Account for bytes that are sent in any case."""
        with self._lock:
            self._refill()
            # A debt beyond one burst is forgiven: telemetry must not starve bulk for ever.
            self._balance = max(self._balance - size_bytes, -self._burst)

    def take(self, size_bytes: int) -> bool:
        """Account for `size_bytes` if the balance allows sending now; a large message leaves a debt behind."""
        with self._lock:
            self._refill()
            if self._balance < min(size_bytes, self._burst):
                return False
            self._balance -= size_bytes
            return True

    def _refill(self) -> None:
        now_s = self._clock()
        self._balance = min(self._burst, self._balance + max(0.0, now_s - self._last_s) * self._rate)
        self._last_s = now_s


class BulkSender:
    """A daemon thread that sends queued messages in order as a bucket allows, so that nobody else ever waits.

    Parameters
    ----------
    send
        Called on the thread with (key, payload).
    bucket
        None sends at once.

    Attributes
    ----------
    paced_out
        Messages pushed out of the full queue so far, oldest first.
    """

    def __init__(self, send: Callable[[str, bytes], None], bucket: TokenBucket | None, name: str) -> None:
        self.paced_out = 0
        self._send = send
        self._bucket = bucket
        self._queue: deque[tuple[str, bytes]] = deque()
        self._changed = threading.Condition()
        self._stopping = False
        self._thread = threading.Thread(target=self._run, name=f"bulk-{name}", daemon=True)
        self._thread.start()

    def put(self, key_text: str, payload: bytes) -> None:
        with self._changed:
            self._queue.append((key_text, payload))
            if len(self._queue) > MAX_QUEUED_BULK:
                self._queue.popleft()
                self.paced_out += 1
            self._changed.notify()

    def stop(self, timeout_s: float) -> None:
        """End the thread; what is still queued is not sent."""
        with self._changed:
            self._stopping = True
            self._changed.notify()
        self._thread.join(timeout_s)

    def _run(self) -> None:
        while (item := self._next()) is not None:
            self._send(*item)

    def _next(self) -> tuple[str, bytes] | None:
        """Wait for the oldest message that may be sent now; None when stopping."""
        with self._changed:
            while not self._stopping:
                if not self._queue:
                    self._changed.wait()
                elif self._bucket is None or self._bucket.take(sum(map(len, self._queue[0]))):
                    return self._queue.popleft()
                else:
                    self._changed.wait(LONGEST_NAP_S)
        return None
