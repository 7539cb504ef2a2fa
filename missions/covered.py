"""How much of an area a team sees from where it stays: what a coverage mission is for."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.mission.tasks import CoverTask


def covers(plan: MissionPlan) -> bool:
    """Whether the mission's task is to cover rather than to explore."""
    return isinstance(plan.mission.task, CoverTask)


def covered_fraction(plan: MissionPlan, elevation_m: FloatArray, places_enu_m: Mapping[str, Point]) -> float:
    """Share of the area's cells in sight of at least one vehicle (the team's sum of Renzaglia eq. 1, normalised).

    Parameters
    ----------
    elevation_m : (columns, rows) float64, the true surface, ENU z.
    places_enu_m : where each vehicle was last at work, by name.
    """
    from vehicle_agent.domain.sensing import view  # loads numba: only where something was covered

    seen = np.zeros(plan.grid.shape, dtype=np.bool_)
    for vehicle in plan.mission.vehicles:
        if vehicle.name in places_enu_m:
            seen |= view(plan.grid, elevation_m, places_enu_m[vehicle.name], vehicle.sensor.range_m)
    return float(np.count_nonzero(seen & plan.area_cells)) / int(np.count_nonzero(plan.area_cells))
