"""What a vehicle's next leg must satisfy: C(P) of Renzaglia 2020 section 3, for whole straight legs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import chain
from operator import attrgetter

import numpy as np

from vehicle_agent.domain.frames import FloatArray, Point
from vehicle_agent.domain.grid import Grid
from vehicle_agent.domain.paths import as_array, clear_legs, ground_heights, leg_clearances
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.domain.segments import come_too_near, least_distance_m, segment_distance_m

_HEIGHT_SHARES = np.linspace(0.0, 1.0, 17) ** 2
"""Heights tried, as shares of the height band: closer together near the ground, where vehicles fly."""
_SHORTENINGS = (1.0, 0.5, 0.25, 0.125)
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
        start, grid = as_array(start_enu_m), self.grid
        clear: BoolArray = clear_legs(
            self.surface_m,
            grid.west_m,
            grid.south_m,
            grid.cell_m,
            start,
            np.ascontiguousarray(ends_enu_m, dtype=np.float64),
            self.min_above_m,
            self.max_above_m,
            self.ceiling_m,
            self.stretch * self.reach_m,
        )
        if self.reservations and clear.any():
            theirs = _as_rows(map(attrgetter("start_enu_m"), self.reservations), len(self.reservations))
            there = _as_rows(map(attrgetter("end_enu_m"), self.reservations), len(self.reservations))
            clear[clear] = ~come_too_near(start, ends_enu_m[clear], theirs, there, self.separation_m)
        return clear

    def fit(self, start_enu_m: Point, end_en_m: tuple[float, float]) -> Point | None:
        """The lowest admissible end over (or short of) a horizontal target within reach; None when there is none.

        The target is approached as far as the constraints let one leg go; where even a short leg would be too low, a
        climb on the spot.
        """
        east_m, north_m = end_en_m
        away_m = math.hypot(east_m - start_enu_m[0], north_m - start_enu_m[1])
        scale = min(1.0, self.reach_m / away_m) if away_m > 0 else 1.0
        for shortening in _SHORTENINGS:
            part = scale * shortening
            choices = self._heights_over(
                start_enu_m[0] + part * (east_m - start_enu_m[0]), start_enu_m[1] + part * (north_m - start_enu_m[1])
            )
            if choices is None:
                continue
            admissible = self.admissible(start_enu_m, choices)
            if admissible.any():
                return _point(choices[int(np.argmax(admissible))])
        return None

    def climb(self, start_enu_m: Point) -> Point | None:
        """A higher admissible point straight above; None when the height band ends here or the way up is taken."""
        choices = self._heights_over(start_enu_m[0], start_enu_m[1])
        if choices is None:
            return None
        choices = choices[choices[:, 2] > start_enu_m[2] + 0.25 * self.min_above_m]
        admissible = self.admissible(start_enu_m, choices) if len(choices) else np.zeros(0, dtype=np.bool_)
        return _point(choices[int(np.argmax(admissible))]) if admissible.any() else None

    def _heights_over(self, east_m: float, north_m: float) -> FloatArray | None:
        ground_m = self.ground_m(east_m, north_m)
        if math.isnan(ground_m):
            return None
        heights = ground_m + self.min_above_m + _HEIGHT_SHARES * (self.max_above_m - self.min_above_m)
        return np.column_stack((np.full(len(heights), east_m), np.full(len(heights), north_m), heights))

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


def _as_rows(points: Iterable[Point], count: int) -> FloatArray:
    """(count, 3) float64; faster as `np.array` of many small tuples."""
    return np.fromiter(chain.from_iterable(points), np.float64, 3 * count).reshape(count, 3)


def _point(row: FloatArray) -> Point:
    return (float(row[0]), float(row[1]), float(row[2]))
