"""What a mission file says, as types; every key documented here is a key of the TOML file."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from vehicle_agent.wire.messages import NAME_PATTERN

LINE_PATTERN = r"^[^\x00-\x1f\x7f-\x9f\u2028\u2029]*\Z"
ADDRESS_PATTERN = r"^([A-Za-z0-9][A-Za-z0-9.-]{0,252}|\[[0-9A-Fa-f:.]{2,45}\])\Z"
CONNECTION_PATTERN = r"^(udpin|udpout|tcpin|tcpout|udp|tcp|serial|serial_flowcontrol)://[!-~]{1,200}\Z"

Positive = Annotated[float, Meta(ge=0.001, le=1e6)]
NonNegative = Annotated[float, Meta(ge=0, le=1e6)]
Metres = Annotated[float, Meta(ge=-1e6, le=1e6)]
AltitudeM = Annotated[float, Meta(ge=-12_000, le=12_000)]
Port = Annotated[int, Meta(ge=1024, le=65535)]
Flow = Annotated[float, Meta(ge=-40, le=40)]
EastNorth = tuple[Metres, Metres]
LatitudeDeg = Annotated[float, Meta(ge=-90, le=90)]
LongitudeDeg = Annotated[float, Meta(ge=-180, le=180)]


class _Table(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A table of the mission file: unknown keys are errors."""


class DatumTable(_Table, frozen=True, kw_only=True):
    """Origin of the local frame.

    Attributes
    ----------
    latitude_deg, longitude_deg
        WGS 84.
    altitude_amsl_m
        Altitude at which local `up` is zero.
    """

    latitude_deg: Annotated[float, Meta(ge=-89, le=89)]
    longitude_deg: LongitudeDeg
    altitude_amsl_m: AltitudeM = 0.0


class AreaTable(_Table, frozen=True, kw_only=True):
    """The area of the mission, also its fence: exactly one of `rectangle_enu_m`, `polygon_enu_m`, `polygon_deg`.

    Attributes
    ----------
    cell_m
        Edge of a map cell.
    rectangle_enu_m
        West, south, east, north.
    polygon_enu_m
        Corners as [east, north] pairs, in order.
    polygon_deg
        Corners as [latitude, longitude] pairs, in order.
    fence_margin_m
        How far inside the area's border vehicles stay.
    up_m
        Lowest and highest local `up` of a map in three dimensions, of voxels with edges of `cell_m`; left out, the map
        is one of elevations. Missions in towns need it.
    """

    cell_m: Annotated[float, Meta(ge=0.01, le=1e5)]
    rectangle_enu_m: tuple[Metres, Metres, Metres, Metres] | None = None
    polygon_enu_m: Annotated[tuple[EastNorth, ...], Meta(min_length=3, max_length=500)] | None = None
    polygon_deg: Annotated[tuple[tuple[LatitudeDeg, LongitudeDeg], ...], Meta(min_length=3, max_length=500)] | None = (
        None
    )
    fence_margin_m: NonNegative = 0.0
    up_m: tuple[Metres, Metres] | None = None


class GridTerrain(_Table, frozen=True, kw_only=True, tag_field="kind", tag="grid"):
    """Measured terrain from an .npz file: `elevation_amsl_m` (columns, rows), `west_m`, `south_m`, `cell_m`.

    Attributes
    ----------
    file
        Path relative to the mission file.
    """

    file: Annotated[str, Meta(pattern=LINE_PATTERN, min_length=1, max_length=1000)]


class GaussianTerrain(_Table, frozen=True, kw_only=True, tag_field="kind", tag="gaussians"):
    """Hills drawn from the mission's seed.

    Attributes
    ----------
    peaks
        Number of Gaussians, centres uniform over the area.
    height_m
        Lowest and highest peak.
    sigma_m
        Standard deviation of each.
    """

    peaks: Annotated[int, Meta(ge=1, le=1000)]
    height_m: tuple[Annotated[float, Meta(ge=0, le=12_000)], Annotated[float, Meta(ge=0, le=12_000)]]
    sigma_m: Positive


