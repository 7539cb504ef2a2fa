"""A surface from scattered soundings, and how uncertain it is everywhere.

The map is a sum of basis functions that stand on the soundings (Kapoutsis 2015, eq. 1-3); their weights are the
weighted least squares solution that a Gaussian process prior regularises, so every place has a standard deviation too.
The prior is a broad swell plus roughness without a scale of its own: increments over a distance r have a mean square
proportional to r^1.5, as measured on sea floors of many kinds (a Hurst exponent of 0.75; Goff and Jordan 1988 found 0.7
to 1). How strong the roughness is on the whole is fitted to the soundings by maximum likelihood. How strong it is from
place to place follows from how far each sounding lies from what the others predict there, so that rough ground is drawn
sharply and even ground smoothly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.optimize import minimize_scalar
from scipy.spatial.distance import cdist

from vehicle_agent.domain.frames import FloatArray

AT_ONCE = 2_000
"""Places worked out together."""
SWELL_M, SWELL_WIDTH_M = 5.0, 32.0
"""Height and width of the Gaussians of the swell, from the size of a harbour basin."""
EXPONENT = 1.5
"""Of distance, in the mean square of the roughness's increments: twice the Hurst exponent."""
FADES_M = 40.0
"""Over this distance the roughness is no longer alike."""
LEAST_ROUGH_M, MOST_ROUGH_M = 0.02, 20.0
"""Standard deviation of the roughness, within which it is fitted."""
FITTED_TO = 400
"""Soundings at most from which the strength on the whole is fitted."""
SURPRISED_WITHIN_M = 8.0
"""Standard deviation of the Gaussian over which soundings tell how rough a place is."""
WEAKEST = 0.01
"""Roughness of a place over that on the whole, at least."""


@dataclass(frozen=True, slots=True)
class _Surprises:
    """What each sounding differs from its prediction by the others.

    Attributes
    ----------
    squares_m2 : (N,), the square of the difference, less the sounding's own variance.
    expected_m2 : (N,), what that would be where the roughness is as strong as on the whole.
    """

    squares_m2: FloatArray
    expected_m2: FloatArray


