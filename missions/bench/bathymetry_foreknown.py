"""What no survey of a sea floor can better: tracks laid by who knows all of the floor but its detail, or all of it.

Who knows what the real data show, how rough the detail is everywhere and which spectrum it has, is left with a
Gaussian field. Its best map is the posterior mean, and that map's expected square error follows from where soundings
are taken, whatever they find: there, deciding on the way by what was sounded gains nothing over a track laid beforehand
(Krause and Guestrin 2007). So the least expected error over all tracks bounds every planner, with every estimator, on
average over floors. Tracks are found by descent along the error's slope, from several starts; what is found is a
minimum near a start, and a small step below it may be left.

Who knows the true floor, detail and all, can lay soundings where the map needs them by chance. Nobody can who has to
find out; the gap between the two is what the bars would have a fleet foresee.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from missions.bench.bathymetry_run import (
    DEPTH_M,
    MAP_CELL_M,
    NOISE_SHARE,
    STEP_M,
    STEPS,
    VEHICLES,
    on_floor,
)
from missions.terrain.sea_floor import (
    CELL_M,
    COVARIANCE_CELL_M,
    SIDE_M,
    FloorName,
    detail_covariance,
    floor_strength,
    floor_without_detail,
    sea_floor,
)
from vehicle_agent.domain.compiled import compiled
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.planning.mapping.infill import shorten_links

FIRST_STEP_M = 0.3
"""What a sounding moves in the first round; less in each that follows."""
EVERY = 4
"""Cells of the map, along each axis, of which one counts in a round."""
JUDGED_EVERY = 25
"""Rounds after which a track is judged by every second cell."""
LINKS_MENDED = 15
MODEL_SD_M = 0.01
"""Keeps the covariance of soundings that lie close together soluble."""


@dataclass(frozen=True, slots=True)
class Slopes:
    """How an error's square changes with its parts.

    Attributes
    ----------
    ground : (N, M), with the covariance of each sounding and each place.
    soundings : (N, N), with that of each two soundings.
    heights : (N,), with what was sounded.
    """

    ground: FloatArray
    soundings: FloatArray
    heights: FloatArray


class Foreknown:
    """A floor of which all is known but the detail's own draw.

    Attributes
    ----------
    floor_m : (200, 200), the true floor.
    strength : (200, 200), how rough it is from place to place.
    """

    def __init__(self, floor: FloorName, seed: int) -> None:
        self.floor_m = sea_floor(floor, seed)
        self._smooth_m = floor_without_detail(floor, seed)
        self.strength = floor_strength(floor, seed)
        self._covariance = detail_covariance(floor)
        rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(3_300,)))
        self._drawn = rng.standard_normal(VEHICLES * STEPS)

    def expected(self, soundings_en_m: FloatArray, places_en_m: FloatArray) -> tuple[float, Slopes]:
        """Expected sum of squared errors of the best map at places, and its slopes: (N, 2), (M, 2)."""
        factor, towards, own_m2 = self._fit(soundings_en_m, places_en_m)
        weights = cho_solve(factor, towards)
        square = float(own_m2 - np.einsum("nm,nm->", weights, towards))
        return square, Slopes(-2.0 * weights, 2.0 * weights @ weights.T, np.zeros(len(soundings_en_m)))

    def happened(self, soundings_en_m: FloatArray, places_en_m: FloatArray) -> tuple[float, Slopes]:
        """Sum of squared errors of the best map on this very floor, and its slopes."""
        factor, towards, _ = self._fit(soundings_en_m, places_en_m)
        sounded = on_floor(self.floor_m - self._smooth_m, soundings_en_m)
        sounded = sounded + self._sds_m(soundings_en_m) * self._drawn[: len(soundings_en_m)]
        weights = cho_solve(factor, sounded)
        errors = towards.T @ weights - on_floor(self.floor_m - self._smooth_m, places_en_m)
        blame = cho_solve(factor, towards @ errors)
        both = np.outer(blame, weights)
        slopes = Slopes(2.0 * np.outer(weights, errors), -2.0 * (both + both.T), 2.0 * blame)
        return float(errors @ errors), slopes

    def slope(self, soundings_en_m: FloatArray, places_en_m: FloatArray, by: Slopes) -> FloatArray:
        """How the error's square changes as each sounding moves; (N, 2), its strength taken to stay."""
        at, places = on_floor(self.strength, soundings_en_m), on_floor(self.strength, places_en_m)
        slope = _pulled(self._covariance, soundings_en_m, at, places_en_m, places, by.ground)
        slope += _pulled(self._covariance, soundings_en_m, at, soundings_en_m, at, by.soundings)
        for axis in (0, 1):
            steepness = np.asarray(np.gradient(self.floor_m - self._smooth_m, CELL_M, axis=axis))
            slope[:, axis] += by.heights * on_floor(steepness, soundings_en_m)
        return slope

    def _fit(
        self, soundings_en_m: FloatArray, places_en_m: FloatArray
    ) -> tuple[tuple[FloatArray, bool], FloatArray, float]:
        at, places = on_floor(self.strength, soundings_en_m), on_floor(self.strength, places_en_m)
        among = _covariances(self._covariance, soundings_en_m, at, soundings_en_m, at)
        among += np.diag(self._sds_m(soundings_en_m) ** 2 + MODEL_SD_M**2)
        towards = _covariances(self._covariance, soundings_en_m, at, places_en_m, places)
        return cho_factor(among, lower=True), towards, float(self._covariance[0, 0] * (places**2).sum())

    def _sds_m(self, places_en_m: FloatArray) -> FloatArray:
        sds_m: FloatArray = NOISE_SHARE * (-DEPTH_M - on_floor(self._smooth_m, places_en_m))
        return sds_m


