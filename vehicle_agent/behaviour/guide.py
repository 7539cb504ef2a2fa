"""Whoever leads a vehicle: what a guide is told at a step, and what it is asked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from vehicle_agent.behaviour.intent import Intent, Whereabouts
from vehicle_agent.behaviour.leg import Leg
from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.planning.constraints import Reservation
from vehicle_agent.planning.interface import Finished, Teammate, Waypoint
from vehicle_agent.ports import VehicleState


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What a guide needs to know at a step.

    Attributes
    ----------
    now_s
        The vehicle's time.
    state
        Of its autopilot.
    map_version
        Changes with the map.
    teammates
        Living and working.
    reservations
        Legs to keep clear of.
    passages
        Where teammates must pass that cannot go elsewhere: nobody rests there.
    objective
        J_E of this vehicle (Renzaglia eq. 5).
    whereabouts
        Of teammates that may fly: who must be heard before a leg near them is flown.
    """

    now_s: float
    state: VehicleState
    map_version: int
    teammates: tuple[Teammate, ...]
    reservations: tuple[Reservation, ...]
    passages: tuple[Reservation, ...]
    objective: float
    whereabouts: tuple[Whereabouts, ...] = ()


@dataclass(frozen=True, slots=True)
class Arrived:
    """The vehicle is where it was to go."""


class Guide(Protocol):
    """One vehicle's way through the area.

    Attributes
    ----------
    leg
        What it flies or sails now; None when it stays.
    intent
        What it means to fly next and waits with for teammates' words; None when there is nothing such.
    waypoint
        The planner's last decision while it is pursued.
    why
        For a person to read.
    """

    leg: Leg | None
    intent: Intent | None
    waypoint: Waypoint | None
    why: str

    @property
    def is_idle(self) -> bool:
        """It has nothing to do and claims nothing, though others still work."""
        ...

    @property
    def has_sector(self) -> bool:
        """Something is to be seen before the rest."""
        ...

    def work(self, around: Surroundings) -> Point | Finished | None:
        """Next target to go to, Finished when nothing is left to do, or None to carry on."""
        ...

    def go_to(self, around: Surroundings, place_en_m: tuple[float, float]) -> Point | Arrived | None:
        """Next target on the way to a place, None to carry on, or Arrived as near to it as can be."""
        ...

    def go_home(self, around: Surroundings, home_enu_m: Point) -> Point | None:
        """Next target on the way home, or None to carry on."""
        ...

    def is_over_home(self, state: VehicleState, home_enu_m: Point) -> bool:
        """Whether only the way straight down, or up, to home is left."""
        ...

    def make_way(self, around: Surroundings) -> Point | None:
        """Leave a place where a teammate must pass; None where nobody must, or there is no way out now."""
        ...

    def stay(self, around: Surroundings, why: str) -> Point:
        """Give up what is flown now and come to rest."""
        ...

    def forget(self, why: str) -> None:
        """Nothing is flown any more: somebody else steers, or the trip is over."""
        ...

    def limit(self, allowed: BoolArray, area_cells: BoolArray, sector_cells: BoolArray | None) -> None:
        """Go only over `allowed` cells, see only `area_cells`, and `sector_cells` first: (columns, rows) bool."""
        ...
