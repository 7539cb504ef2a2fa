"""How many simulated steps are due at an instant of real time: pure arithmetic, the clock is an argument."""

from __future__ import annotations

from dataclasses import dataclass, field

LATE_S = 0.05
"""A step that runs later than this is counted as late."""
FORGIVEN_S = 1.0
"""Arrears beyond this are dropped: time stands still rather than leaps after a pause of the machine."""
CATCH_UP_FACTOR = 2
"""Fastest catching up, as a multiple of the set pace, so that no client's heartbeats seem to fall silent."""


@dataclass(slots=True)
class Pacer:
    """Holds simulated steps to real time.

    Attributes
    ----------
    step_wall_s
        Real seconds per simulated step.
    started_s
        Real time at which the first step is due.
    late_ticks
        Steps that ran later than `LATE_S`.
    forgiven_s
        Real seconds by which simulated time was set back after pauses.
    """

    step_wall_s: float
    started_s: float
    late_ticks: int = 0
    forgiven_s: float = 0.0
    _due_s: float = field(init=False)
    _asked_s: float = field(init=False)

    def __post_init__(self) -> None:
        if not self.step_wall_s > 0:
            raise ValueError("step_wall_s must be positive")
        self._due_s = self._asked_s = self.started_s

    def steps_due(self, now_s: float) -> int:
        """Number of steps to run now, so that time is neither late nor leaps; the caller runs just that many."""
        if now_s - self._due_s > FORGIVEN_S:
            self.forgiven_s += now_s - self._due_s - FORGIVEN_S
            self._due_s = now_s - FORGIVEN_S
        elapsed_s, self._asked_s = now_s - self._asked_s, now_s
        allowed = max(1, round(CATCH_UP_FACTOR * min(elapsed_s, FORGIVEN_S) / self.step_wall_s))
        steps = 0
        while self._due_s <= now_s and steps < allowed:
            self.late_ticks += now_s - self._due_s > LATE_S + self.step_wall_s
            self._due_s += self.step_wall_s
            steps += 1
        return steps

    def until_next_s(self, now_s: float) -> float:
        """Real seconds until the next step is due, 0 when it is already."""
        return max(0.0, self._due_s - now_s)
