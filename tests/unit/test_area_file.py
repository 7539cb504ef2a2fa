"""Polygons from GeoJSON and WKT files, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from ground_station.area_file import AreaFileError, read_polygon
from vehicle_agent.domain.frames import Datum

DATUM = Datum(47.0, 8.0, 0.0)
RING = [[8.0, 47.0], [8.01, 47.0], [8.01, 47.01], [8.0, 47.0]]


@pytest.mark.parametrize(
    "content",
    [
        json.dumps({"type": "Polygon", "coordinates": [RING]}),
        json.dumps({"type": "MultiPolygon", "coordinates": [[RING]]}),
        json.dumps({"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [RING]}}),
        json.dumps(
            {
                "type": "FeatureCollection",
                "features": [
                    {"type": "Feature", "geometry": {"type": "Point", "coordinates": [8, 47]}},
                    {"type": "Feature", "geometry": {"type": "Polygon", "coordinates": [RING]}},
                ],
            }
        ),
        "POLYGON ((8.0 47.0, 8.01 47.0, 8.01 47.01, 8.0 47.0))",
        "SRID=4326; polygon z ((8.0 47.0 5, 8.01 47.0 5, 8.01 47.01 5))",
    ],
)
def test_the_first_polygon_is_read(tmp_path: Path, content: str) -> None:
    path = tmp_path / "area"
    path.write_text(content)
    corners = read_polygon(path, DATUM)
    assert len(corners) == 3
    assert corners[0] == pytest.approx((0.0, 0.0), abs=1e-6)
    assert corners[1] == pytest.approx((760.6, 0.0), abs=2.0)
    assert corners[2] == pytest.approx((760.6, 1_111.8), abs=2.0)


@pytest.mark.parametrize(
    "content",
    [
        None,
        "",
        "{",
        "[]",
        json.dumps({"type": "Point", "coordinates": [8, 47]}),
        json.dumps({"type": "Polygon", "coordinates": [[[8, 47], [8, 48]]]}),
        json.dumps({"type": "Polygon", "coordinates": [[["x", 47], [8, 48], [8, 49]]]}),
        json.dumps({"type": "Polygon", "coordinates": [[[200, 47], [8, 48], [8, 49]]]}),
        json.dumps({"type": "FeatureCollection", "features": None}),
        "POLYGON ((1 2, 3))",
        "POLYGON ((nan 2, 3 4, 5 6))",
    ],
)
def test_what_holds_no_polygon_is_refused_in_one_sentence(tmp_path: Path, content: Any) -> None:
    path = tmp_path / "area"
    if content is not None:
        path.write_text(content)
    with pytest.raises(AreaFileError, match="area") as refusal:
        read_polygon(path, DATUM)
    assert "\n" not in str(refusal.value)
