"""One vehicle's way in the team's plan of lanes: the bends that are left of it, and those reached last."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.grid import Grid
from vehicle_agent.planning.travel import EastNorth

PARTS_PER_CELL = 2
"""Bends are told in such parts of the map's cells: blocks may differ between vehicles that see differently far."""
FLOWN_TOLD = 4
"""Bends that a vehicle reached last, told so that nobody plans them again."""


@dataclass(frozen=True, slots=True)
class OwnWay:
    """A way as it is told, east and north by turns, in parts of a cell from the grid's south-western corner.

    Attributes
    ----------
    left
        Bends to come.
    flown
        Bends reached last.
    part_m
        Length of a part.
    corner_en_m
        Where parts are counted from, ENU metres.
    """

    left: tuple[int, ...]
    flown: tuple[int, ...]
    part_m: float
    corner_en_m: EastNorth

    @classmethod
    def over(cls, grid: Grid) -> OwnWay:
        """No way yet over a map's grid."""
        return cls((), (), grid.cell_m / PARTS_PER_CELL, (grid.west_m, grid.south_m))

    @property
    def bends_left(self) -> int:
        return len(self.left) // 2

    def bends_en_m(self, most: int | None = None) -> list[EastNorth]:
        """The first bends to come, or all, ENU metres."""
        part_m, (west_m, south_m) = self.part_m, self.corner_en_m
        left = self.left if most is None else self.left[: 2 * most]
        return [
            (west_m + part_m * east, south_m + part_m * north)
            for east, north in zip(left[::2], left[1::2], strict=True)
        ]

    def on(self, way: tuple[int, ...]) -> OwnWay:
        """A new way without the bends at its beginning that are flown already."""
        return replace(self, left=without_flown(way, self.flown))

    def passing(self, place_enu_m: Point, within_m: float) -> OwnWay:
        """The way when the bends as near as that to a place are reached; the same object where none is."""
        left, flown, (west_m, south_m) = self.left, self.flown, self.corner_en_m
        while left:
            east_m, north_m = west_m + self.part_m * left[0], south_m + self.part_m * left[1]
            if math.hypot(east_m - place_enu_m[0], north_m - place_enu_m[1]) >= within_m:
                break
            flown, left = (*flown[2 - 2 * FLOWN_TOLD :], *left[:2]), left[2:]
        return self if left is self.left else replace(self, left=left, flown=flown)


def without_flown(way: tuple[int, ...], flown: tuple[int, ...]) -> tuple[int, ...]:
    """A way as told without the bends at its beginning that its vehicle has reached already."""
    reached = [flown[place : place + 2] for place in range(0, len(flown), 2)]
    while way[:2] in reached:
        way = way[2:]
    return way
