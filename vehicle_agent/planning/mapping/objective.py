"""The transformed objective J + J1 + J2 + J3 of a whole team (Kapoutsis 2015, section 4.3).

Equations 11, 13 and 15 as printed switch a term off in a deadlock; the text beside them switches it on, and that is
what leads out of one, so it is what is done here.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.grid import IndexArray

TERMS = ("J", "J+J1", "J+J1+J2", "J+J1+J3", "all")
"""The steps of the ablation: which terms count. One leaves out J2 alone, for without J3 its worth does not show: half
of a long run then goes by with nothing in sight, where J2 is constant."""


@dataclass(frozen=True, slots=True)
class ObjectiveParams:
    """Weights and thresholds of the terms.

    Attributes
    ----------
    terms
        One of `TERMS`.
    visible_weight, nearness_weight, far_weight
        K_1, K_2 and K_3; the latter two per squared visibility threshold.
    sealed_tolerance
        epsilon_1: a vehicle that made no more landmarks accurate than this at its last step is in a deadlock.
    visible_tolerance, nearness_tolerance
        epsilon_2 and epsilon_3.
    """

    terms: str = "all"
    visible_weight: float = 0.5
    nearness_weight: float = 0.1
    far_weight: float = 3e-4
    sealed_tolerance: float = 0.0
    visible_tolerance: float = 3.0
    nearness_tolerance: float = 3.0

    @classmethod
    def suited(cls, vehicles: int, landmarks: int, terms: str = "all", nearness: float = 0.7) -> ObjectiveParams:
        """The weights that served a team best on the bench's surfaces, with so many vehicles and landmarks.

        K_2 is K_1 times `nearness` over the team's size, for each vehicle's switch counts the sum over the whole team's
        landmarks. K_1 and K_3 keep sums over landmarks at the size of the first term, however many there are.
        """
        share, tolerance = 550.0 / landmarks, 3.0 * landmarks / 1_100
        return cls(terms, share, nearness * share / vehicles, 0.33 / landmarks, 0.0, tolerance, tolerance)

    def __post_init__(self) -> None:
        if self.terms not in TERMS:
            raise ValueError(f"terms must be one of {', '.join(TERMS)}")

    def counts(self, term: str) -> bool:
        """Whether a term, as "J2", is part of the objective."""
        return self.terms == "all" or term in self.terms.split("+")


@dataclass(frozen=True, slots=True)
class Outlook:
    """What a team configuration brings, really or supposedly.

    Attributes
    ----------
    sealed
        Landmarks that become accurate, |A^L(t)| - |A^L(t-1)|.
    visible : (vehicles,) sizes of B^{L,j}.
    near_sum
        Sum of the least squared distance over the landmarks B^L visible before the move, in squared visibility
        thresholds.
    far_sum
        The same over the landmarks of J3.
    """

    sealed: float
    visible: IndexArray
    near_sum: float
    far_sum: float


@dataclass(slots=True)
class Objective:
    """The objective with the switches that history sets (eq. 9-15), for steps of equal length."""

    params: ObjectiveParams
    vehicles: int
    _sealed: list[IndexArray] = field(default_factory=list)
    _visible_terms: list[FloatArray] = field(default_factory=list)
    _nearness_terms: list[FloatArray] = field(default_factory=list)

    def record(self, sealed_by: IndexArray, outlook: Outlook) -> float:
        """Take note of what the last step brought, (vehicles,) landmarks that each made accurate; its objective."""
        switches = self.switches()
        value = self.value(outlook)
        self._sealed = [*self._sealed[-1:], sealed_by]
        self._visible_terms = [*self._visible_terms[-1:], switches[0] * outlook.visible]
        self._nearness_terms = [*self._nearness_terms[-1:], switches[1] * outlook.near_sum]
        return value

    def switches(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """s_1, s_2 and s_3 of the coming step, (vehicles,) each."""
        params = self.params
        none = np.zeros(self.vehicles)
        if not self._sealed:
            return (none, none, none)
        stuck = self._sealed[-1] <= params.sealed_tolerance
        first = np.where(stuck, params.visible_weight, 0.0) if params.counts("J1") else none  # eq. 11
        second = np.where(stuck, params.nearness_weight, 0.0) if params.counts("J2") else none  # eq. 13
        if not params.counts("J3") or len(self._visible_terms) < 2:
            return (first, second, none)
        (visible_before, visible), (near_before, near) = self._visible_terms, self._nearness_terms
        hopeless = (
            stuck
            & (np.abs(visible - visible_before) <= params.visible_tolerance)
            & (np.abs(near - near_before) <= params.nearness_tolerance)
        )
        return (first, second, np.where(hopeless, params.far_weight, 0.0))  # eq. 15

    def value(self, outlook: Outlook) -> float:
        """J + J1 + J2 + J3 (eq. 9) that a configuration brings at the coming step."""
        first, second, third = self.switches()
        return float(
            outlook.sealed  # eq. 8
            + (first * outlook.visible).sum()  # eq. 10
            - second.sum() * outlook.near_sum  # eq. 12
            - third.sum() * outlook.far_sum  # eq. 14
        )
