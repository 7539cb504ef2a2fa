"""What a planner of map missions is asked with."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.landmarks import LandmarkMap
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.range_sensing import RangeSensor
from vehicle_agent.planning.interface import Decision, Teammate


@dataclass(frozen=True, slots=True)
class HeightBand:
    """How high a vehicle may be.

    Attributes
    ----------
    clearance_m
        Least height above the surface (d of section 6).
    highest_m
        ENU z of the ceiling (z_max).
    lowest_m
        ENU z of the floor; equal to `highest_m` for a vehicle that keeps one depth.
    """

    clearance_m: float
    highest_m: float
    lowest_m: float = -math.inf

    def __post_init__(self) -> None:
        if not self.lowest_m <= self.highest_m:
            raise ValueError("lowest_m must not be above highest_m")
        if not self.clearance_m >= 0:
            raise ValueError("clearance_m must not be negative")


@dataclass(frozen=True, slots=True)
class MappingSituation:
    """What one vehicle knows when it decides.

    Attributes
    ----------
    index
        Its team index.
    position_enu_m
        Where it is.
    landmarks
        Everything that it measured or was told; not to be changed by planners.
    sensor
        Its sensor.
    band
        How high it may be.
    reach_m
        Longest leg.
    admissible
        The constraints C (eq. 18): ends of legs from here, (M, 3) float64 ENU metres -> (M,) bool.
    teammates
        Those that it hears now; planners remember the others. `goal_enu_m` is the viewpoint that one is going for.
    radio_range_m
        Somebody should be within this distance after the leg; infinite when the radio reaches everywhere.
    unfixed_s
        Seconds since its last position fix.
    now_s
        The vehicle's time.
    said_done
        (N,) bool, landmarks that teammates called done without telling their heights; None when nobody can.
    """

    index: int
    position_enu_m: Point
    landmarks: LandmarkMap
    sensor: RangeSensor
    band: HeightBand
    reach_m: float
    admissible: Callable[[FloatArray], BoolArray]
    teammates: tuple[Teammate, ...] = field(default=())
    radio_range_m: float = math.inf
    unfixed_s: float = 0.0
    now_s: float = 0.0
    said_done: BoolArray | None = None


class MappingPlanner(Protocol):
    """Decides for one vehicle."""

    def ask(self, situation: MappingSituation) -> Decision:
        """Say where to go next: `Waypoint` (admissible, within reach), `Wait` or `Finished`."""
        ...
