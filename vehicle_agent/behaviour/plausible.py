"""What an agent believes of its autopilot's words: a state without a usable position is no state."""

from __future__ import annotations

import math
from dataclasses import replace

from vehicle_agent.domain.frames import Point
from vehicle_agent.ports import VehicleState

FARTHEST_M = 1e6
LATEST_STAMP_MS = 2**53


def plausible(state: VehicleState) -> VehicleState | None:
    """The state with what is unusable left out; None when its position, its velocity or its stamp is unusable."""
    if not (_is_near(state.position_enu_m) and _is_near(state.velocity_enu_m_s)):
        return None
    if not 0 <= state.stamp_ms <= LATEST_STAMP_MS:
        return None
    battery, home = state.battery_fraction, state.home_enu_m
    return replace(
        state,
        heading_deg=state.heading_deg % 360.0 if math.isfinite(state.heading_deg) else 0.0,
        battery_fraction=min(battery, 1.0) if battery is not None and battery >= 0.0 else None,
        home_enu_m=home if home is not None and _is_near(home) else None,
    )


def _is_near(point: Point) -> bool:
    return all(abs(coordinate) <= FARTHEST_M for coordinate in point)
