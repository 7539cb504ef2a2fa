"""The planner that a mapping mission names."""

from __future__ import annotations

from vehicle_agent.mission.plan import MissionPlan
from vehicle_agent.mission.tasks import MapTask
from vehicle_agent.planning.mapping.interface import MappingPlanner
from vehicle_agent.planning.mapping.survey import Survey, SurveyParams, SurveyPlanner
from vehicle_agent.planning.mapping.survey_lines import Box

UNDER_WAY_SHARE = 0.7
"""Of the time limit, until it shows; the rest goes to turns and to fixes at the surface."""

ASTRAY_M = 2.0
"""So much farther inside, since a vehicle under water does not quite know where it is."""


def make_mapping_planner(plan: MissionPlan, index: int) -> MappingPlanner:
    """Build the planner of a mapping mission for one vehicle."""
    mission = plan.mission
    task, vehicles = mission.task, len(mission.vehicles)
    assert isinstance(task, MapTask)
    match task.planner:
        case "survey":
            grid, margin_m = plan.grid, mission.area.fence_margin_m
            box = Box(grid.west_m + margin_m, grid.south_m + margin_m, grid.east_m - margin_m, grid.north_m - margin_m)
            way_m = UNDER_WAY_SHARE * mission.vehicles[index].speed_m_s * mission.stop.time_limit_s
            return SurveyPlanner(
                Survey(box, index, vehicles, SurveyParams(way_m, time_s=mission.stop.time_limit_s, inside_m=ASTRAY_M))
            )
        case "viewpoints":
            from vehicle_agent.planning.mapping.default import ViewpointPlanner  # its kernels load only where used

            return ViewpointPlanner(vehicles)


def urgent_within_m(task: MapTask) -> float:
    """Distance from where a teammate is or goes at which what it is told is 1/e as urgent: its next leg's."""
    return task.step_m
