"""What a vehicle that looks for a place to stay among buildings decides by."""

from __future__ import annotations

from dataclasses import dataclass

from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.planning.interface import Teammate
from vehicle_agent.planning.voxel_picture import VoxelPicture


@dataclass(frozen=True, slots=True)
class VoxelSituation:
    """What the vehicle knows at the moment of a decision.

    Attributes
    ----------
    picture
        What the team's map shows.
    allowed, wanted : (U, V) bool, columns where the vehicle may be, and of which the faces count.
    position_enu_m
        Where it is.
    teammates
        Where they are and where they mean to stay.
    periods
        Decisions that were due since the last one: more than one for a vehicle that is slow to decide.
    """

    picture: VoxelPicture
    allowed: BoolArray
    wanted: BoolArray
    position_enu_m: Point
    teammates: tuple[Teammate, ...]
    periods: int = 1