Error = Callable[[FloatArray, FloatArray], tuple[float, Slopes]]
Mend = Callable[[FloatArray], FloatArray]


def map_error(error: Error, soundings_en_m: FloatArray, every: int = 1, first: tuple[int, int] = (0, 0)) -> float:
    """L2 error over the map's cells, from one of `every` along each axis."""
    places = map_cells(every, first)
    return math.sqrt(max(error(soundings_en_m, places)[0], 0.0) * (SIDE_M / MAP_CELL_M) ** 2 / len(places))


def map_cells(every: int, first: tuple[int, int]) -> FloatArray:
    """Centres of the map's cells: (M, 2)."""
    axes = [np.arange(start + 0.5, SIDE_M / MAP_CELL_M, every) * MAP_CELL_M for start in first]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)


def descend(known: Foreknown, error: Error, start_en_m: FloatArray, mend: Mend, rounds: int, seed: int) -> FloatArray:
    """Move soundings down the error's slope, each round mended to what may be sailed; the best places met: (N, 2)."""
    rng = np.random.default_rng(seed)
    track = best = mend(start_en_m)
    least = map_error(error, track, every=2)
    speed, power = np.zeros_like(track), np.zeros(len(track))
    for number in range(rounds):
        first = rng.integers(EVERY, size=2)
        places = map_cells(EVERY, (int(first[0]), int(first[1])))
        slope = known.slope(track, places, error(track, places)[1])
        speed = 0.9 * speed + 0.1 * slope
        power = 0.98 * power + 0.02 * (slope**2).sum(axis=1)
        usual = np.sqrt(power / (1.0 - 0.98 ** (number + 1)))
        scale = usual + 0.3 * math.sqrt(float((usual**2).mean())) + 1e-12
        step_m = FIRST_STEP_M * (1.0 - number / rounds)
        track = mend(track - step_m * speed / (1.0 - 0.9 ** (number + 1)) / scale[:, None])
        if (number + 1) % JUDGED_EVERY == 0 or number + 1 == rounds:
            judged = map_error(error, track, every=2)
            if judged < least:
                least, best = judged, track
    return best


def sailed(places_en_m: FloatArray) -> FloatArray:
    """Both vehicles' soundings drawn together until none is further than a step from the one before: (N, 2)."""
    tracks = []
    for track in np.split(np.clip(places_en_m, 0.0, SIDE_M), VEHICLES):
        track = track.copy()
        for _ in range(LINKS_MENDED):
            shorten_links(track, np.ones(len(track)), STEP_M)
        for place in range(1, len(track)):
            long_m = math.dist(track[place], track[place - 1])
            if long_m > STEP_M:
                track[place] = track[place - 1] + STEP_M / long_m * (track[place] - track[place - 1])
        tracks.append(track)
    return np.concatenate(tracks)


def anywhere(places_en_m: FloatArray) -> FloatArray:
    """Soundings inside the area, with no way between them."""
    inside: FloatArray = np.clip(places_en_m, 0.0, SIDE_M)
    return inside


@compiled
def _covariances(
    table: FloatArray, places: FloatArray, strengths: FloatArray, others: FloatArray, other_strengths: FloatArray
) -> FloatArray:
    """Of detail at places with detail at others: (N, 2), (M, 2) -> (N, M)."""
    covariances = np.empty((len(places), len(others)))
    for place in range(len(places)):
        for other in range(len(others)):
            apart = _looked_up(table, places[place, 0] - others[other, 0], places[place, 1] - others[other, 1])
            covariances[place, other] = strengths[place] * other_strengths[other] * apart
    return covariances


@compiled
def _pulled(
    table: FloatArray,
    places: FloatArray,
    strengths: FloatArray,
    others: FloatArray,
    other_strengths: FloatArray,
    weights: FloatArray,
) -> FloatArray:
    """Change of the weighted sum of covariances as each place moves and the others stay: (N, M) weights -> (N, 2)."""
    pulled = np.zeros((len(places), 2))
    cell = COVARIANCE_CELL_M
    for place in range(len(places)):
        for other in range(len(others)):
            east = places[place, 0] - others[other, 0]
            north = places[place, 1] - others[other, 1]
            weight = weights[place, other] * strengths[place] * other_strengths[other] / (2.0 * cell)
            pulled[place, 0] += weight * (_looked_up(table, east + cell, north) - _looked_up(table, east - cell, north))
            pulled[place, 1] += weight * (_looked_up(table, east, north + cell) - _looked_up(table, east, north - cell))
    return pulled


@compiled
def _looked_up(table: FloatArray, east_m: float, north_m: float) -> float:
    column, row = abs(east_m) / COVARIANCE_CELL_M, abs(north_m) / COVARIANCE_CELL_M
    west, south = int(column), int(row)
    east, north = column - west, row - south
    cells = len(table)
    here, there = west % cells, (west + 1) % cells
    low, high = south % cells, (south + 1) % cells
    lower = (1.0 - east) * table[here, low] + east * table[there, low]
    upper = (1.0 - east) * table[here, high] + east * table[there, high]
    return float((1.0 - north) * lower + north * upper)
