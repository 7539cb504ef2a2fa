"""What a mission file says, as types; every key documented here is a key of the TOML file."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta

from vehicle_agent.mission.tables import LINE_PATTERN, AltitudeM, Metres, NonNegative, Positive, Table
from vehicle_agent.mission.tasks import Task
from vehicle_agent.mission.terrain import Terrain
from vehicle_agent.mission.vehicles import VehicleTable
from vehicle_agent.wire.messages import NAME_PATTERN

ADDRESS_PATTERN = r"^([A-Za-z0-9][A-Za-z0-9.-]{0,252}|\[[0-9A-Fa-f:.]{2,45}\])\Z"
Port = Annotated[int, Meta(ge=1024, le=65535)]
Flow = Annotated[float, Meta(ge=-40, le=40)]
EastNorth = tuple[Metres, Metres]
LatitudeDeg = Annotated[float, Meta(ge=-90, le=90)]
LongitudeDeg = Annotated[float, Meta(ge=-180, le=180)]


class DatumTable(Table, frozen=True, kw_only=True):
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


class AreaTable(Table, frozen=True, kw_only=True):
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


FilePath = Annotated[str, Meta(min_length=1, max_length=400)]


class TlsTable(Table, frozen=True, kw_only=True):
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


class RadioTable(Table, frozen=True, kw_only=True):
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
        Radio between simulated vehicles (left out: unlimited, none, none); one with a `connection` has its own.
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


class FaultTable(Table, frozen=True, kw_only=True):
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


class SimulationTable(Table, frozen=True, kw_only=True):
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


class StopTable(Table, frozen=True, kw_only=True):
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


class SafetyTable(Table, frozen=True, kw_only=True):
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


class ReplanTable(Table, frozen=True, kw_only=True):
    """What the ground station does when the team changes.

    Attributes
    ----------
    mode
        `ask`: it proposes and the operator confirms; `auto`: it sends by itself; `off`: it leaves all to the agents.
    """

    mode: Literal["ask", "auto", "off"] = "ask"


class Mission(Table, frozen=True, kw_only=True):
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
