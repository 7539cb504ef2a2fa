"""Which cells of an area vehicles that keep their depths can sound: what a mapping mission is measured by."""

from __future__ import annotations

import numpy as np

from sim_bridge.world import World
from vehicle_agent.domain.polygon import BoolArray, distance_to_border_m
from vehicle_agent.mission.load import MissionError, MissionPlan
from vehicle_agent.mission.vehicles import SingleBeamSensor


def soundable_cells(plan: MissionPlan, world: World) -> BoolArray:
    """Cells whose floor some vehicle can sail over and sound from its depth: (columns, rows) bool.

    Raises MissionError when a vehicle sees nothing of the floor from its depth.
    """
    grid, mission = plan.grid, plan.mission
    centres = grid.centres_of(np.arange(grid.cells, dtype=np.int64))
    # Cells along the fence are sounded in passing: their nearest edge counts.
    far_enough = distance_to_border_m(centres, plan.fence_en_m) >= mission.area.fence_margin_m - 0.5 * grid.cell_m
    sailed = plan.area_cells & far_enough.reshape(grid.shape)
    soundable = np.zeros(grid.shape, dtype=np.bool_)
    for index, vehicle in enumerate(mission.vehicles):
        above_m = mission.simulation.water_level_m - (vehicle.depth_m or 0.0) - world.elevation_m
        sensor = vehicle.sensor
        nearest_m = sensor.min_range_m if isinstance(sensor, SingleBeamSensor) else 0.0
        seen = sailed & (above_m >= max(nearest_m, vehicle.min_above_terrain_m)) & (above_m <= sensor.range_m)
        if not seen.any():
            raise MissionError(
                f"{plan.source}: vehicles[{index}].sensor.range_m: from {vehicle.depth_m:g} m deep it sees nothing of "
                f"the floor, which lies {above_m[sailed].min():.1f} to {above_m[sailed].max():.1f} m below; give it a "
                "longer range, or let it dive deeper or less deep"
            )
        soundable |= seen
    return soundable
