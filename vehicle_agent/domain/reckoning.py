"""Where a vehicle without a position fix is, as well as it can know: reckoning mended by ranges to teammates.

A Kalman filter over the error of the reckoned position and the constant error of the speed log that feeds it. A range
to a teammate tells about both, but the teammate's own error may long be part of what is known here, through ranges that
were exchanged before. Ranges are therefore fused by split covariance intersection (Julier and Uhlmann 2001; Li and
Nashashibi 2013), which stays consistent whatever the correlation between the two vehicles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point

SHARES = np.linspace(0.5, 0.98, 25)
"""Of trust in one's own knowledge, among which the best is chosen for each range."""
GATE = 4.0
"""A range that differs by more of its standard deviations is none."""
NEAREST_M, FARTHEST_M = 2.0, 1e5
"""Nearer than this the direction of a teammate is too uncertain; what is farther is no range, nor a deviation."""


@dataclass(frozen=True, slots=True)
class ReckoningParams:
    """How reckoning goes astray.

    Attributes
    ----------
    fixed_sd_m
        Standard deviation of a position fix, east and north each.
    drift_m_s
        Standard deviation of the constant error of the speed over ground, each axis.
    walk_m_sqrt_s
        Random walk of the reckoned position, per square root of a second.
    range_sd_m
        Standard deviation of a range to a teammate, plus `range_share` of the range.
    """

    fixed_sd_m: float = 1.0
    drift_m_s: float = 0.03
    walk_m_sqrt_s: float = 0.05
    range_sd_m: float = 0.5
    range_share: float = 0.01


class Reckoning:
    """One vehicle's error of position since its last fix; begins with one.

    Attributes
    ----------
    ranges_used, ranges_refused
        Ranges that told something, and those that could not be true.
    """

    def __init__(self, params: ReckoningParams) -> None:
        self._params = params
        self.ranges_used = self.ranges_refused = 0
        self.fix()

    @property
    def correction_m(self) -> tuple[float, float]:
        """What to add to the reckoned position, east and north."""
        return float(self._mean[0]), float(self._mean[1])

    @property
    def sd_m(self) -> float:
        """Standard deviation of the corrected position, the mean of both axes."""
        return math.sqrt(0.5 * float(self._covariance[0, 0] + self._covariance[1, 1]))

    def fix(self) -> None:
        """A position fix: the reckoned position is right again, and what the log does next is anybody's guess."""
        params = self._params
        self._mean: FloatArray = np.zeros(4)
        self._covariance: FloatArray = np.diag([params.fixed_sd_m**2] * 2 + [params.drift_m_s**2] * 2)

    def advance(self, dt_s: float) -> None:
        """Let time pass without a fix."""
        step = np.eye(4)
        step[0, 2] = step[1, 3] = dt_s
        self._mean = step @ self._mean
        self._covariance = step @ self._covariance @ step.T
        self._covariance[[0, 1], [0, 1]] += self._params.walk_m_sqrt_s**2 * dt_s

    def hear_range(self, range_m: float, reckoned_enu_m: Point, teammate_enu_m: Point, teammate_sd_m: float) -> bool:
        """Fuse a range to a teammate; whether it told anything.

        Parameters
        ----------
        reckoned_enu_m
            Where this vehicle reckoned itself when the range was taken, uncorrected.
        teammate_enu_m, teammate_sd_m
            Where the teammate believed itself then, and how well: its standard deviation in each axis.
        """
        if not (0.0 <= range_m <= FARTHEST_M and 0.0 <= teammate_sd_m <= FARTHEST_M):
            self.ranges_refused += 1
            return False
        apart = np.array(reckoned_enu_m) - np.array(teammate_enu_m)
        apart[:2] += self._mean[:2]
        supposed_m = float(np.linalg.norm(apart))
        level_m = math.hypot(apart[0], apart[1])
        if level_m < NEAREST_M:
            return False
        params, row = self._params, np.array([apart[0] / supposed_m, apart[1] / supposed_m, 0.0, 0.0])
        # A circle is no straight line: across the line of sight an error of one standard deviation bends it by so much.
        bend_m = (self.sd_m**2 + teammate_sd_m**2) / (2.0 * level_m)
        own_m2 = (params.range_sd_m + params.range_share * range_m) ** 2 + bend_m**2
        shared_m2 = teammate_sd_m**2 * float(row @ row)
        surprise_m = range_m - supposed_m
        if surprise_m**2 > GATE**2 * 2.0 * (float(row @ self._covariance @ row) + own_m2 + shared_m2):
            self.ranges_refused += 1
            return False
        before = float(np.trace(self._covariance[:2, :2]))
        best, fused = before, None
        for share in SHARES:
            prior = self._covariance / share
            across = prior @ row
            gain = across / (float(row @ across) + own_m2 + shared_m2 / (1.0 - share))
            after = prior - np.outer(gain, across)
            if after[0, 0] + after[1, 1] < best:
                best, fused = float(after[0, 0] + after[1, 1]), (gain, after)
        if fused is None:
            return False
        self._mean = self._mean + fused[0] * surprise_m
        self._covariance = 0.5 * (fused[1] + fused[1].T)
        self.ranges_used += 1
        return True


def noisy_range_m(true_m: float, rng: np.random.Generator, params: ReckoningParams | None = None) -> float:
    """A range as a simulated modem measures it."""
    params = params or ReckoningParams()
    deviation_m = params.range_sd_m + params.range_share * true_m
    return max(0.0, true_m + deviation_m * float(rng.standard_normal()))
