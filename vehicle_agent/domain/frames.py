"""Frames: the mission's local east-north-up metres, geodetic coordinates and north-east-down.

The local frame is the plane that autopilots use for navigation: metres along the meridian and along the parallel of
the datum, scaled by the WGS 84 radii of curvature there, with z the height above the datum's altitude. At d <= 10 km
from a datum below 80 degrees it departs from the tangent plane by at most d^2 (0.6 tan|latitude| + 0.01) / R, R being
the Earth's radius: 2.0 m at 5 km and 40 degrees. All vehicles share it, and z stays an altitude at any distance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
Point = tuple[float, float, float]

SEMI_MAJOR_AXIS_M = 6_378_137.0
"""WGS 84 semi-major axis (EPSG:7030)."""
FLATTENING = 1.0 / 298.257_223_563
"""WGS 84 flattening (EPSG:7030)."""


def as_array(point: Point) -> FloatArray:
    """(3,) float64 of a point."""
    return np.array(point, dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Geodetic:
    """A position on the WGS 84 ellipsoid with its altitude above mean sea level."""

    latitude_deg: float
    longitude_deg: float
    altitude_amsl_m: float


@dataclass(frozen=True, slots=True)
class Datum:
    """Where the mission's local frame has its origin.

    Attributes
    ----------
    latitude_deg, longitude_deg
        WGS 84, degrees; latitude within +-89 so that the frame has an east.
    altitude_amsl_m
        The altitude at which local z is zero.
    """

    latitude_deg: float
    longitude_deg: float
    altitude_amsl_m: float = 0.0
    _north_m_per_deg: float = field(init=False, repr=False, compare=False)
    _east_m_per_deg: float = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not -89.0 <= self.latitude_deg <= 89.0:
            raise ValueError("the datum's latitude must lie within -89 and 89 degrees")
        if not -180.0 <= self.longitude_deg <= 180.0:
            raise ValueError("the datum's longitude must lie within -180 and 180 degrees")
        if not math.isfinite(self.altitude_amsl_m):
            raise ValueError("the datum's altitude must be a finite number of metres")
        latitude = math.radians(self.latitude_deg)
        eccentricity_squared = FLATTENING * (2.0 - FLATTENING)
        w = 1.0 - eccentricity_squared * math.sin(latitude) ** 2
        meridian_radius_m = SEMI_MAJOR_AXIS_M * (1.0 - eccentricity_squared) / w**1.5
        normal_radius_m = SEMI_MAJOR_AXIS_M / math.sqrt(w)
        object.__setattr__(self, "_north_m_per_deg", math.radians(meridian_radius_m))
        object.__setattr__(self, "_east_m_per_deg", math.radians(normal_radius_m * math.cos(latitude)))

    def to_geodetic(self, position_enu_m: Point) -> Geodetic:
        """Local east, north, up metres to latitude, longitude and altitude above mean sea level."""
        east_m, north_m, up_m = position_enu_m
        longitude_deg = self.longitude_deg + east_m / self._east_m_per_deg
        if not -180.0 <= longitude_deg <= 180.0:  # beyond the antimeridian
            longitude_deg = (longitude_deg + 180.0) % 360.0 - 180.0
        return Geodetic(self.latitude_deg + north_m / self._north_m_per_deg, longitude_deg, self.altitude_amsl_m + up_m)

    def to_enu(self, position: Geodetic) -> Point:
        """Latitude, longitude and altitude above mean sea level to local east, north, up metres."""
        longitude_difference_deg = (position.longitude_deg - self.longitude_deg + 180.0) % 360.0 - 180.0
        return (
            longitude_difference_deg * self._east_m_per_deg,
            (position.latitude_deg - self.latitude_deg) * self._north_m_per_deg,
            position.altitude_amsl_m - self.altitude_amsl_m,
        )


def enu_to_ned(vector_enu: Point) -> Point:
    """East-north-up to north-east-down, any unit; the same swap undoes itself."""
    east, north, up = vector_enu
    return (north, east, -up)


def ned_to_enu(vector_ned: Point) -> Point:
    """North-east-down to east-north-up, any unit."""
    north, east, down = vector_ned
    return (east, north, -down)