class Relief:
    """A surface fitted to soundings.

    Parameters
    ----------
    places_en_m : (N, 2) float64, where soundings were taken.
    heights_m : (N,) float64, what they found.
    sds_m : (N,) float64, their standard deviations, positive.

    Raises ValueError without soundings, or when one is not finite.

    Attributes
    ----------
    places_en_m, heights_m, sds_m
        The soundings.
    rough_m
        Standard deviation of the roughness on the whole.
    """

    def __init__(self, places_en_m: FloatArray, heights_m: FloatArray, sds_m: FloatArray) -> None:
        if len(places_en_m) == 0 or not (np.isfinite(heights_m).all() and np.isfinite(sds_m).all()):
            raise ValueError("a relief needs soundings, all finite")
        self.places_en_m, self.heights_m, self.sds_m = places_en_m, heights_m, sds_m
        self._mean = float(np.average(heights_m, weights=sds_m**-2.0))
        self._surprises: _Surprises | None = None
        rest_m = heights_m - self._mean
        swell, rough = swell_and_roughness(cdist(places_en_m, places_en_m))
        self._fit(rest_m, sds_m, swell, rough)
        self._surprises = self._judge(sds_m)
        self._fit(rest_m, sds_m, swell, rough)

    def _fit(self, rest_m: FloatArray, sds_m: FloatArray, swell: FloatArray, rough: FloatArray) -> None:
        """Fit the strength of the roughness, then the weights; `swell` and `rough` are (N, N)."""
        self._strength = self.strength_at(self.places_en_m)
        shaped = self._strength[:, None] * self._strength * rough
        some = slice(None, None, math.ceil(len(rest_m) / FITTED_TO))
        fixed = swell[some, some] + np.diag(sds_m[some] ** 2)
        self.rough_m = _most_likely(rest_m[some], fixed, shaped[some, some])
        covariance = swell + np.diag(sds_m**2) + self.rough_m**2 * shaped
        self._factor = cho_factor(covariance, lower=True)
        self._weights: FloatArray = cho_solve(self._factor, rest_m)

    def _judge(self, sds_m: FloatArray) -> _Surprises:
        """Predict every sounding by all others."""
        inverse = solve_triangular(self._factor[0], np.eye(len(sds_m)), lower=True)
        variance = 1.0 / (inverse**2).sum(axis=0)
        squares = (self._weights * variance) ** 2
        noise = sds_m**2
        return _Surprises(np.maximum(squares - noise, 0.0), np.maximum(variance - noise, 1e-9))

    def strength_at(self, places_en_m: FloatArray) -> FloatArray:
        """How rough the surface is at places, over how rough it is on the whole: (M, 2) -> (M,) float64, no unit."""
        if self._surprises is None:
            return np.ones(len(places_en_m))
        squares, expected = self._surprises.squares_m2, self._surprises.expected_m2
        whole = max(float(squares.sum() / expected.sum()), 1e-12)
        parts = []
        for first in range(0, len(places_en_m), AT_ONCE):
            away = cdist(places_en_m[first : first + AT_ONCE], self.places_en_m)
            near = np.exp(-0.5 * (away / SURPRISED_WITHIN_M) ** 2)
            usual = float(expected.mean())  # one sounding more that is as surprising as all are
            parts.append((near @ squares / whole + usual) / (near @ expected + usual))
        return np.maximum(np.sqrt(np.concatenate(parts)), WEAKEST) if parts else np.empty(0)

    def heights_at(self, places_en_m: FloatArray) -> FloatArray:
        """The surface at places, (M, 2) -> (M,) float64 metres."""
        parts = [
            self._mean + self._towards(places_en_m[first : first + AT_ONCE]) @ self._weights
            for first in range(0, len(places_en_m), AT_ONCE)
        ]
        return np.concatenate(parts) if parts else np.empty(0)

    def sds_at(self, places_en_m: FloatArray) -> FloatArray:
        """Standard deviation of the surface at places, (M, 2) -> (M,) float64 metres."""
        parts = []
        for first in range(0, len(places_en_m), AT_ONCE):
            places = places_en_m[first : first + AT_ONCE]
            prior = SWELL_M**2 + (self.rough_m * self.strength_at(places)) ** 2
            told = solve_triangular(self._factor[0], self._towards(places).T, lower=True)
            parts.append(np.sqrt(np.maximum(prior - (told**2).sum(axis=0), 0.0)))
        return np.concatenate(parts) if parts else np.empty(0)

    def _towards(self, places_en_m: FloatArray) -> FloatArray:
        """Prior covariance of places with the soundings: (M, N)."""
        swell, rough = swell_and_roughness(cdist(places_en_m, self.places_en_m))
        strength = self.strength_at(places_en_m)
        covariance: FloatArray = swell + self.rough_m**2 * strength[:, None] * self._strength * rough
        return covariance


def _most_likely(rest_m: FloatArray, fixed_m2: FloatArray, shaped: FloatArray) -> float:
    """Standard deviation of the roughness under which the soundings are most likely, metres."""

    def unlikely(log_rough: float) -> float:
        factor, _ = cho_factor(fixed_m2 + math.exp(2.0 * log_rough) * shaped, lower=True)
        whitened = solve_triangular(factor, rest_m, lower=True)
        return float(0.5 * whitened @ whitened + np.log(np.diag(factor)).sum())

    span = (math.log(LEAST_ROUGH_M), math.log(MOST_ROUGH_M))
    return math.exp(minimize_scalar(unlikely, bounds=span, method="bounded", options={"xatol": 0.05}).x)


def swell_and_roughness(away_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Covariance of the swell, square metres, and correlation of the roughness, over distances (Kapoutsis 2015, eq. 3).

    The roughness's is the powered exponential, whose realisations are as rough as those of the power law.
    """
    swell = SWELL_M**2 * np.exp(-0.5 * (away_m / SWELL_WIDTH_M) ** 2)
    return swell, np.exp(-((away_m / FADES_M) ** EXPONENT))
