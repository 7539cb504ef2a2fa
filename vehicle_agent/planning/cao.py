"""Cognitive-based Adaptive Optimization, decentralised (Renzaglia 2020, section 4).

A vehicle fits a cubic polynomial to the objective values that it measured at its last positions and moves to the
random admissible perturbation of its position for which the polynomial promises most.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dgelsy

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.polynomials import CUBIC_MONOMIALS, cubic_monomials

BASIS_FUNCTIONS = CUBIC_MONOMIALS
"""L in the paper: all x^u y^v z^w with u + v + w <= 3 (eq. 8)."""
_CONDITION = 1e-10
"""Directions of the window whose share is smaller are taken as not measured."""
_LIKELY = 16
"""Of so many of the most promising candidates one is mostly admissible."""


@dataclass(frozen=True, slots=True)
class CaoParams:
    """How the optimisation runs.

    Attributes
    ----------
    step_m
        Length of a perturbation (alpha in eq. 10). At most what the vehicle flies between two decisions.
    candidates
        Perturbations tried per step (M).
    extra_window
        Measurements kept beyond the number of basis functions (T_h in eq. 9).
    """

    step_m: float
    candidates: int = 100
    extra_window: int = 10

    def __post_init__(self) -> None:
        if not self.step_m > 0:
            raise ValueError("step_m must be positive")
        if self.candidates < 1:
            raise ValueError("candidates must be at least 1")
        if self.extra_window < 0:
            raise ValueError("extra_window must not be negative")


class Cao:
    """Ask/tell optimiser of one vehicle's position.

    >>> rng = np.random.default_rng(0)
    >>> cao = Cao(CaoParams(step_m=1.0), rng)
    >>> position = (0.0, 0.0, 0.0)
    >>> for _ in range(60):
    ...     cao.tell(position, -(position[0] - 5.0) ** 2)
    ...     position = cao.ask(position, lambda ends: np.ones(len(ends), dtype=bool))
    >>> abs(position[0] - 5.0) < 3.0
    True
    """

    def __init__(self, params: CaoParams, rng: np.random.Generator) -> None:
        self.params = params
        self._rng = rng
        self._window = BASIS_FUNCTIONS + params.extra_window
        self._positions: FloatArray = np.empty((0, 3))
        self._objectives: FloatArray = np.empty(0)

    def tell(self, position_enu_m: Point, objective: float) -> None:
        """Remember the objective J_t measured at a position."""
        if len(self._objectives) < self._window:
            self._positions = np.vstack((self._positions, position_enu_m))
            self._objectives = np.append(self._objectives, objective)
            return
        self._positions[:-1], self._objectives[:-1] = self._positions[1:], self._objectives[1:]
        self._positions[-1], self._objectives[-1] = position_enu_m, objective

    def ask(
        self,
        position_enu_m: Point,
        admissible: Callable[[FloatArray], BoolArray],
        step_m: float | None = None,
    ) -> Point | None:
        """The admissible perturbation of the position that promises most; None when none is admissible.

        Parameters
        ----------
        position_enu_m
            Where the vehicle is (P_t).
        admissible
            The constraints C: (M, 3) float64 ENU metres -> (M,) bool.
        step_m
            This step's alpha_t where it shrinks with time (eq. 11); the params' step when left out.
        """
        step = self.params.step_m if step_m is None else step_m
        here = np.array(position_enu_m)
        directions = self._rng.standard_normal((self.params.candidates, 3))
        directions /= np.sqrt(np.einsum("ij,ij->i", directions, directions))[:, None]
        candidates = here + step * directions  # eq. 10
        best_first = np.argsort(-self._promise(candidates, here, step), kind="stable")
        for some in (best_first[:_LIKELY], best_first[_LIKELY:]):  # few are ever looked at, which is quicker than all
            allowed = admissible(candidates[some])
            if allowed.any():
                best = candidates[some[int(np.argmax(allowed))]]  # eq. 12
                return (float(best[0]), float(best[1]), float(best[2]))
        return None

    def _promise(self, candidates: FloatArray, here: FloatArray, step: float) -> FloatArray:
        """Estimated objective at candidates, (M, 3) -> (M,)."""
        if len(self._objectives) == 0:
            return self._rng.random(len(candidates))
        # The paper leaves origin and scale open; away from the vehicle eq. 9 is too ill-conditioned for doubles.
        offsets = self._positions - here
        scale = max(step, float(np.abs(offsets).max()))
        weights = least_squares(cubic_monomials(offsets / scale), self._objectives)  # eq. 9
        promise: FloatArray = cubic_monomials((candidates - here) / scale) @ weights  # eq. 7
        return promise


def least_squares(matrix: FloatArray, values: FloatArray) -> FloatArray:
    """The shortest of the least-squares solutions, as by the Moore-Penrose inverse: (N, L) and (N,) -> (L,).

    By complete orthogonal factorisation: four times as quick as by singular values, which is what steps spend most on.
    """
    rows, unknowns = matrix.shape
    right = np.zeros((max(rows, unknowns), 1))
    right[:rows, 0] = values
    free_columns = np.zeros((unknowns, 1), dtype=np.int32)
    work = 2 * min(rows, unknowns) + 64 * (unknowns + 1)
    _, solution, *_ = dgelsy(matrix, right, free_columns, _CONDITION, work, overwrite_b=True)
    shortest: FloatArray = solution[:unknowns, 0]
    return shortest