class FlatTerrain(_Table, frozen=True, kw_only=True, tag_field="kind", tag="flat"):
    """Level ground.

    Attributes
    ----------
    elevation_amsl_m
        Height of the ground above mean sea level.
    """

    elevation_amsl_m: AltitudeM = 0.0


Share = Annotated[float, Meta(ge=0, le=1)]


class TownTerrain(_Table, frozen=True, kw_only=True, tag_field="kind", tag="town"):
    """Buildings on level ground at local `up` zero, along streets, some with overhangs, passages and bridges.

    Attributes
    ----------
    file
        Path of an .npz file, relative to the mission file, that holds `solid` (columns, rows, layers), true where
        something is, on the voxels of the area; left out, the town is drawn from the mission's seed.
    block_m
        From the middle of one street to that of the next.
    street_m
        Narrowest and widest street.
    height_m
        Lowest and highest building.
    overhang_share, passage_share, bridge_share
        Share of the buildings that have each.
    square_share
        Share of the blocks that stay empty, beside the one in the south-west.
    """

    file: Annotated[str, Meta(pattern=LINE_PATTERN, min_length=1, max_length=1000)] | None = None
    block_m: Positive = 30.0
    street_m: tuple[Positive, Positive] = (8.0, 12.0)
    height_m: tuple[Positive, Positive] = (6.0, 22.0)
    overhang_share: Share = 0.4
    passage_share: Share = 0.3
    bridge_share: Share = 0.25
    square_share: Share = 0.1


Terrain = GridTerrain | GaussianTerrain | FlatTerrain | TownTerrain

PlannerName = Literal["tours", "claims", "fcao", "cao", "closest-frontier", "greedy"]


class ExploreTask(_Table, frozen=True, kw_only=True, tag_field="kind", tag="explore"):
    """See the whole surface of the area once.

    Attributes
    ----------
    planner
        Who decides where to go next.
    step_m
        Longest way between two decisions (alpha in Renzaglia eq. 10).
    """

    planner: PlannerName = "tours"
    step_m: Annotated[float, Meta(ge=1, le=1e6)] = 100.0


CoverPlannerName = Literal["stations", "cao"]


class CoverTask(_Table, frozen=True, kw_only=True, tag_field="kind", tag="cover"):
    """Find the places from which the team sees most of the area at once, and stay there.

    Attributes
    ----------
    planner
        Who decides where to go next.
    step_m
        Longest way between two decisions (alpha_0 in Renzaglia eq. 11).
    hold_s
        Vehicle time that the team stays on its places, once all have settled, before it returns; it returns at
        `stop.time_limit_s` in any case.
    explore_first
        See `stop.observed_fraction` of the area before covering it.
    known_points_enu_m
        Points of the surface, [east, north, up], that are known beforehand; the team first spreads over them by a
        constrained Voronoi tessellation (Renzaglia section 5.1).
    """

    planner: CoverPlannerName = "stations"
    step_m: Annotated[float, Meta(ge=1, le=1e6)] = 100.0
    hold_s: Annotated[float, Meta(ge=1, le=1e6)] = 30.0
    explore_first: bool = False
    known_points_enu_m: Annotated[tuple[tuple[float, float, float], ...], Meta(max_length=10_000)] = ()


MapPlannerName = Literal["survey", "viewpoints"]


class MapTask(_Table, frozen=True, kw_only=True, tag_field="kind", tag="map"):
    """Estimate the height of a landmark in every cell of the area and draw the map from them (Kapoutsis 2015).

    Attributes
    ----------
    planner
        Who decides where to go next: `survey` sails lines and then where the map is least certain, `viewpoints` goes
        from one landmark that is not yet accurate to the next.
    step_m
        Longest way between two decisions.
    accurate_sd_m
        A landmark is accurately estimated when its standard deviation is at most this.
    attempts
        Measurements after which a landmark that is still not accurate is given up.
    capacity
        Landmarks in one packet to teammates.
    surfacing
        Come up for a position fix when the time that this takes is worth it; else only at the end.
    """

    planner: MapPlannerName = "survey"
    step_m: Annotated[float, Meta(ge=0.5, le=1e6)] = 20.0
    accurate_sd_m: Annotated[float, Meta(ge=0.001, le=100)] = 0.1
    attempts: Annotated[int, Meta(ge=1, le=10_000)] = 200
    capacity: Annotated[int, Meta(ge=1, le=4_000)] = 10
    surfacing: bool = True


