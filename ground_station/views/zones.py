"""Polygons on the map as pixels: no-fly zones, the ordered area, the fence, and what is being drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ground_station.picture import FleetState
from ground_station.views import palette
from ground_station.views.ink import Rgb
from ground_station.views.raster import line_pixels
from ground_station.views.viewport import Viewport
from ground_station.views.window import Layer, MapWindow
from vehicle_agent.domain.polygon import points_inside
from vehicle_agent.wire.messages import PolygonCm

HATCH = 2
"""One pixel of so many is tinted, along both diagonals."""
Pixel = tuple[int, int]


@dataclass(frozen=True, slots=True)
class ZonePixels:
    """Colours by (x, y): of hatches, which let the ground shine through, and of borders."""

    tints: dict[Pixel, Rgb] = field(default_factory=dict)
    borders: dict[Pixel, Rgb] = field(default_factory=dict)


def zone_pixels(state: FleetState, view: Viewport, window: MapWindow) -> ZonePixels:
    """Everything with corners that the window shows."""
    pixels = ZonePixels()
    if Layer.FENCE in window.layers:
        fence = [(float(east_m), float(north_m)) for east_m, north_m in state.plan.fence_en_m]
        _border(fence, palette.QUIET, view, pixels, closed=True)
    if state.area_cm:
        _border(_metres(state.area_cm), palette.ACCENT, view, pixels, closed=True)
    if Layer.NO_FLY in window.layers:
        for polygon_cm in state.zones.values():
            corners = _metres(polygon_cm)
            for pixel in _inside(corners, view):
                pixels.tints[pixel] = palette.BAD
            _border(corners, palette.BAD, view, pixels, closed=True)
    _border(window.drawn_en_m, palette.WARN, view, pixels, closed=False)
    return pixels


def _border(
    corners: Sequence[tuple[float, float]], colour: Rgb, view: Viewport, pixels: ZonePixels, *, closed: bool
) -> None:
    ends = [*corners, corners[0]] if closed and corners else corners
    for pixel in line_pixels(ends, view):
        pixels.borders[pixel] = colour


def _inside(corners: Sequence[tuple[float, float]], view: Viewport) -> list[Pixel]:
    """Hatched pixels whose middle lies in a polygon."""
    x, y = np.meshgrid(np.arange(view.width), np.arange(view.height), indexing="ij")
    hatched = (x + y) % HATCH == 0
    x, y = x[hatched], y[hatched]
    points = np.column_stack(
        (view.west_m + (x + 0.5) * view.pixel_width_m, view.north_m - (y + 0.5) * view.pixel_height_m)
    )
    within = points_inside(points, np.array(corners))
    return list(zip(x[within].tolist(), y[within].tolist(), strict=True))


def _metres(polygon_cm: PolygonCm) -> list[tuple[float, float]]:
    return [(east / 100, north / 100) for east, north in polygon_cm]
