"""The noisy, short-sighted range sensor of Kapoutsis 2015 (eq. 4, 5, 24): what it measures, and what that is worth."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.landmark_layout import LandmarkParams


@dataclass(frozen=True, slots=True)
class RangeSensor:
    """A sensor that measures the distance to every landmark in its sight.

    Attributes
    ----------
    range_m
        Visibility threshold, three-dimensional (thres in eq. 5).
    noise_share
        Standard deviation of a measured range over that range (eq. 24).
    footprint_m
        Horizontal radius around the vehicle that it sees; infinite for the paper's sensor that looks everywhere, about
        half a landmark spacing for a single beam straight down.
    drift_m_per_s
        Growth of the vehicle's own position error since its last fix; adds to the noise (t_uw in eq. 4).
    """

    range_m: float
    noise_share: float
    footprint_m: float = math.inf
    drift_m_per_s: float = 0.0

    def __post_init__(self) -> None:
        if not (self.range_m > 0 and math.isfinite(self.range_m)):
            raise ValueError("range_m must be positive")
        if not (self.noise_share > 0 and math.isfinite(self.noise_share)):
            raise ValueError("noise_share must be positive")
        if not self.footprint_m > 0:
            raise ValueError("footprint_m must be positive")
        if not (self.drift_m_per_s >= 0 and math.isfinite(self.drift_m_per_s)):
            raise ValueError("drift_m_per_s must not be negative")

    def noise_sd_m(self, ranges_m: FloatArray, unfixed_s: float = 0.0) -> FloatArray:
        """Standard deviation h_xi of measured ranges (eq. 4), `unfixed_s` seconds after the last position fix."""
        deviation: FloatArray = np.hypot(self.noise_share * ranges_m, self.drift_m_per_s * unfixed_s)
        return deviation

    def measure(self, true_ranges_m: FloatArray, rng: np.random.Generator, unfixed_s: float = 0.0) -> FloatArray:
        """Ranges as measured (eq. 24): (N,) -> (N,), of landmarks that are in sight and nearer than `range_m`."""
        ranges: FloatArray = true_ranges_m + self.noise_sd_m(true_ranges_m, unfixed_s) * rng.standard_normal(
            len(true_ranges_m)
        )
        return ranges

    def best_sd_m(self, least_clearance_m: float) -> float:
        """The best that one measurement of a height can be: straight down from the lowest place allowed."""
        return self.noise_share * least_clearance_m

    def can_see(self, least_clearance_m: float) -> bool:
        """Whether a vehicle that keeps so far above the surface sees anything of it at all."""
        return least_clearance_m < self.range_m


def heights_from_ranges(
    sensor: RangeSensor,
    eye_enu_m: Point,
    positions_en_m: FloatArray,
    ranges_m: FloatArray,
    supposed_heights_m: FloatArray,
    unfixed_s: float = 0.0,
) -> tuple[FloatArray, FloatArray]:
    """One Gauss-Newton step of the weighted least squares: landmarks' heights from ranges to them.

    Parameters
    ----------
    eye_enu_m
        Where the sensor is, above the surface.
    positions_en_m : (N, 2) float64, where the landmarks stand.
    ranges_m : (N,) float64, as measured.
    supposed_heights_m : (N,) float64, estimates so far, about which the sensor's equation is linearised; NaN for none.

    Returns
    -------
    heights_m, sds_m : (N,) float64, for `LandmarkMap.observe`; NaN where a range is shorter than the way over ground,
    which tells nothing of the height.
    """
    east, north, up = eye_enu_m
    away_squared = (positions_en_m[:, 0] - east) ** 2 + (positions_en_m[:, 1] - north) ** 2
    with np.errstate(invalid="ignore", divide="ignore"):
        drop = up - supposed_heights_m
        unknown = ~(drop > 0)
        drop = np.where(unknown, np.sqrt(ranges_m**2 - away_squared), drop)
        expected = np.sqrt(away_squared + drop**2)
        slope = drop / expected
        heights: FloatArray = up - drop - (ranges_m - expected) / slope
        sds: FloatArray = sensor.noise_sd_m(expected, unfixed_s) / slope
    bad = ~np.isfinite(heights) | ~np.isfinite(sds) | ~(sds > 0.0)
    return np.where(bad, np.nan, heights), np.where(bad, np.nan, sds)


def expected_information(
    sensor: RangeSensor, params: LandmarkParams, away_m: FloatArray, drop_m: FloatArray, unfixed_s: float = 0.0
) -> FloatArray:
    """What one measurement would tell of landmarks so far away over ground and so far below, on any common shape.

    Returns
    -------
    Inverse variance in those of an accurate landmark; 0 where the sensor does not see or the landmark is not below.
    """
    ranges = np.hypot(away_m, drop_m)
    seen = (ranges < sensor.range_m) & (away_m <= sensor.footprint_m) & (drop_m > 0)
    safe = np.where(seen, ranges, 1.0)
    deviation = sensor.noise_sd_m(safe, unfixed_s) * safe / np.where(seen, drop_m, 1.0)
    share = (params.accurate_sd_m / np.maximum(deviation, params.best_sd_m)) ** 2
    return np.where(seen, share, 0.0)
