"""What every planner is told and asked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from vehicle_agent.domain.elevation import ElevationMap
from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.planning.constraints import Constraints


@dataclass(frozen=True, slots=True)
class AnnouncedTour:
    """The order in which a vehicle means to visit patches of the ground.

    Attributes
    ----------
    number
        Higher than every announcement that it knew of: of two that hold the same patch the higher counts.
    patches
        Numbers of patches, the next one first.
    """

    number: int
    patches: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class AnnouncedLanes:
    """A plan for the whole team: ways of straight lanes that together show what is unseen.

    Attributes
    ----------
    number
        Higher than every plan's that it was made from; the highest counts.
    by
        Team index of who made it; of two plans with the same number that of the higher index counts.
    vehicles
        Team indices of those planned for.
    ways
        Of each: east and north of its bends by turns, in half cells of the map from its south-western corner.
    flown
        Bends that the vehicle that tells the plan reached last, as in ways.
    """

    number: int
    by: int
    vehicles: tuple[int, ...]
    ways: tuple[tuple[int, ...], ...]
    flown: tuple[int, ...] = ()

    def way_of(self, index: int) -> tuple[int, ...]:
        """The way of a vehicle, nothing when there is no plan for it."""
        return self.ways[self.vehicles.index(index)] if index in self.vehicles else ()


@dataclass(frozen=True, slots=True)
class Teammate:
    """What a vehicle knows of a teammate that it still hears.

    Attributes
    ----------
    index
        Team index.
    position_enu_m
        As last told.
    goal_enu_m
        What it claims to be going for; None when it claims nothing.
    goal_cost_m
        Length of its way to that goal when it claimed it.
    tour
        What it announced to visit; None when it announced nothing.
    lanes
        The team's plan as it told it last; None when it told none.
    """

    index: int
    position_enu_m: Point
    goal_enu_m: Point | None = None
    goal_cost_m: float = 0.0
    tour: AnnouncedTour | None = None
    lanes: AnnouncedLanes | None = None


@dataclass(frozen=True, slots=True)
class Observation:
    """What a vehicle measured at one step.

    Attributes
    ----------
    position_enu_m
        P_t of Renzaglia 2020.
    objective
        J_t at that position: cells first observed by this vehicle so far (eq. 5).
    """

    position_enu_m: Point
    objective: float


@dataclass(frozen=True, slots=True)
class Situation:
    """What a vehicle knows when it decides.

    Attributes
    ----------
    index
        Its own team index.
    position_enu_m
        Where it is.
    team_map
        Everything that it measured or was told.
    area_cells
        (columns, rows) bool, the cells to be seen.
    range_m
        Its sensing distance.
    constraints
        Where it may go from here.
    teammates
        Those that it still hears, by team index.
    """

    index: int
    position_enu_m: Point
    team_map: ElevationMap
    area_cells: BoolArray
    range_m: float
    constraints: Constraints
    teammates: tuple[Teammate, ...] = ()


@dataclass(frozen=True, slots=True)
class Waypoint:
    """Where to go next, and why.

    Attributes
    ----------
    position_enu_m
        End of the next straight leg; admissible under the constraints it was asked with.
    why
        For a person to read.
    goal_enu_m
        The place it is finally going for, which teammates should leave to it; None when there is none.
    goal_cost_m
        Length of the way to the goal.
    route_enu_m
        Points after this one, as planned now.
    tour
        Patches that it means to visit, for teammates to leave to it; None when it plans none.
    lanes
        The team's plan that it follows; None when it follows none.
    """

    position_enu_m: Point
    why: str
    goal_enu_m: Point | None = None
    goal_cost_m: float = 0.0
    route_enu_m: tuple[Point, ...] = ()
    tour: AnnouncedTour | None = None
    lanes: AnnouncedLanes | None = None


@dataclass(frozen=True, slots=True)
class Wait:
    """Nowhere to go at this moment (the way is taken); ask again soon."""

    why: str


@dataclass(frozen=True, slots=True)
class Finished:
    """Nothing is left to do for this planner."""

    why: str


Decision = Waypoint | Wait | Finished


class Planner(Protocol):
    """Decides for one vehicle: told what was measured, asked where to go."""

    def tell(self, observation: Observation) -> None:
        """Take in what was measured at the present step."""
        ...

    def ask(self, situation: Situation) -> Decision:
        """Say where to go next."""
        ...


@runtime_checkable
class ThinksAhead(Protocol):
    """A planner whose decisions take long; asked at once, it decides all the same."""

    def think(self, situation: Situation, place_enu_m: Point) -> bool:
        """Do a short part of what the next decision takes; True when the rest of it is short, too.

        Parameters
        ----------
        situation
            As it is now.
        place_enu_m
            Where the decision will be made.
        """
        ...


def has_thought(planner: Planner, situation: Situation, place_enu_m: Point) -> bool:
    """Let a planner do a part of its thinking; True when it is quick to decide."""
    return not isinstance(planner, ThinksAhead) or planner.think(situation, place_enu_m)
