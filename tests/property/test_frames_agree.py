"""Frames: round trips, and agreement with an independent way through Earth-centred coordinates."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.domain.frames import Datum, Geodetic, Point, enu_to_ned, ned_to_enu

EARTH_RADIUS_M = 6_371_000.0
LATITUDES = st.floats(-89.0, 89.0)
LONGITUDES = st.floats(-180.0, 180.0)
ALTITUDES_M = st.floats(-12_000.0, 12_000.0)
OFFSETS_M = st.floats(-50_000.0, 50_000.0)


def earth_centred_m(position: Geodetic) -> tuple[float, float, float]:
    """WGS 84 latitude, longitude, height to Earth-centred, Earth-fixed metres by the textbook's formula."""
    semi_major_m, semi_minor_m = 6_378_137.0, 6_356_752.314_245
    latitude, longitude = math.radians(position.latitude_deg), math.radians(position.longitude_deg)
    cosine, sine = math.cos(latitude), math.sin(latitude)
    normal_m = semi_major_m**2 / math.hypot(semi_major_m * cosine, semi_minor_m * sine)
    height_m = position.altitude_amsl_m
    return (
        (normal_m + height_m) * cosine * math.cos(longitude),
        (normal_m + height_m) * cosine * math.sin(longitude),
        (normal_m * (semi_minor_m / semi_major_m) ** 2 + height_m) * sine,
    )


def tangent_plane_m(datum: Datum, position: Geodetic) -> Point:
    """East, north and up of a position in the plane that touches the ellipsoid at the datum."""
    x0, y0, z0 = earth_centred_m(Geodetic(datum.latitude_deg, datum.longitude_deg, 0.0))
    x, y, z = earth_centred_m(position)
    dx, dy, dz = x - x0, y - y0, z - z0
    latitude, longitude = math.radians(datum.latitude_deg), math.radians(datum.longitude_deg)
    outward = math.cos(longitude) * dx + math.sin(longitude) * dy
    return (
        -math.sin(longitude) * dx + math.cos(longitude) * dy,
        math.cos(latitude) * dz - math.sin(latitude) * outward,
        math.cos(latitude) * outward + math.sin(latitude) * dz,
    )


@given(LATITUDES, LONGITUDES, ALTITUDES_M, st.tuples(OFFSETS_M, OFFSETS_M, ALTITUDES_M))
def test_there_and_back(latitude_deg: float, longitude_deg: float, altitude_m: float, position_enu_m: Point) -> None:
    datum = Datum(latitude_deg, longitude_deg, altitude_m)
    there = datum.to_geodetic(position_enu_m)
    assert -180.0 <= there.longitude_deg <= 180.0
    assert math.dist(datum.to_enu(there), position_enu_m) < 1e-6


@given(st.floats(-80.0, 80.0), LONGITUDES, st.floats(0.0, 10_000.0), st.floats(0.0, 360.0))
def test_the_local_plane_departs_from_the_tangent_plane_as_little_as_it_says(
    latitude_deg: float, longitude_deg: float, distance_m: float, bearing_deg: float
) -> None:
    datum = Datum(latitude_deg, longitude_deg)
    east_m = distance_m * math.sin(math.radians(bearing_deg))
    north_m = distance_m * math.cos(math.radians(bearing_deg))
    east, north, up = tangent_plane_m(datum, datum.to_geodetic((east_m, north_m, 0.0)))
    bound_m = distance_m**2 * (0.6 * math.tan(math.radians(abs(latitude_deg))) + 0.01) / EARTH_RADIUS_M
    assert math.hypot(east - east_m, north - north_m) <= bound_m + 1e-6
    # z is an altitude: the tangent plane rises above the ground by d^2 / 2R.
    assert abs(up + distance_m**2 / (2 * EARTH_RADIUS_M)) <= 0.02 * distance_m**2 / EARTH_RADIUS_M + 1e-6


@given(st.floats(-80.0, 80.0), LONGITUDES, st.floats(-100.0, 100.0), st.floats(-100.0, 100.0))
def test_near_the_datum_both_agree_to_a_centimetre(
    latitude_deg: float, longitude_deg: float, east_m: float, north_m: float
) -> None:
    datum = Datum(latitude_deg, longitude_deg)
    position = datum.to_geodetic((east_m, north_m, 0.0))
    assert math.dist(tangent_plane_m(datum, position)[:2], (east_m, north_m)) < 0.012


@given(st.tuples(OFFSETS_M, OFFSETS_M, OFFSETS_M))
def test_north_east_down_is_its_own_way_back(vector: Point) -> None:
    assert ned_to_enu(enu_to_ned(vector)) == vector
