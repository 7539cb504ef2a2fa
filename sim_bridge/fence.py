"""A vehicle's own geofence: heights and a circle from its parameters, polygons and circles that were uploaded."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from sim_bridge.personality import FenceSettings
from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.polygon import points_inside


@dataclass(frozen=True, slots=True)
class CircleZone:
    """A disc to stay in or to keep out of."""

    inclusive: bool
    east_m: float
    north_m: float
    radius_m: float

    def breached(self, east_m: float, north_m: float) -> bool:
        inside = math.hypot(east_m - self.east_m, north_m - self.north_m) <= self.radius_m
        return inside is not self.inclusive


@dataclass(frozen=True, slots=True)
class PolygonZone:
    """A polygon to stay in or to keep out of; `corners_en_m` is (V, 2) float64, ENU metres."""

    inclusive: bool
    corners_en_m: FloatArray = field(repr=False)

    def breached(self, east_m: float, north_m: float) -> bool:
        return bool(points_inside(np.array([[east_m, north_m]]), self.corners_en_m)[0]) is not self.inclusive


Zone = CircleZone | PolygonZone


def breached_part(
    position_enu_m: Point, home_enu_m: Point, settings: FenceSettings, zones: tuple[Zone, ...]
) -> str | None:
    """ArduPilot's name of the first part of the fence that a position breaches, None when it keeps all of it.

    Every inclusion has to be kept, as ArduPilot has it by default.
    """
    east_m, north_m, up_m = position_enu_m
    height_m = up_m - home_enu_m[2]
    if settings.highest_m is not None and height_m > settings.highest_m:
        return "Max Alt"
    if settings.lowest_m is not None and height_m < settings.lowest_m:
        return "Min Alt"
    if (
        settings.radius_m is not None
        and math.hypot(east_m - home_enu_m[0], north_m - home_enu_m[1]) > settings.radius_m
    ):
        return "Circle"
    if settings.zones and any(zone.breached(east_m, north_m) for zone in zones):
        return "Polygon"
    return None
