"""Missions that run, and the tools that run them: a small Python API. The heavy parts load when first used.

Example
-------
::

    import missions

    plan = missions.load_mission("ridge")
    result = missions.simulate(plan)
    print(result.summary())
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from missions.catalogue import built_in_missions as built_in_missions
    from missions.catalogue import load_named_mission as load_mission
    from missions.lockstep import LockstepResult as LockstepResult
    from missions.lockstep import simulate as simulate
    from missions.summary import Summary as Summary
    from missions.summary import read_summary as read_summary
    from sim_bridge.reach import reachable_cells as reachable_cells
    from sim_bridge.world import World as World
    from vehicle_agent.mission.load import MissionError as MissionError
    from vehicle_agent.mission.load import MissionPlan as MissionPlan
    from vehicle_agent.mission.load import plan_mission as plan_mission
    from vehicle_agent.mission.model import Mission as Mission

_HOMES = {
    "LockstepResult": "missions.lockstep:LockstepResult",
    "Mission": "vehicle_agent.mission.model:Mission",
    "MissionError": "vehicle_agent.mission.load:MissionError",
    "MissionPlan": "vehicle_agent.mission.load:MissionPlan",
    "Summary": "missions.summary:Summary",
    "World": "sim_bridge.world:World",
    "built_in_missions": "missions.catalogue:built_in_missions",
    "load_mission": "missions.catalogue:load_named_mission",
    "plan_mission": "vehicle_agent.mission.load:plan_mission",
    "reachable_cells": "sim_bridge.reach:reachable_cells",
    "read_summary": "missions.summary:read_summary",
    "simulate": "missions.lockstep:simulate",
}

__all__ = [
    "LockstepResult",
    "Mission",
    "MissionError",
    "MissionPlan",
    "Summary",
    "World",
    "built_in_missions",
    "load_mission",
    "plan_mission",
    "reachable_cells",
    "read_summary",
    "simulate",
]


def __getattr__(name: str) -> Any:
    if (home := _HOMES.get(name)) is None:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    module, _, attribute = home.partition(":")
    return getattr(importlib.import_module(module), attribute)


def __dir__() -> list[str]:
    return __all__
