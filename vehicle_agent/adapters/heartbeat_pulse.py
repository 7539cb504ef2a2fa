"""The controller's heartbeat, beaten in vehicle time by a thread of its own while its owner shows signs of life.

A planning step of 0.3 s is 3 s of vehicle time at ten times real time; beats from the owner's own thread would come
late and trip the failsafe that they are to keep quiet. Beats from a thread that asked nobody would keep it quiet for an
agent that hangs. So the thread beats, and the owner has to say again and again that it lives.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable

BEAT_PERIOD_MS = 500
"""Of vehicle time; the autopilot wants one at least every five seconds."""
OWNER_SILENCE_S = 2.0
"""Wall time without a sign of life after which the owner counts as hung."""


class HeartbeatPulse:
    """Calls `send` about twice per vehicle second, as heard from the autopilot's positions.

    Parameters
    ----------
    send
        Called on the pulse's thread.
    clock
        Wall time in seconds.
    """

    def __init__(self, send: Callable[[], None], clock: Callable[[], float]) -> None:
        self._send = send
        self._clock = clock
        self._position_json = ""
        self._news = threading.Event()
        self._stopping = False
        self._last_beat_ms: int | None = None
        self._owner_seen_s = clock()
        self._thread = threading.Thread(target=self._run, name="heartbeat", daemon=True)
        self._thread.start()

    def owner_is_alive(self) -> None:
        self._owner_seen_s = self._clock()

    def on_position(self, fields_json: str) -> None:
        """Take the newest GLOBAL_POSITION_INT, as JSON; may be called on any thread."""
        self._position_json = fields_json
        self._news.set()

    def stop(self) -> None:
        self._stopping = True
        self._news.set()
        self._thread.join(1.0)

    def _run(self) -> None:
        while self._news.wait() and not self._stopping:
            self._news.clear()
            if self._is_due(self._position_json) and self._clock() - self._owner_seen_s < OWNER_SILENCE_S:
                self._send()

    def _is_due(self, fields_json: str) -> bool:
        try:
            boot_ms = int(json.loads(fields_json)["time_boot_ms"])
        except (ValueError, KeyError, TypeError):
            return False
        if self._last_beat_ms is not None and 0 <= boot_ms - self._last_beat_ms < BEAT_PERIOD_MS:
            return False
        self._last_beat_ms = boot_ms
        return True
