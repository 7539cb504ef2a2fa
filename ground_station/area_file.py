"""Polygons from files: GeoJSON or WKT in degrees, to corners in the mission's plane."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

from vehicle_agent.domain.frames import Datum, Geodetic

MAX_FILE_BYTES = 2_000_000
EastNorth = tuple[float, float]
_RING = re.compile(r"^\s*(?:SRID=4326;)?\s*POLYGON\s*Z?\s*\(\s*\(([^()]*)\)", re.IGNORECASE)


class AreaFileError(Exception):
    """A file that holds no usable polygon; its text is one sentence with the file and the mend."""


def read_polygon(path: Path, datum: Datum) -> list[EastNorth]:
    """Corners of a file's first polygon, east and north in ENU metres, not closed; holes are left out."""
    try:
        with path.open("rb") as file:
            content = file.read(MAX_FILE_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "is not a path"
        raise AreaFileError(f"{path}: {reason}; name a GeoJSON or WKT file") from None
    if len(content) > MAX_FILE_BYTES:
        raise AreaFileError(f"{path}: is larger than {MAX_FILE_BYTES} bytes; name a smaller file")
    text = content.decode("utf-8-sig", "replace")
    ring = _from_geojson(text) if text.lstrip().startswith("{") else _from_wkt(text)
    if ring is None or len(ring) < 3:
        raise AreaFileError(f"{path}: holds no polygon; give a GeoJSON Polygon or a WKT POLYGON in degrees")
    for longitude_deg, latitude_deg in ring:
        if not (math.isfinite(longitude_deg) and abs(longitude_deg) <= 180 and abs(latitude_deg) <= 90):
            raise AreaFileError(f"{path}: {longitude_deg:g} {latitude_deg:g} is no longitude and latitude in degrees")
    if ring[0] == ring[-1]:
        ring = ring[:-1]
    places = [
        datum.to_enu(Geodetic(latitude_deg, longitude_deg, datum.altitude_amsl_m))
        for longitude_deg, latitude_deg in ring
    ]
    return [(east_m, north_m) for east_m, north_m, _ in places]


def _from_geojson(text: str) -> list[EastNorth] | None:
    try:
        return _ring_in(json.loads(text))
    except (ValueError, TypeError, KeyError, IndexError, AttributeError, RecursionError):
        return None


def _ring_in(node: dict[str, Any]) -> list[EastNorth] | None:
    """The outer ring of the first polygon in a GeoJSON object, (longitude, latitude) pairs."""
    match node["type"]:
        case "FeatureCollection":
            rings = (_ring_in(feature) for feature in node["features"])
            return next((ring for ring in rings if ring), None)
        case "Feature":
            return _ring_in(node["geometry"])
        case "Polygon":
            ring = node["coordinates"][0]
        case "MultiPolygon":
            ring = node["coordinates"][0][0]
        case _:
            return None
    return [(float(place[0]), float(place[1])) for place in ring]


def _from_wkt(text: str) -> list[EastNorth] | None:
    found = _RING.match(text)
    if found is None:
        return None
    try:
        places = [[float(number) for number in place.split()] for place in found[1].split(",")]
    except ValueError:
        return None
    return [(place[0], place[1]) for place in places] if all(len(place) >= 2 for place in places) else None
