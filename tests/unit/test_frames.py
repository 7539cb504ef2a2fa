"""Frames: known places and what is refused."""

from __future__ import annotations

import pytest

from vehicle_agent.domain.frames import Datum, Geodetic, enu_to_ned, ned_to_enu


def test_a_minute_of_latitude_is_about_a_nautical_mile() -> None:
    datum = Datum(45.0, 7.0)
    _, north_m, _ = datum.to_enu(Geodetic(45.0 + 1 / 60, 7.0, 0.0))
    assert north_m == pytest.approx(1852.2, abs=0.2)


def test_a_degree_of_longitude_on_the_equator() -> None:
    east_m, _, _ = Datum(0.0, 0.0).to_enu(Geodetic(0.0, 1.0, 0.0))
    assert east_m == pytest.approx(111_319.49, abs=0.01)


def test_up_counts_from_the_datums_altitude() -> None:
    datum = Datum(36.6, -84.3, altitude_amsl_m=430.0)
    assert datum.to_geodetic((0.0, 0.0, 70.0)) == Geodetic(36.6, -84.3, 500.0)


@pytest.mark.parametrize(("longitude_deg", "east_m"), [(179.999, 500.0), (-179.999, -500.0)])
def test_the_antimeridian_is_no_border(longitude_deg: float, east_m: float) -> None:
    datum = Datum(10.0, longitude_deg)
    there = datum.to_geodetic((east_m, 0.0, 0.0))
    assert -180.0 <= there.longitude_deg <= 180.0
    assert there.longitude_deg * longitude_deg < 0
    assert datum.to_enu(there)[0] == pytest.approx(east_m, abs=1e-6)


def test_axes_of_enu_and_ned() -> None:
    assert enu_to_ned((1.0, 2.0, 3.0)) == (2.0, 1.0, -3.0)
    assert ned_to_enu((2.0, 1.0, -3.0)) == (1.0, 2.0, 3.0)


@pytest.mark.parametrize(
    ("latitude_deg", "longitude_deg", "altitude_amsl_m"),
    [
        (89.1, 0.0, 0.0),
        (-90.0, 0.0, 0.0),
        (0.0, 180.1, 0.0),
        (float("nan"), 0.0, 0.0),
        (0.0, float("nan"), 0.0),
        (0.0, 0.0, float("nan")),
        (0.0, 0.0, float("inf")),
    ],
)
def test_a_datum_without_an_east_is_refused(latitude_deg: float, longitude_deg: float, altitude_amsl_m: float) -> None:
    with pytest.raises(ValueError, match="datum"):
        Datum(latitude_deg, longitude_deg, altitude_amsl_m)