Task = ExploreTask | CoverTask | MapTask


class RangeSensor(_Table, frozen=True, kw_only=True, tag_field="kind", tag="range"):
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


class SingleBeamSensor(_Table, frozen=True, kw_only=True, tag_field="kind", tag="single-beam"):
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


class HalfSphereSensor(_Table, frozen=True, kw_only=True, tag_field="kind", tag="half-sphere"):
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


class VehicleTable(_Table, frozen=True, kw_only=True):
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


FilePath = Annotated[str, Meta(min_length=1, max_length=400)]


class TlsTable(_Table, frozen=True, kw_only=True):
    """Mutual TLS between vehicles and stations: who has no certificate of the fleet's authority is not let in.

    Attributes
    ----------
    ca
        PEM certificate of the authority; paths count from the mission file's folder.
    certificate, key
        PEM files of each participant; `{name}` stands for the vehicle's name, or `station`.
    """

    ca: FilePath = "certificates/ca.pem"
    certificate: FilePath = "certificates/{name}.pem"
    key: FilePath = "certificates/{name}.key"


class RadioTable(_Table, frozen=True, kw_only=True):
    """The link between vehicles.

    Attributes
    ----------
    endpoint_host
        Address on which simulated fleets listen.
    zenoh_port
        First of the ports used: the simulator, then one per vehicle.
    rate_bytes_s
        Declared capacity of a vehicle's link per second of vehicle time; sending is paced below it.
    packet_bytes, packet_period_s
        An acoustic modem: all that a vehicle says goes into one packet of at most so many bytes per so many seconds of
        vehicle time, the most urgent first. Left out: no such limit.
    range_m, loss, delay_s
        Radio between vehicles in `missions simulate` (left out: unlimited, none, none).
    tls
        Certificates; left out, the link is not secured.
    """

    endpoint_host: Annotated[str, Meta(pattern=ADDRESS_PATTERN)] = "127.0.0.1"
    zenoh_port: Port = 7450
    rate_bytes_s: Annotated[float, Meta(ge=200, le=1e9)] = 16_000.0
    packet_bytes: Annotated[int, Meta(ge=160, le=60_000)] | None = None
    packet_period_s: Annotated[float, Meta(ge=0.2, le=600)] = 10.0
    range_m: Positive | None = None
    loss: Annotated[float, Meta(ge=0, lt=1)] = 0.0
    delay_s: Annotated[float, Meta(ge=0, le=60)] = 0.0
    tls: TlsTable | None = None


FaultName = Literal["gps-loss", "battery", "motor", "link-loss", "leak"]


class FaultTable(_Table, frozen=True, kw_only=True):
    """A fault that strikes a simulated vehicle by itself.

    Attributes
    ----------
    at_s
        Simulated seconds since the start.
    vehicle
        Name of the vehicle.
    fault
        No satellites, a battery cell fails, motors fail, no bytes in or out, water in the hull.
    for_s
        When it is over again; left out, it stays. A battery stays what it has become.
    """

    at_s: NonNegative
    vehicle: Annotated[str, Meta(pattern=NAME_PATTERN)]
    fault: FaultName
    for_s: Positive | None = None


