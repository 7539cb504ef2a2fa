"""Where autopilots fly when their agents die: straight home, whatever zones the operator has drawn."""

from __future__ import annotations

import numpy as np

from ground_station.picture import FleetState
from ground_station.vehicle_picture import Condition, VehiclePicture
from vehicle_agent.domain.polygon import points_inside
from vehicle_agent.wire.messages import PolygonCm

STEPS = 200


def straight_home_through(state: FleetState, polygon_cm: PolygonCm) -> tuple[str, ...]:
    """Names of the vehicles in the air whose straight way home passes through a polygon."""
    if len(polygon_cm) < 3:
        return ()
    corners_en_m = np.array(polygon_cm, dtype=np.float64) / 100
    return tuple(vehicle.name for vehicle in state.vehicles if _passes(vehicle, corners_en_m))


def _passes(vehicle: VehiclePicture, corners_en_m: np.ndarray[tuple[int, int], np.dtype[np.float64]]) -> bool:
    status = vehicle.status
    if status is None or not status.armed or vehicle.condition is Condition.LEFT:
        return False
    here, home = (np.array(place_cm[:2], dtype=np.float64) / 100 for place_cm in (status.position_cm, status.home_cm))
    way = here + np.linspace(0.0, 1.0, STEPS)[:, None] * (home - here)
    return bool(points_inside(way, corners_en_m).any())
