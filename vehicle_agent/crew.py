"""The agent that a mission's task needs; each kind loads only where it is used."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from vehicle_agent.agent import VehicleAgent
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.mission.tasks import MapTask


def make_agent(
    plan: MissionPlan, index: int, boot_id: int, rng: np.random.Generator, journal_records: Iterable[bytes] = ()
) -> VehicleAgent:
    """Build one vehicle's agent; parameters as of `VehicleAgent`."""
    if isinstance(plan.mission.task, MapTask):
        from vehicle_agent.survey_agent import SurveyAgent

        return SurveyAgent(plan, index, boot_id, rng, journal_records)
    return VehicleAgent(plan, index, boot_id, rng, journal_records)


def warm_up(plan: MissionPlan) -> None:
    """Compile the kernels that a mission's agents need beyond those of every mission, before anything moves."""
    if plan.voxel_grid is not None:
        from vehicle_agent.domain import town_kernels

        town_kernels.warm_up()
    if isinstance(plan.mission.task, MapTask):
        from vehicle_agent.planning.mapping import kernels

        kernels.warm_up()
        if plan.mission.task.planner == "viewpoints":
            kernels.warm_up_viewpoints()
