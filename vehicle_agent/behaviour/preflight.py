"""Before arming: the agent becomes the controller whose silence the autopilot takes for a failure, and sets limits."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.ports import ActionResult, SetParameter

ATTEMPTS = 4
CLIMB_ACCELERATION_M_S2 = 2.5
"""Brisker than ArduCopter's default of 1: over steep ground it is the climb that sets the pace."""
SUBMARINE_SILENCE_S = 20.0
"""Nothing falls out of the water: an agent that thinks for long need not bring its vehicle up."""
LEAST_LANE_M = 15.0
LANE_SEPARATIONS = 1.25
"""Vehicles that return by themselves do so at heights so much more than the separation apart."""


def return_height_m(plan: MissionPlan, index: int, highest_known_up_m: float, home_up_m: float) -> float:
    """Height above home at which a vehicle's own failsafe brings it home: above all ground that is known.

    In a town it is above where the team flies. Each vehicle has lanes of its own, the same in everybody's frame and so
    apart whatever each knows of the ground: as many as there are vehicles above each other, and again above those.
    """
    above_ground_m = plan.mission.vehicles[index].min_above_terrain_m
    if plan.voxel_grid is not None:
        highest_known_up_m = max(vehicle.max_above_terrain_m for vehicle in plan.mission.vehicles)
    lane_m = max(LEAST_LANE_M, LANE_SEPARATIONS * plan.mission.safety.separation_m)
    lowest_m = max(highest_known_up_m, home_up_m) + above_ground_m
    lanes = len(plan.mission.vehicles)
    rounds = math.ceil((lowest_m / lane_m - index) / lanes)
    return (rounds * lanes + index) * lane_m - home_up_m


def take_off_height_m(plan: MissionPlan, index: int) -> float:
    """Height above home at which a vehicle begins its work; in a town as high as it flies."""
    vehicle, voxels = plan.mission.vehicles[index], plan.voxel_grid
    if voxels is None:
        return vehicle.min_above_terrain_m * 1.1
    return voxels.centre_of(voxels.voxel_of((0.0, 0.0, vehicle.max_above_terrain_m)))[2]


def parameters_before_arming(plan: MissionPlan, index: int) -> tuple[SetParameter, ...]:
    """ArduCopter's names; the failsafe's timeout counts the vehicle's own seconds."""
    vehicle = plan.mission.vehicles[index]
    return (
        SetParameter("SYSID_MYGCS", float(plan.controller_system_id(index))),
        SetParameter("FS_GCS_ENABLE", 1.0),
        SetParameter("FS_GCS_TIMEOUT", 5.0),
        SetParameter("FS_OPTIONS", 0.0),  # else a held vehicle ignores its agent's death
        SetParameter("RTL_CONE_SLOPE", 0.0),  # else vehicles returning from nearby leave their own heights
        SetParameter("WPNAV_SPEED", vehicle.speed_m_s * 100.0),
        SetParameter("WPNAV_SPEED_UP", vehicle.climb_m_s * 100.0),
        SetParameter("WPNAV_SPEED_DN", vehicle.climb_m_s * 100.0),
        SetParameter("WPNAV_ACCEL_Z", CLIMB_ACCELERATION_M_S2 * 100.0),
        return_altitude(return_height_m(plan, index, 0.0, 0.0)),
    )


def submarine_parameters_before_arming(plan: MissionPlan, index: int) -> tuple[SetParameter, ...]:
    """ArduSub's names: it surfaces when its agent falls silent, when water comes in or when the battery is empty."""
    vehicle = plan.mission.vehicles[index]
    return (
        SetParameter("SYSID_MYGCS", float(plan.controller_system_id(index))),
        SetParameter("FS_GCS_ENABLE", 4.0),
        SetParameter("FS_GCS_TIMEOUT", SUBMARINE_SILENCE_S),
        SetParameter("FS_LEAK_ENABLE", 2.0),
        SetParameter("WPNAV_SPEED", vehicle.speed_m_s * 100.0),
        SetParameter("WPNAV_SPEED_UP", vehicle.climb_m_s * 100.0),
        SetParameter("WPNAV_SPEED_DN", vehicle.climb_m_s * 100.0),
    )


def return_altitude(height_m: float) -> SetParameter:
    return SetParameter("RTL_ALT", float(round(height_m * 100.0)))


@dataclass(slots=True)
class Checklist:
    """Sets parameters one after the other, each a few times.

    Attributes
    ----------
    failed
        Why it cannot be finished; empty while it can.
    """

    parameters: tuple[SetParameter, ...]
    failed: str = ""
    _next: int = 0
    _attempts: int = 0
    _waiting_for: int | None = field(default=None)

    @property
    def done(self) -> bool:
        return self._next >= len(self.parameters)

    def next_order(self) -> SetParameter | None:
        """The parameter to set now; None while an answer is awaited, or at the end."""
        if self.done or self.failed or self._waiting_for is not None:
            return None
        return self.parameters[self._next]

    def submitted(self, action_id: int) -> None:
        self._waiting_for = action_id

    def hear(self, result: ActionResult) -> None:
        """Take a result; those of other actions are ignored."""
        if result.action_id != self._waiting_for:
            return
        self._waiting_for = None
        if result.accepted:
            self._next, self._attempts = self._next + 1, 0
            return
        self._attempts += 1
        if self._attempts >= ATTEMPTS:
            name = self.parameters[self._next].name
            self.failed = f"autopilot does not take parameter {name}: {result.text or 'no answer'}"
