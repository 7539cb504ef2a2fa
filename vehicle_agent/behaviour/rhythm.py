"""When something that is said regularly is due again."""

from __future__ import annotations

import math


class Rhythm:
    """One period of vehicle time.

    Parameters
    ----------
    period_s
        Vehicle time between two turns.
    """

    def __init__(self, period_s: float) -> None:
        self._period_s = period_s
        self._due_s = -math.inf

    def is_due(self, now_s: float) -> bool:
        """True once per period; the next period counts from now."""
        if now_s < self._due_s:
            return False
        self._due_s = now_s + self._period_s
        return True

    def at_once(self) -> None:
        """Make it due now."""
        self._due_s = -math.inf

    def wait_until(self, time_s: float) -> None:
        """Make it due no earlier."""
        self._due_s = max(self._due_s, time_s)
