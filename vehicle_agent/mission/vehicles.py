"""The vehicles of a mission, and the sensors that they carry."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta

from vehicle_agent.mission.tables import Metres, Positive, Table
from vehicle_agent.wire.messages import NAME_PATTERN

CONNECTION_PATTERN = r"^(udpin|udpout|tcpin|tcpout|udp|tcp|serial|serial_flowcontrol)://[!-~]{1,200}\Z"


class RangeSensor(Table, frozen=True, kw_only=True, tag_field="kind", tag="range"):
    """Sees every surface cell in line of sight within its range, in all directions (Renzaglia section 3).

    Attributes
    ----------
    range_m
        How far it sees.
    period_s
        Vehicle time between two scans.
    """

    range_m: Positive
    period_s: Annotated[float, Meta(ge=0.05, le=3600)] = 1.0


class SingleBeamSensor(Table, frozen=True, kw_only=True, tag_field="kind", tag="single-beam"):
    """Measures the distance straight down from its body: an echo sounder under water, a rangefinder in the air.

    The autopilot tells it in DISTANCE_SENSOR, as its RNGFND1 parameters have it.

    Attributes
    ----------
    range_m
        How far it measures.
    min_range_m
        Nearer than this it measures nothing.
    noise_fraction
        Standard deviation of a reading as a share of the distance (Kapoutsis 2015, eq. 24).
    period_s
        Vehicle time between two readings.
    """

    range_m: Annotated[float, Meta(ge=0.1, le=327)]
    min_range_m: Annotated[float, Meta(ge=0, le=100)] = 0.3
    noise_fraction: Annotated[float, Meta(ge=0, le=1)] = 0.0
    period_s: Annotated[float, Meta(ge=0.05, le=3600)] = 0.25


class HalfSphereSensor(Table, frozen=True, kw_only=True, tag_field="kind", tag="half-sphere"):
    """Measures distances along rays to all sides and downwards, never upwards (Renzaglia section 7.1).

    Attributes
    ----------
    range_m
        How far it sees.
    period_s
        Vehicle time between two scans.
    """

    range_m: Positive
    period_s: Annotated[float, Meta(ge=0.05, le=3600)] = 1.0


Sensor = RangeSensor | SingleBeamSensor | HalfSphereSensor


class VehicleTable(Table, frozen=True, kw_only=True):
    """One vehicle.

    Attributes
    ----------
    name
        Lower-case letters, digits and dashes; unique in the team.
    type
        What body it has; multicopters explore and cover, underwater vehicles map, `sim-bridge` serves every type.
    autopilot
        What the simulated vehicle speaks like; `px4` only as a multicopter.
    start_enu_m
        Where it stands: [east, north], or [east, north, up] with `up` not below the ground. Vessels and underwater
        vehicles start at `simulation.water_level_m`.
    speed_m_s
        Fastest it flies.
    climb_m_s
        Fastest it climbs and sinks.
    sensor
        What it sees with.
    min_above_terrain_m, max_above_terrain_m
        Height band above the ground that it keeps; in towns above local `up` zero, and the air above the band is taken
        to be clear.
    depth_m
        Depth below `simulation.water_level_m` that an underwater vehicle keeps while it maps.
    system_id
        MAVLink system id of its autopilot; the n-th vehicle has n when left out.
    connection
        MAVSDK connection URL of a real autopilot; left out, the vehicle is simulated.
    """

    name: Annotated[str, Meta(pattern=NAME_PATTERN)]
    type: Literal["multicopter", "surface-vessel", "underwater-vehicle"] = "multicopter"
    autopilot: Literal["ardupilot", "px4"] = "ardupilot"
    start_enu_m: Annotated[tuple[Metres, ...], Meta(min_length=2, max_length=3)]
    speed_m_s: Annotated[float, Meta(ge=0.1, le=100)]
    climb_m_s: Annotated[float, Meta(ge=0.1, le=50)] = 5.0
    sensor: Sensor
    min_above_terrain_m: Positive
    max_above_terrain_m: Positive
    depth_m: Annotated[float, Meta(ge=1.0, le=11_000)] | None = None
    system_id: Annotated[int, Meta(ge=1, le=99)] | None = None
    connection: Annotated[str, Meta(pattern=CONNECTION_PATTERN)] | None = None
