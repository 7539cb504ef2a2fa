"""Optimal-one-step-ahead random semi-exhaustive search (Kapoutsis 2015, algorithm 1): an oracle that cannot fly.

It really moves the whole team to each of its candidates, looks what that brings, takes it back, and keeps the best.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.polygon import BoolArray

_TRIES = 30
"""Draws per candidate before one is called impossible."""

Admissible = Callable[[FloatArray], BoolArray]
"""The constraints C on team configurations, (M, vehicles, 3) -> (M,) bool (eq. 18)."""
Allowed = Callable[[int, FloatArray], FloatArray]
"""Which of one vehicle's drawn ends (M, 3) it may take by itself, (M', 3)."""


class JointCandidates:
    """Draws admissible team configurations around the present one (eq. 22)."""

    def __init__(self, allowed: Allowed, admissible: Admissible, rng: np.random.Generator) -> None:
        self._allowed, self._admissible, self._rng = allowed, admissible, rng

    def draw(self, positions: FloatArray, step_m: float, count: int) -> FloatArray:
        """At most so many configurations (count, vehicles, 3): every vehicle goes `step_m` any way, or stays."""
        pools = [self._ends(index, place, step_m, count) for index, place in enumerate(positions)]
        found: list[FloatArray] = []
        missing = count
        for _ in range(_TRIES):
            teams = np.stack([pool[self._rng.integers(len(pool), size=2 * missing)] for pool in pools], axis=1)
            found.append(teams[self._admissible(teams)][:missing])
            missing -= len(found[-1])
            if missing == 0:
                break
        return np.concatenate(found)

    def _ends(self, index: int, place: FloatArray, step_m: float, count: int) -> FloatArray:
        ways = self._rng.standard_normal((2 * count + _TRIES, 3))
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        ends = self._allowed(index, place + step_m * ways)
        return ends if len(ends) else place[None]


class Osarses:
    """One choice per step among really tried configurations.

    Parameters
    ----------
    trials
        How many configurations are tried; with 0 the first admissible one is taken untried.
    """

    def __init__(self, trials: int, step_m: float, rng: np.random.Generator) -> None:
        if trials < 0:
            raise ValueError("trials must not be negative")
        self._trials, self._step_m, self._rng = trials, step_m, rng

    def ask(
        self, positions: FloatArray, allowed: Allowed, admissible: Admissible, try_out: Callable[[FloatArray], float]
    ) -> FloatArray:
        """The best of the candidates, (vehicles, 3); the present configuration when none is admissible."""
        candidates = JointCandidates(allowed, admissible, self._rng).draw(positions, self._step_m, max(self._trials, 1))
        if len(candidates) == 0:
            return positions
        if self._trials == 0:
            return np.asarray(candidates[0])
        return np.asarray(candidates[int(np.argmax([try_out(team) for team in candidates]))])
