"""A surface from scattered soundings, and how uncertain it is everywhere: Gaussian basis functions of several widths.

The map is a sum of Gaussians that stand on the soundings (Kapoutsis 2015, eq. 1 and 3 with a width); their weights are
the weighted least squares solution that a Gaussian process prior regularises, so every place has a standard deviation
too. The broad Gaussians are equally likely everywhere. How high the narrower ones rise is judged from place to place by
what the broader ones leave unexplained there: rough ground is drawn sharply and smooth ground smoothly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from vehicle_agent.domain.frames import FloatArray

AT_ONCE = 2_000
"""Places worked out together."""
HELD_OUT_M = 3.5
"""Soundings this near to one are held out with it when its prediction is judged."""
SURPRISED_WITHIN_M = 8.0
SECOND_THOUGHTS = 2
"""How often the rises are corrected by how well held-out soundings are predicted."""


@dataclass(frozen=True, slots=True)
class Width:
    """Gaussians of one width.

    Attributes
    ----------
    width_m
        Their standard deviation.
    height_m
        How high they rise: everywhere, or as assumed where nothing is known yet.
    seen_from_m
        Around a place, soundings this near tell how high they rise there; None when they are alike everywhere.
    blind_m
        Standard deviation to which the broader Gaussians are fitted when what they leave is judged.
    """

    width_m: float
    height_m: float
    seen_from_m: float | None = None
    blind_m: float = 0.0


WIDTHS = (
    Width(32.0, 5.0),
    Width(16.0, 0.6, 20.0, 0.8),
    Width(8.0, 0.3, 12.0, 0.4),
    Width(4.0, 0.1, 7.0, 0.2),
    Width(2.0, 0.05, 6.0, 0.1),
)
"""Octaves from the size of a harbour basin to that of a rock."""


class Relief:
    """A surface fitted to soundings.

    Parameters
    ----------
    places_en_m : (N, 2) float64, where soundings were taken.
    heights_m : (N,) float64, what they found.
    sds_m : (N,) float64, their standard deviations, positive.

    Raises ValueError without soundings, or when one is not finite.
    """

    def __init__(
        self, places_en_m: FloatArray, heights_m: FloatArray, sds_m: FloatArray, widths: tuple[Width, ...] = WIDTHS
    ) -> None:
        if len(places_en_m) == 0 or not (np.isfinite(heights_m).all() and np.isfinite(sds_m).all()):
            raise ValueError("a relief needs soundings, all finite")
        self._places, self._widths = places_en_m, widths
        self._mean = float(np.average(heights_m, weights=sds_m**-2.0))
        self._surprises: list[FloatArray] = []
        self._left = self._leftovers(heights_m - self._mean, sds_m)
        self._fit(heights_m - self._mean, sds_m)
        for _ in range(SECOND_THOUGHTS):
            self._surprises.append(self._held_out())
            self._fit(heights_m - self._mean, sds_m)

    def _leftovers(self, rest_m: FloatArray, sds_m: FloatArray) -> list[FloatArray | None]:
        """Per width, the squares that the broader ones leave at every sounding, less its noise."""
        leftovers: list[FloatArray | None] = []
        covariance = np.zeros((len(self._places), len(self._places)))
        for width in self._widths:
            left = None
            if width.seen_from_m is not None:
                spread = sds_m**2 + width.blind_m**2
                weights = cho_solve(cho_factor(covariance + np.diag(spread), lower=True), rest_m)
                left = np.maximum((spread * weights) ** 2 - sds_m**2, 0.0)
            leftovers.append(left)
            rise = self._rise(width, left, self._places)
            covariance += rise[:, None] * rise * _gaussians(self._places, self._places, width.width_m)
        return leftovers

    def _fit(self, rest_m: FloatArray, sds_m: FloatArray) -> None:
        self._rises = self._rises_at(self._places)
        covariance = np.diag(sds_m**2)
        for width, rise in zip(self._widths, self._rises, strict=True):
            covariance += rise[:, None] * rise * _gaussians(self._places, self._places, width.width_m)
        self._factor = cho_factor(covariance, lower=True)
        self._weights: FloatArray = cho_solve(self._factor, rest_m)

    def _held_out(self) -> FloatArray:
        """(N, 2): square of what each sounding differs from its prediction by those not beside it, and its variance.

        The soundings around a place are held out together, so that what counts is how well the gaps between tracks are
        filled, not how well a track continues.
        """
        precision = cho_solve(self._factor, np.eye(len(self._places)))
        away = np.hypot(*(self._places[:, None] - self._places).transpose(2, 0, 1))
        surprises = np.empty((len(self._places), 2))
        for sounding in range(len(self._places)):
            beside = np.flatnonzero(away[sounding] < HELD_OUT_M)
            predicted = np.linalg.inv(precision[np.ix_(beside, beside)])
            own = int(np.flatnonzero(beside == sounding)[0])
            surprises[sounding] = float(predicted[own] @ self._weights[beside]) ** 2, predicted[own, own]
        return surprises

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
            prior = sum(rise**2 for rise in self._rises_at(places))
            told = solve_triangular(self._factor[0], self._towards(places).T, lower=True)
            parts.append(np.sqrt(np.maximum(prior - (told**2).sum(axis=0), 0.0)))
        return np.concatenate(parts) if parts else np.empty(0)

    def covariance_of(self, places_en_m: FloatArray) -> FloatArray:
        """What is uncertain together: covariance of the surface at places, (M, 2) -> (M, M) float64 square metres."""
        covariance = np.zeros((len(places_en_m), len(places_en_m)))
        for width, rise in zip(self._widths, self._rises_at(places_en_m), strict=True):
            covariance += rise[:, None] * rise * _gaussians(places_en_m, places_en_m, width.width_m)
        told = solve_triangular(self._factor[0], self._towards(places_en_m).T, lower=True)
        left: FloatArray = covariance - told.T @ told
        return left

    def _towards(self, places_en_m: FloatArray) -> FloatArray:
        """Prior covariance of places with the soundings: (M, N)."""
        covariance = np.zeros((len(places_en_m), len(self._places)))
        for width, rise, own in zip(self._widths, self._rises_at(places_en_m), self._rises, strict=True):
            covariance += rise[:, None] * own * _gaussians(places_en_m, self._places, width.width_m)
        return covariance

    def _rises_at(self, places_en_m: FloatArray) -> list[FloatArray]:
        rises = [self._rise(width, left, places_en_m) for width, left in zip(self._widths, self._left, strict=True)]
        near = _gaussians(places_en_m, self._places, SURPRISED_WITHIN_M)
        for surprise in self._surprises:
            usual = surprise[:, 1].mean()
            more = np.sqrt((near @ surprise[:, 0] + usual) / (near @ surprise[:, 1] + usual))
            more = np.clip(more, 0.5, 2.0)
            rises = [
                rise if width.seen_from_m is None else rise * more
                for width, rise in zip(self._widths, rises, strict=True)
            ]
        return rises

    def _rise(self, width: Width, left: FloatArray | None, places_en_m: FloatArray) -> FloatArray:
        """How high the Gaussians of one width rise at places, from the squares that broader ones leave around."""
        if left is None or width.seen_from_m is None:
            return np.full(len(places_en_m), width.height_m)
        near = _gaussians(places_en_m, self._places, width.seen_from_m)
        mean = (near @ left + width.height_m**2) / (near.sum(axis=1) + 1.0)
        rise: FloatArray = np.sqrt(mean)
        return rise


def _gaussians(places_en_m: FloatArray, centres_en_m: FloatArray, width_m: float) -> FloatArray:
    """(M, 2), (N, 2) -> (M, N), Kapoutsis 2015 eq. 3 with a width."""
    east = places_en_m[:, 0, None] - centres_en_m[:, 0]
    north = places_en_m[:, 1, None] - centres_en_m[:, 1]
    values: FloatArray = np.exp(-0.5 * (east**2 + north**2) / width_m**2)
    return values