class SimulationTable(_Table, frozen=True, kw_only=True):
    """How the built-in simulator runs; of no meaning to real vehicles.

    Attributes
    ----------
    speedup
        Simulated seconds per second.
    ready_after_s
        Simulated seconds from start until the autopilots accept arming; real ones need about 50.
    mavlink_port
        First of the MAVLink ports: vehicle n (from 0) listens on TCP and UDP `mavlink_port + 10 n`.
    endurance_s
        How long a full battery lasts hovering, or at full speed on or in the water.
    wind_m_s, gust_m_s
        Wind towards [east, north], and the standard deviation of its gusts.
    current_m_s
        Current of the water towards [east, north].
    water_level_m
        Local `up` of the water's surface, on which vessels float; the terrain is the ground beneath it.
    gps_noise_m
        Standard deviation of the position fixes, a slow wander.
    faults
        Drills: what goes wrong, when and where.
    """

    speedup: Annotated[float, Meta(ge=0.1, le=100)] = 1.0
    ready_after_s: Annotated[float, Meta(ge=0, le=600)] = 8.0
    mavlink_port: Port = 5760
    endurance_s: Annotated[float, Meta(ge=1, le=1e6)] = 2_400.0
    wind_m_s: tuple[Flow, Flow] = (0.0, 0.0)
    gust_m_s: Annotated[float, Meta(ge=0, le=30)] = 0.0
    current_m_s: tuple[Flow, Flow] = (0.0, 0.0)
    water_level_m: Metres = 0.0
    gps_noise_m: Annotated[float, Meta(ge=0, le=100)] = 0.0
    faults: Annotated[tuple[FaultTable, ...], Meta(max_length=1000)] = ()


class StopTable(_Table, frozen=True, kw_only=True):
    """When the mission ends and the vehicles return.

    Attributes
    ----------
    observed_fraction
        Share of the area's cells seen; a team that covers goes on after that.
    time_limit_s
        Vehicle time from the first take-off.
    battery_reserve
        Share of charge with which a vehicle wants to be home.
    """

    observed_fraction: Annotated[float, Meta(gt=0, le=1)] = 1.0
    time_limit_s: Annotated[float, Meta(ge=1, le=1e6)] = 3_600.0
    battery_reserve: Annotated[float, Meta(ge=0, lt=1)] = 0.15


class SafetyTable(_Table, frozen=True, kw_only=True):
    """Distances that planning keeps.

    Attributes
    ----------
    separation_m
        Between any two vehicles.
    teammate_silence_s
        Vehicle time without a status after which a teammate counts as lost.
    """

    separation_m: Positive = 20.0
    teammate_silence_s: Annotated[float, Meta(ge=1, le=3600)] = 15.0


class ReplanTable(_Table, frozen=True, kw_only=True):
    """What the ground station does when the team changes.

    Attributes
    ----------
    mode
        `ask`: it proposes and the operator confirms; `auto`: it sends by itself; `off`: it leaves all to the agents.
    """

    mode: Literal["ask", "auto", "off"] = "ask"


class Mission(_Table, frozen=True, kw_only=True):
    """A whole mission file.

    Attributes
    ----------
    format
        Version of this format: 1.
    name
        Lower-case letters, digits and dashes.
    title
        One line for people.
    seed
        Seed of every random draw of the mission.
    datum
        Origin of the local frame.
    area
        What is to be explored, also the fence.
    terrain
        The ground that the simulator puts there; vehicles do not know it.
    task
        What the team does.
    vehicles
        The team, in order: the n-th vehicle's ids and ports follow from its place.
    radio
        The link between vehicles.
    simulation
        How the built-in simulator runs.
    stop
        When the mission ends.
    safety
        Distances and times that planning keeps.
    replan
        What the ground station does when the team changes.
    """

    format: Literal[1]
    name: Annotated[str, Meta(pattern=NAME_PATTERN)]
    title: Annotated[str, Meta(pattern=LINE_PATTERN, max_length=120)] = ""
    seed: Annotated[int, Meta(ge=0, le=2**32 - 1)] = 0
    datum: DatumTable
    area: AreaTable
    terrain: Terrain
    task: Task
    vehicles: Annotated[tuple[VehicleTable, ...], Meta(min_length=1, max_length=64)]
    radio: RadioTable = RadioTable()
    simulation: SimulationTable = SimulationTable()
    stop: StopTable = StopTable()
    safety: SafetyTable = SafetyTable()
    replan: ReplanTable = ReplanTable()
