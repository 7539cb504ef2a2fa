"""Cognitive adaptive optimization of a whole team's map making (Kapoutsis 2015, algorithm 2), on one server."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.polynomials import CUBIC_MONOMIALS, cubic_monomials
from vehicle_agent.planning.cao import least_squares
from vehicle_agent.planning.mapping.osarses import Admissible, Allowed, JointCandidates


@dataclass(frozen=True, slots=True)
class MappingCaoParams:
    """How the optimisation runs.

    Attributes
    ----------
    step_m
        First length of a perturbation (alpha_0).
    half_life
        Steps until the perturbation has shrunk to its `2 ** -decay`; much longer than a mission, for a team that slows
        down explores less.
    decay
        Exponent in (1/2, 1], with which the sequence satisfies eq. 23.
    candidates
        Configurations per step (N); at least twice the number of coordinates, as footnote 5 asks.
    extra_window
        Measurements kept beyond the number of basis functions (T_h).
    degree
        Of the polynomials in each vehicle's position that the objective is fitted by, 1 to 3.
    """

    step_m: float
    half_life: float = 10_000.0
    decay: float = 0.51
    candidates: int = 150
    extra_window: int = 10
    degree: int = 1

    def __post_init__(self) -> None:
        if not 0.5 < self.decay <= 1.0:
            raise ValueError("decay must be above 1/2 and at most 1, or the steps break eq. 23")
        if self.degree not in (1, 2, 3):
            raise ValueError("degree must be 1, 2 or 3")


class MappingCao:
    """Fits the objective by polynomials in each vehicle's position, and climbs the fit.

    Attributes
    ----------
    window
        How many measurements are remembered (L + T_h).
    """

    def __init__(self, params: MappingCaoParams, vehicles: int, rng: np.random.Generator) -> None:
        self._params, self._rng = params, rng
        self._columns = _monomials_up_to(params.degree)
        self.window = 1 + vehicles * len(self._columns) + params.extra_window
        self._measured: deque[tuple[FloatArray, float]] = deque(maxlen=self.window)  # eq. 21
        self._steps = 0

    def tell(self, positions: FloatArray, objective: float) -> None:
        """Remember what the objective was at a configuration (vehicles, 3)."""
        self._measured.append((positions.copy(), objective))

    def revalue(self, objectives: Sequence[float]) -> None:
        """Give what is remembered new values, the oldest first: those of an objective that has changed since."""
        places = [positions for positions, _ in self._measured]
        self._measured.clear()
        self._measured.extend(zip(places, objectives, strict=True))

    def ask(self, positions: FloatArray, allowed: Allowed, admissible: Admissible) -> FloatArray:
        """The candidate whose estimated objective is best, (vehicles, 3); the present one when none is admissible."""
        params = self._params
        step_m = params.step_m / (1.0 + self._steps / params.half_life) ** params.decay  # eq. 23
        self._steps += 1
        candidates = JointCandidates(allowed, admissible, self._rng).draw(positions, step_m, params.candidates)
        if len(candidates) == 0:
            return positions
        return np.asarray(candidates[int(np.argmax(self._promise(candidates, positions, step_m)))])

    def _promise(self, candidates: FloatArray, here: FloatArray, step_m: float) -> FloatArray:
        if not self._measured:
            return self._rng.random(len(candidates))
        places = np.array([team for team, _ in self._measured])
        objectives = np.array([objective for _, objective in self._measured])
        scale = max(step_m, float(np.abs(places - here).max()))
        weights = least_squares(self._regressors((places - here) / scale), objectives)  # eq. 21
        promise: FloatArray = self._regressors((candidates - here) / scale) @ weights  # eq. 20
        return promise

    def _regressors(self, teams: FloatArray) -> FloatArray:
        """phi: a constant and the monomials of each vehicle's position, (M, vehicles, 3) -> (M, L)."""
        count, vehicles, _ = teams.shape
        each = cubic_monomials(np.ascontiguousarray(teams.reshape(-1, 3))).reshape(count, vehicles, CUBIC_MONOMIALS)
        return np.column_stack((np.ones(count), each[:, :, self._columns].reshape(count, -1)))


def _monomials_up_to(degree: int) -> list[int]:
    """Columns of `cubic_monomials` of at most this degree, the constant left out."""
    degrees = [u + v + w for u in range(4) for v in range(4 - u) for w in range(4 - u - v)]
    return [column for column, each in enumerate(degrees) if 0 < each <= degree]
