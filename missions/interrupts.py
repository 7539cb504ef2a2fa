"""Requests to stop that come as signals: Ctrl-C, SIGTERM, and the loss of the terminal."""

from __future__ import annotations

import signal
from types import FrameType, TracebackType
from typing import Any

_WATCHED = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Interrupts:
    """While entered, signals are only noted, so that the loop that looks at them stops things in order.

    Attributes
    ----------
    first
        The signal that came first; None while none has come.
    count
        How many came; a second one means hurry.
    """

    def __init__(self) -> None:
        self.first: signal.Signals | None = None
        self.count = 0
        self._previous: dict[signal.Signals, Any] = {}

    def request(self, what: signal.Signals) -> None:
        """Note a request to stop, from a signal or from elsewhere."""
        self.first = self.first or what
        self.count += 1

    def in_hurry(self) -> bool:
        return self.count > 1

    @property
    def cause(self) -> str:
        """The first request in words."""
        return "Ctrl-C" if self.first is signal.SIGINT else self.first.name if self.first else "nobody"

    @property
    def exit_code(self) -> int | None:
        """128 + signal as shells have it; None when nothing came."""
        return None if self.first is None else 128 + int(self.first)

    def __enter__(self) -> Interrupts:
        for what in _WATCHED:
            self._previous[what] = signal.signal(what, self._note)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for what, handler in self._previous.items():
            signal.signal(what, handler)

    def _note(self, number: int, _frame: FrameType | None) -> None:
        self.request(signal.Signals(number))
