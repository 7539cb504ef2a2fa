"""What a vehicle's next leg must satisfy: C(P) of Renzaglia 2020 section 3, for whole straight legs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from operator import attrgetter

import numpy as np

from vehicle_agent.domain.clearance import clear_legs, ground_heights, leg_clearances
from vehicle_agent.domain.fitted_legs import is_clear, lowest_clear_end, lowest_clear_height
from vehicle_agent.domain.frames import FloatArray, Point, as_array
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.segments import come_too_near, least_distance_m, segment_distance_m

STRETCH = 1.5
"""How much longer a leg may be in space than over ground."""


@dataclass(frozen=True, slots=True)
class Reservation:
    """The straight leg that a teammate has reserved; both ends equal when it stays.

    Attributes
    ----------
    owner_index
        Team index of who reserved it: of two that reserved crossing legs at the same time, the lower has the way.
    has_way
        Its owner can neither stop nor turn aside, so all others do.
    since_ms
        When its owner told that it means to fly it, Unix milliseconds; 0 once it flies it.
    """

    start_enu_m: Point
    end_enu_m: Point
    owner_index: int = -1
    has_way: bool = False
    since_ms: int = 0

    def precedes(self, index: int) -> bool:
        """Whether its owner has the way over a vehicle with that team index, both under way."""
        return self.has_way or self.owner_index < index

    def precedes_intent(self, since_ms: int, index: int) -> bool:
        """Whether its owner has the way over a vehicle with that team index that means to set off since then."""
        return self.since_ms == 0 or (self.since_ms, self.owner_index) < (since_ms, index)


@dataclass(frozen=True, slots=True)
class Traffic:
    """Legs that teammates have reserved, and the smallest distance to keep from them."""

    reservations: tuple[Reservation, ...]
    separation_m: float

    def conflict(self, start_enu_m: Point, end_enu_m: Point) -> Reservation | None:
        """The first reservation that a leg must not be flown against; None when it is clear."""
        return next(self.conflicts(start_enu_m, end_enu_m), None)

    def conflicts(self, start_enu_m: Point, end_enu_m: Point) -> Iterator[Reservation]:
        """Reservations that a leg comes too near to, and nearer than its start is to the leg or to its owner.

        The owner counts apart: a vehicle that happens to be on the other's leg must not fly towards it.
        """
        start, end = as_array(start_enu_m), as_array(end_enu_m)
        for reservation in self.reservations:
            theirs, there = as_array(reservation.start_enu_m), as_array(reservation.end_enu_m)
            if self._comes_too_near(start, end, theirs, there) or self._comes_too_near(start, end, theirs, theirs):
                yield reservation

    def blocks(self, start_enu_m: Point, end_enu_m: Point, place_enu_m: Point) -> bool:
        """Tell whether somebody who comes to rest at a place would be in the way of a leg."""
        place = as_array(place_enu_m)
        return self._comes_too_near(as_array(start_enu_m), as_array(end_enu_m), place, place)

    def _comes_too_near(self, start: FloatArray, end: FloatArray, theirs: FloatArray, there: FloatArray) -> bool:
        apart_m = segment_distance_m(start, end, theirs, there)
        return apart_m < least_distance_m(self.separation_m, segment_distance_m(start, start, theirs, there))


@dataclass(frozen=True, slots=True)
class Constraints:
    """Where a vehicle may fly now.

    Attributes
    ----------
    grid
        The cells of `surface_m`.
    surface_m
        (columns, rows) float64, ENU z to stay clear of; NaN where unknown or outside the fence.
    min_above_m, max_above_m
        Height band above the surface, metres; the lower bound holds along a leg, the upper one at its end.
    reach_m
        Longest leg, measured over ground.
    stretch
        How much longer than `reach_m` a leg may be in space.
    separation_m
        Smallest distance to every reservation.
    reservations
        Teammates' legs.
    ceiling_m
        Highest that a leg may end, ENU z.
    """

    grid: Grid
    surface_m: FloatArray
    min_above_m: float
    max_above_m: float
    reach_m: float
    separation_m: float = 0.0
    reservations: tuple[Reservation, ...] = field(default=())
    stretch: float = STRETCH
    ceiling_m: float = math.inf
    _rivals_enu_m: FloatArray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        ends = attrgetter("start_enu_m", "end_enu_m")
        legs = np.array([ends(reservation) for reservation in self.reservations], dtype=np.float64).reshape(-1, 2, 3)
        object.__setattr__(self, "_rivals_enu_m", np.ascontiguousarray(legs.transpose(1, 0, 2)))

    def ground_m(self, east_m: float, north_m: float) -> float:
        """Surface height around a point, ENU z; NaN where no vehicle may be."""
        return float(self.grounds_m(np.array([[east_m, north_m, 0.0]]))[0])

    def grounds_m(self, points_enu_m: FloatArray) -> FloatArray:
        """Surface height under points, ENU z: (N, 3) float64 -> (N,); NaN where no vehicle may be."""
        grid = self.grid
        points = np.ascontiguousarray(points_enu_m, dtype=np.float64)
        heights: FloatArray = ground_heights(self.surface_m, grid.west_m, grid.south_m, grid.cell_m, points)
        return heights

    def height_above_ground_m(self, position_enu_m: Point) -> float:
        return position_enu_m[2] - self.ground_m(position_enu_m[0], position_enu_m[1])

    def admissible(self, start_enu_m: Point, ends_enu_m: FloatArray) -> BoolArray:
        """Tell which legs from `start` are allowed: (N, 3) float64 -> (N,) bool.

        A vehicle that is already too low or too near to a teammate may take legs that make it no worse.
        """
        start, ends = as_array(start_enu_m), np.ascontiguousarray(ends_enu_m, dtype=np.float64)
        grid, longest_m = self.grid, self.stretch * self.reach_m
        clear: BoolArray = clear_legs(
            self.surface_m, grid.west_m, grid.south_m, grid.cell_m, start, ends,
            self.min_above_m, self.max_above_m, self.ceiling_m, longest_m,
        )  # fmt: skip
        if self.reservations and clear.any():
            where, there = self._rivals_enu_m
            clear[clear] = ~come_too_near(start, ends[clear], where, there, self.separation_m)
        return clear

    def allows(self, start_enu_m: Point, end_enu_m: Point) -> bool:
        """Tell whether one leg is allowed, as `admissible` does for many."""
        return is_clear(as_array(start_enu_m), as_array(end_enu_m), *self._limits())

    def fit(self, start_enu_m: Point, end_en_m: tuple[float, float], legs: int = 1) -> Point | None:
        """The lowest admissible end over (or short of) a horizontal target within reach; None when there is none.

        The target is approached as far as the constraints let one leg go, or one that is flown in so many legs; where
        even a short leg would be too low, a climb on the spot.
        """
        start, goal = as_array(start_enu_m), np.array(end_en_m, dtype=np.float64)
        end = lowest_clear_end(start, goal, legs * self.reach_m, *self._limits(legs))
        return None if math.isnan(end[0]) else end

    def climb(self, start_enu_m: Point, legs: int = 1) -> Point | None:
        """A higher admissible point straight above, flown in so many legs.

        None when the height band ends here or the way up is taken.
        """
        start, above_m = as_array(start_enu_m), start_enu_m[2] + 0.25 * self.min_above_m
        height_m = lowest_clear_height(start, start[:2], above_m, *self._limits(legs))
        return None if math.isnan(height_m) else (start_enu_m[0], start_enu_m[1], height_m)

    def _limits(
        self, legs: int = 1
    ) -> tuple[FloatArray, float, float, float, float, float, float, float, FloatArray, float]:
        """What so many legs in a line must keep to, as kernels take it."""
        grid, longest_m = self.grid, self.stretch * legs * self.reach_m
        return (
            self.surface_m, grid.west_m, grid.south_m, grid.cell_m,
            self.min_above_m, self.max_above_m, self.ceiling_m, longest_m, self._rivals_enu_m, self.separation_m,
        )  # fmt: skip

    def clearance_m(self, start_enu_m: Point, end_enu_m: Point) -> float:
        """Smallest height above the surface along a leg; NaN where it enters what is unknown or forbidden."""
        grid, start, ends = self.grid, as_array(start_enu_m), as_array(end_enu_m)[None, :]
        return float(leg_clearances(self.surface_m, grid.west_m, grid.south_m, grid.cell_m, start, ends)[0])

    @property
    def traffic(self) -> Traffic:
        """Teammates' legs and the distance to them."""
        return Traffic(self.reservations, self.separation_m)

    def conflict(self, start_enu_m: Point, end_enu_m: Point) -> Reservation | None:
        """The first reservation that a leg must not be flown against; None when it is clear."""
        return self.traffic.conflict(start_enu_m, end_enu_m)

    def conflicts(self, start_enu_m: Point, end_enu_m: Point) -> Iterator[Reservation]:
        """As `Traffic.conflicts`."""
        return self.traffic.conflicts(start_enu_m, end_enu_m)

    def blocks(self, start_enu_m: Point, end_enu_m: Point, place_enu_m: Point) -> bool:
        """As `Traffic.blocks`."""
        return self.traffic.blocks(start_enu_m, end_enu_m, place_enu_m)
