"""What a mapping mission's echo sounders measure, and what of it can be believed."""

from __future__ import annotations

from vehicle_agent.domain.landmark_layout import LandmarkParams
from vehicle_agent.domain.range_sensing import RangeSensor
from vehicle_agent.mission.plan import MissionPlan
from vehicle_agent.mission.tasks import MapTask
from vehicle_agent.mission.vehicles import SingleBeamSensor

TYPICAL_SLOPE = 0.1
"""Rise over run of the surface by which an error of position becomes one of height."""
DRIFT_M_S = 0.03
"""Growth of the position's error without a fix: reckoning with a Doppler log."""


def beam_of(plan: MissionPlan, index: int) -> RangeSensor:
    """A vehicle's echo sounder as the estimator sees it: noise (Kapoutsis 2015, eq. 4), footprint of half a cell."""
    sensor = plan.mission.vehicles[index].sensor
    assert isinstance(sensor, SingleBeamSensor)
    return RangeSensor(
        sensor.range_m, sensor.noise_fraction, 0.5 * plan.grid.cell_m, drift_m_per_s=DRIFT_M_S * TYPICAL_SLOPE
    )


def landmark_params(plan: MissionPlan) -> LandmarkParams:
    """What the mission calls accurate, and what its sensors can tell at best."""
    task, vehicles = plan.mission.task, plan.mission.vehicles
    assert isinstance(task, MapTask)
    surface_m = plan.mission.simulation.water_level_m
    return LandmarkParams(
        accurate_sd_m=task.accurate_sd_m,
        best_sd_m=min(
            beam_of(plan, index).best_sd_m(vehicle.min_above_terrain_m) for index, vehicle in enumerate(vehicles)
        ),
        lowest_m=surface_m - max((vehicle.depth_m or 0.0) + vehicle.sensor.range_m for vehicle in vehicles) - 1.0,
        highest_m=surface_m + 1.0,
        attempts_limit=task.attempts,
    )
