"""What a mission is measured by: the surface that can be observed at all, and maps of the kind that its team makes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import numpy.typing as npt

from vehicle_agent.domain.elevation import ElevationMap
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.team_map import TeamMap
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.mission.tasks import MapTask

if TYPE_CHECKING:
    from sim_bridge.world import World

Map = TypeVar("Map", bound=TeamMap)


def observable(plan: MissionPlan, world: World) -> BoolArray:
    """Surface that the team can see at all: cells, (columns, rows), or in a town voxels, (columns, rows, layers)."""
    if world.town is not None:
        from sim_bridge.observable import observable_surface  # its kernels load only where there is a town

        return observable_surface(plan, world.town)
    if isinstance(plan.mission.task, MapTask):
        from sim_bridge.soundable import soundable_cells

        return soundable_cells(plan, world)
    from sim_bridge.reach import reachable_cells

    return reachable_cells(plan, world)


def map_of_arrays(plan: MissionPlan, arrays: Mapping[str, npt.NDArray[Any]]) -> TeamMap:
    """A team's map from its arrays; KeyError or ValueError when they are not those of this mission's kind of map."""
    if (voxels := plan.voxel_grid) is not None:
        from vehicle_agent.domain.voxels import VoxelMap

        return VoxelMap.of_arrays(voxels, arrays)
    if isinstance(plan.mission.task, MapTask):
        from vehicle_agent.domain.landmark_atlas import LandmarkAtlas
        from vehicle_agent.mission.sounding import landmark_params

        return LandmarkAtlas.of_arrays(plan.grid, landmark_params(plan), len(plan.mission.vehicles), arrays)
    return ElevationMap.of_arrays(plan.grid, arrays)


def merged(maps: Iterable[Map]) -> Map:
    """One map of several of the same kind; at least one."""
    first, *others = maps
    joined = first.copy()
    for other in others:
        joined.merge(other)
    return joined


def share_seen(observed: BoolArray, surface: BoolArray) -> float:
    """Share of the surface that is among what was observed."""
    return int(np.count_nonzero(observed & surface)) / max(1, int(np.count_nonzero(surface)))


def unseen_words(plan: MissionPlan, observed: BoolArray, surface: BoolArray) -> str:
    """What of the area was not observed, in words; empty when all of it was.

    Parameters
    ----------
    observed, surface : what was observed, and what of the surface can be, as of `observable`.
    """
    unit = "cells" if surface.ndim == 2 else "voxels"
    missed = surface & ~observed
    words = [f"{np.count_nonzero(missed)} {unit} that could be seen, most around {_middle(plan, missed)}"]
    if not missed.any():
        words = ["everything observable was observed"]
    hidden = plan.area_cells & ~surface & ~observed if surface.ndim == 2 else np.zeros(1, dtype=np.bool_)
    if hidden.any():
        count = np.count_nonzero(hidden)
        words.append(f"{count} cells of the area lie where this team cannot look, most around {_middle(plan, hidden)}")
    return "; ".join(words) if missed.any() or hidden.any() else ""


def _middle(plan: MissionPlan, chosen: BoolArray) -> str:
    if not chosen.any():
        return "nowhere"
    column, row = (int(np.median(places)) for places in np.nonzero(chosen)[:2])
    east_m, north_m = plan.grid.centre_of(column, row)
    return f"E {east_m:.0f} N {north_m:.0f} m"
