"""Which autopilot and which kind of vehicle a mission's table asks for."""

from __future__ import annotations

from sim_bridge.battery import Battery
from sim_bridge.clock import SimClock
from sim_bridge.dynamics import Bodies, BodyKind
from sim_bridge.parameters import ParameterTable
from sim_bridge.personalities.ardupilot_copter import ARDUCOPTER
from sim_bridge.personalities.ardupilot_rover import ARDUROVER
from sim_bridge.personalities.ardupilot_sub import ARDUSUB
from sim_bridge.personalities.px4 import PX4
from sim_bridge.personality import Personality
from sim_bridge.vehicle import Vehicle
from sim_bridge.vehicles.boat import Boat
from sim_bridge.vehicles.copter import Copter
from sim_bridge.vehicles.submarine import Submarine
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.mission.vehicles import SingleBeamSensor, VehicleTable

KINDS: dict[str, tuple[BodyKind, type[Vehicle]]] = {
    "multicopter": (BodyKind.MULTICOPTER, Copter),
    "surface-vessel": (BodyKind.SURFACE_VESSEL, Boat),
    "underwater-vehicle": (BodyKind.UNDERWATER, Submarine),
}
RANGEFINDER_MAVLINK = 10
"""RNGFND1_TYPE of a beam that some other computer measures with."""
PERSONALITIES: dict[tuple[str, str], Personality] = {
    ("ardupilot", "multicopter"): ARDUCOPTER,
    ("ardupilot", "surface-vessel"): ARDUROVER,
    ("ardupilot", "underwater-vehicle"): ARDUSUB,
    ("px4", "multicopter"): PX4,
}


def personality_of(table: VehicleTable) -> Personality:
    """The autopilot of a vehicle; the mission's check has made sure that there is one."""
    return PERSONALITIES[table.autopilot, table.type]


def new_vehicle(plan: MissionPlan, index: int, bodies: Bodies, clock: SimClock) -> Vehicle:
    """Build a vehicle as it comes out of its box, at the start of its autopilot."""
    simulation = plan.mission.simulation
    table = plan.mission.vehicles[index]
    personality = personality_of(table)
    parameters = ParameterTable(
        personality.parameters,
        {personality.system_id_parameter: float(plan.system_id(index)), **_beam_parameters(table)},
    )
    vehicle_class = KINDS[table.type][1]
    return vehicle_class(
        index,
        bodies,
        clock,
        personality,
        parameters,
        Battery(simulation.endurance_s),
        simulation.ready_after_s,
        plan.datum,
    )


def _beam_parameters(table: VehicleTable) -> dict[str, float]:
    """How ArduPilot's first rangefinder is set for the beam that a vehicle carries."""
    if not isinstance(table.sensor, SingleBeamSensor):
        return {}
    return {
        "RNGFND1_TYPE": RANGEFINDER_MAVLINK,
        "RNGFND1_MIN_CM": round(table.sensor.min_range_m * 100.0),
        "RNGFND1_MAX_CM": round(table.sensor.range_m * 100.0),
    }


def body_kind(table: VehicleTable) -> BodyKind:
    return KINDS[table.type][0]


__all__ = ["KINDS", "PERSONALITIES", "body_kind", "new_vehicle", "personality_of"]
