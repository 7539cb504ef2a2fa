"""Teams of other vehicles than copters, for tests of the simulator."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sim_bridge.fleet import Fleet
from sim_bridge.vehicle import Vehicle
from sim_bridge.world import World
from tests.fakes.sim_missions import sim_plan

SEA_FLOOR_M = -40.0


def member(name: str, **changes: Any) -> dict[str, Any]:
    """A vehicle's table; where it starts is up to its place in the team."""
    return {
        "name": name,
        "speed_m_s": 5.0,
        "sensor": {"kind": "range", "range_m": 200.0},
        "min_above_terrain_m": 5.0,
        "max_above_terrain_m": 150.0,
        **changes,
    }


def sea_fleet(*members: dict[str, Any], **simulation: Any) -> Fleet:
    """A fleet over a sea floor 40 m below the water, whose surface lies at local up 0; ready after 5 s."""
    team = [{"start_enu_m": [200.0 + 40.0 * number, 200.0], **table} for number, table in enumerate(members)]
    plan = sim_plan(
        team=team,
        datum={"latitude_deg": 41.18, "longitude_deg": -8.7},
        terrain={"kind": "flat", "elevation_amsl_m": SEA_FLOOR_M},
        simulation={"ready_after_s": 5.0, **simulation},
    )
    return Fleet(plan, World.of(plan))


def boat_fleet(**simulation: Any) -> Fleet:
    return sea_fleet(member("tern", type="surface-vessel"), **simulation)


def submarine_fleet(**simulation: Any) -> Fleet:
    return sea_fleet(member("seal", type="underwater-vehicle"), **simulation)


def px4_fleet(**simulation: Any) -> Fleet:
    return sea_fleet(member("gull", autopilot="px4"), **simulation)


def until(fleet: Fleet, condition: Callable[[Vehicle], bool], limit_s: float = 600.0) -> None:
    """Let time pass until vehicle 0 satisfies the condition."""
    end_s = fleet.time_s + limit_s
    while not condition(fleet.vehicles[0]):
        assert fleet.time_s < end_s, "it never came about"
        fleet.step(0.2)


def armed(fleet: Fleet) -> Vehicle:
    """Vehicle 0, armed in guided flight."""
    vehicle = fleet.vehicles[0]
    until(fleet, lambda v: v.ready_to_arm)
    assert vehicle.arm().accepted
    return vehicle


def texts(vehicle: Vehicle) -> list[str]:
    return [status.text for status in vehicle.drain_texts()]
