"""How rough ground is from place to place: a field whose logarithm is Gaussian, fitted to soundings.

What a sounding adds to what those before it foretold, its innovation, is independent of the others' under the prior of
`Relief`, and its size is scaled by how rough the ground is around it. The most likely field given all innovations is
found by Newton's method; how much it varies at all is what makes the innovations most likely, by Laplace's
approximation (Rasmussen and Williams 2006, 3.4 and 5.5.1). So the field keeps to even ground as far as soundings do not
tell otherwise: where there are few, and everywhere when they differ no more than chance lets them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular
from scipy.spatial.distance import cdist

from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.relief import swell_and_roughness

ALIKE_WITHIN_M = 20.0
"""Width of the Gaussian that tells how alike the roughness of two places is."""
KNOT_SHARE = 0.75
"""Distance between the knots that carry the field, over that width."""
MOST_KNOTS = 14
"""Along one axis; over a wider area the field varies over longer distances."""
VARIES = (0.15, 0.35, 0.6, 1.0)
"""Standard deviations of the logarithm that are tried."""
LEVEL = 0.5
"""Standard deviation of the logarithm that is common to all places."""
WIDEST = 4.0
"""The logarithm goes no further from the common one."""
ROUNDS, NEWTON_STEPS = 3, 8
SETTLED = 0.01
"""Newton's method ends when no weight, of which each has unit variance beforehand, changes more."""
LEAST_GROUND = 0.02
"""Share of an innovation's variance that is the ground's and not the sounder's, at least."""
MODEL_SD_M = 0.01
"""Keeps the covariance of soundings that lie close together soluble."""


@dataclass(frozen=True, slots=True)
class _Fit:
    """One most likely field.

    Attributes
    ----------
    weights : of the features.
    logs : (N,), the field at the soundings.
    evidence
        Logarithm of the probability of the innovations, up to a constant.
    varies
        Standard deviation of the logarithm that was assumed.
    """

    weights: FloatArray
    logs: FloatArray
    evidence: float
    varies: float


class RoughnessField:
    """The roughness that soundings tell.

    Parameters
    ----------
    places_en_m : (N, 2) float64, where soundings were taken; heights_m, sds_m : (N,), what they found and how surely.
    guessed_m
        Standard deviation of the roughness, to begin with.
    area_en_m : (K, 2), places that the field has to reach.
    """

    def __init__(
        self, places_en_m: FloatArray, heights_m: FloatArray, sds_m: FloatArray, guessed_m: float, area_en_m: FloatArray
    ) -> None:
        all_places = np.concatenate((places_en_m, area_en_m))
        low, high = all_places.min(axis=0), all_places.max(axis=0)
        self._within_m = max(ALIKE_WITHIN_M, float((high - low).max()) / (KNOT_SHARE * (MOST_KNOTS - 1)))
        axes = [
            np.linspace(a, b, max(2, math.ceil((b - a) / (KNOT_SHARE * self._within_m)) + 1))
            for a, b in zip(low, high, strict=True)
        ]
        self._knots = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        among = self._alike(self._knots, self._knots) + 1e-6 * np.eye(len(self._knots))
        self._factor: FloatArray = cholesky(among, lower=True)
        features = self._features(places_en_m)
        strength, rough_m = np.ones(len(places_en_m)), guessed_m
        for _ in range(ROUNDS):
            innovations, ground = _innovations(places_en_m, heights_m, sds_m, rough_m * strength)
            squares = (innovations * strength) ** 2
            whole = max(float(np.average(squares, weights=ground)), 1e-12)
            fits = [_most_likely(features, squares / whole, ground, varies) for varies in VARIES]
            self._fit = max(fits, key=lambda fit: fit.evidence)
            level = float(self._fit.logs.mean())
            rough_m *= math.sqrt(whole) * math.exp(level)
            strength = np.exp(self._fit.logs - level)

    def logs_at(self, places_en_m: FloatArray) -> FloatArray:
        """Logarithm of the roughness at places, up to a constant: (M, 2) -> (M,) float64, no unit."""
        logs: FloatArray = _designed(self._features(places_en_m), self._fit.varies) @ self._fit.weights
        return np.clip(logs, -WIDEST, WIDEST)

    def _features(self, places_en_m: FloatArray) -> FloatArray:
        """(M, knots), such that unit weights make the Gaussian field."""
        features: FloatArray = solve_triangular(self._factor, self._alike(self._knots, places_en_m), lower=True).T
        return features

    def _alike(self, places_en_m: FloatArray, others_en_m: FloatArray) -> FloatArray:
        alike: FloatArray = np.exp(-0.5 * (cdist(places_en_m, others_en_m) / self._within_m) ** 2)
        return alike


def _innovations(
    places_en_m: FloatArray, heights_m: FloatArray, sds_m: FloatArray, rough_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Innovations over their standard deviation, and the ground's share of their variance: (N,) each."""
    swell, rough = swell_and_roughness(cdist(places_en_m, places_en_m))
    noise = sds_m**2 + MODEL_SD_M**2
    factor = cholesky(swell + rough_m[:, None] * rough_m * rough + np.diag(noise), lower=True)
    rest_m = heights_m - np.average(heights_m, weights=1.0 / noise)
    innovations: FloatArray = solve_triangular(factor, rest_m, lower=True)
    return innovations, np.clip(1.0 - noise / np.diag(factor) ** 2, LEAST_GROUND, 1.0)


def _designed(features: FloatArray, varies: float) -> FloatArray:
    return np.column_stack((np.full(len(features), LEVEL), varies * features))


def _most_likely(features: FloatArray, squares: FloatArray, ground: FloatArray, varies: float) -> _Fit:
    """The most likely field when innovations have these squares: each counts by the ground's share of it."""
    design = _designed(features, varies)
    weights, even = np.zeros(design.shape[1]), np.eye(design.shape[1])
    for _ in range(NEWTON_STEPS):
        surprise = squares * np.exp(-2.0 * np.clip(design @ weights, -WIDEST, WIDEST))
        # Halfway between the curvature found and that expected: Newton's step alone is too long on even ground.
        curvature = design.T * (ground * (surprise + 1.0)) @ design + even
        step = cho_solve(cho_factor(curvature), design.T @ (ground * (surprise - 1.0)) - weights)
        weights = weights + step
        if np.abs(step).max() < SETTLED:
            break
    logs = np.clip(design @ weights, -WIDEST, WIDEST)
    surprise = squares * np.exp(-2.0 * logs)
    curvature = design.T * (2.0 * ground * surprise) @ design + even
    evidence = -float((ground * (0.5 * surprise + logs)).sum()) - 0.5 * float(weights @ weights)
    return _Fit(weights, logs, evidence - float(np.log(np.diag(cho_factor(curvature)[0])).sum()), varies)
