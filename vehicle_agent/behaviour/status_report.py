"""What an agent's status says, within what the wire can carry."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from vehicle_agent.behaviour.guide import Guide
from vehicle_agent.behaviour.intent import Intent
from vehicle_agent.behaviour.leg import stopping_point
from vehicle_agent.behaviour.units import to_centimetres
from vehicle_agent.domain.frames import Point
from vehicle_agent.ports import VehicleState
from vehicle_agent.wire.messages import Stage

MAX_COUNT = 2**32 - 1
MAX_WHY = 160
MAX_PATH = 12
_STEERED = (Stage.WORKING, Stage.HOLDING, Stage.RETURNING, Stage.YIELDED)


@dataclass(frozen=True, slots=True)
class Figures:
    """What is counted: see `vehicle_agent.wire.messages.Status`."""

    known_fraction: float
    first_seen_cells: float
    bytes_sent: int
    messages_dropped: int


def status_fields(
    stage: Stage,
    state: VehicleState,
    navigator: Guide,
    home_enu_m: Point,
    take_off_height_m: float,
    return_height_m: float,
    figures: Figures,
    intent: Intent | None = None,
) -> dict[str, Any]:
    """The fields of a `Status` beyond its header.

    Parameters
    ----------
    take_off_height_m, return_height_m
        Above home: where a take-off ends, and where the autopilot returns by itself.
    intent
        What it means to fly next.
    """
    return {
        "stage": stage,
        "mode": state.mode.value,
        "armed": state.armed,
        "position_cm": to_centimetres(state.position_enu_m),
        "velocity_cm_s": to_centimetres(state.velocity_enu_m_s),
        "heading_deg": round(state.heading_deg) % 360,
        "battery_permille": -1 if state.battery_fraction is None else round(1000 * state.battery_fraction),
        "leg_end_cm": to_centimetres(_reserved_end(stage, state, navigator, home_enu_m, take_off_height_m)),
        "home_cm": to_centimetres(home_enu_m),
        "known_permille": int(1000 * figures.known_fraction),
        "first_seen_cells": round(figures.first_seen_cells),
        "bytes_sent": min(figures.bytes_sent, MAX_COUNT),
        "messages_dropped": min(figures.messages_dropped, MAX_COUNT),
        "why": (navigator.why if stage in _STEERED else stage.name.lower().replace("_", " "))[:MAX_WHY],
        "path_cm": tuple(to_centimetres(point) for point in navigator.waypoint.route_enu_m[:MAX_PATH])
        if navigator.waypoint
        else (),
        "return_up_cm": to_centimetres((0.0, 0.0, home_enu_m[2] + return_height_m))[2],
        "next_end_cm": None if intent is None else to_centimetres(intent.leg.end_enu_m),
        "next_told_ms": 0 if intent is None else min(max(0, state.stamp_ms - intent.since_ms), MAX_COUNT),
    }


def _reserved_end(
    stage: Stage,
    state: VehicleState,
    navigator: Guide,
    home_enu_m: Point,
    take_off_height_m: float,
) -> Point:
    """End of the leg that teammates should keep clear of; without a leg, where the vehicle would come to rest."""
    east_m, north_m, up_m = state.position_enu_m
    if stage in (Stage.ARMING, Stage.TAKING_OFF):
        return (home_enu_m[0], home_enu_m[1], home_enu_m[2] + take_off_height_m)
    if stage is Stage.LANDING:
        return (east_m, north_m, min(up_m, home_enu_m[2]))
    return navigator.leg.end_enu_m if navigator.leg else stopping_point(state)
