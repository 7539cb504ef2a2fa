"""What is at the cursor: place, ground, who saw it first and when, and what stands there."""

from __future__ import annotations

import math

from ground_station.picture import FleetState
from ground_station.text import duration
from ground_station.views import palette
from ground_station.views.ink import Line, Look, line_of
from vehicle_agent.domain.elevation import UNOBSERVED_STAMP_MS


def cursor_lines(state: FleetState, place_en_m: tuple[float, float], width: int, height: int, look: Look) -> list[Line]:
    """At most `height` lines about a place of the mission's plane."""
    quiet, strong = look.ink(palette.QUIET), look.ink(palette.ACCENT, bold=True)
    east_m, north_m = place_en_m
    grid, elevation = state.plan.grid, state.team_map.elevation
    cell = grid.cell_of(east_m, north_m)
    seen = grid.contains(east_m, north_m) and elevation.first_stamp_ms[cell] != UNOBSERVED_STAMP_MS
    up_m = float(elevation.elevation_dm[cell]) / 10 if seen else 0.0
    geodetic = state.plan.datum.to_geodetic((east_m, north_m, up_m))
    lines = [line_of((f"{geodetic.latitude_deg:.5f} {geodetic.longitude_deg:.5f}", strong))]
    ground = f"ground {geodetic.altitude_amsl_m:.0f} m amsl" if seen else "not seen yet"
    lines.append(line_of((f"E {east_m:.0f} N {north_m:.0f} m  ", quiet), ground))
    if seen:
        bits = int(elevation.observers[cell])
        names = [vehicle.name for vehicle in state.vehicles if bits >> vehicle.index & 1]
        when_s = max(0.0, (int(elevation.first_stamp_ms[cell]) - state.started_ms) / 1_000)
        lines.append(line_of((f"first seen {duration(when_s)} by ", quiet), ", ".join(names)))
    lines.append(line_of((_nearest(state, place_en_m), quiet)))
    return [line for line in lines[:height] if width > 0]


def _nearest(state: FleetState, place_en_m: tuple[float, float]) -> str:
    """The vehicle that is nearest to a place, with its distance."""
    placed = [(vehicle.name, vehicle.position_enu_m) for vehicle in state.vehicles if vehicle.position_enu_m]
    if not placed:
        return ""
    name, position = min(placed, key=lambda one: math.dist(one[1][:2], place_en_m))
    return f"{name} {math.dist(position[:2], place_en_m):.0f} m away"
