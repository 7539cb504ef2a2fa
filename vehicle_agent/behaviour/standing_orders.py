"""What an operator has ordered for good: no-fly zones, the part of the area that counts, what comes first, a speed."""

from __future__ import annotations

from typing import Any

import numpy as np

from vehicle_agent.behaviour.navigator import allowed_cells
from vehicle_agent.domain.frames import FloatArray
from vehicle_agent.domain.polygon import BoolArray, cells_inside, first_crossing
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.wire.messages import Command, PolygonCm, Verb, Zone

MAX_ZONES = 16
SLOWEST_CM_S = 50


class StandingOrders:
    """One vehicle's standing orders and the cells that follow from them.

    Attributes
    ----------
    allowed
        (columns, rows) bool, where it may fly: inside the fence's margin and outside every zone.
    area_cells
        (columns, rows) bool, what is to be seen.
    sector_cells
        (columns, rows) bool, what is to be seen first; None without a preference.
    speed_limit_cm_s
        0: as the mission says.
    """

    def __init__(self, plan: MissionPlan, index: int) -> None:
        self._plan = plan
        self._fastest_cm_s = round(100 * plan.mission.vehicles[index].speed_m_s)
        self._in_fence = allowed_cells(plan)
        self._zones: dict[int, PolygonCm] = {}
        self._area_cm: PolygonCm = ()
        self._sector_cm: PolygonCm = ()
        self.allowed: BoolArray = self._in_fence
        self.area_cells: BoolArray = plan.area_cells
        self.sector_cells: BoolArray | None = None
        self.speed_limit_cm_s = 0

    def trouble(self, command: Command, home_en_m: tuple[float, float] | None) -> str:
        """Why an order cannot be followed, one sentence; empty when it can."""
        match command.verb:
            case Verb.NO_FLY | Verb.AREA | Verb.SECTOR if command.polygon_cm:
                return self._polygon_trouble(command, home_en_m)
            case Verb.NO_FLY if command.number not in self._zones:
                return f"there is no zone {command.number}"
            case Verb.SPEED if command.number and not SLOWEST_CM_S <= command.number <= self._fastest_cm_s:
                slowest, fastest = SLOWEST_CM_S / 100, self._fastest_cm_s / 100
                return f"the speed must lie between {slowest:g} and {fastest:g} m/s"
            case Verb.GO_TO | Verb.VISIT:
                return self._point_trouble(command)
        return ""

    def take(self, command: Command) -> None:
        """Follow an order that `trouble` found nothing against."""
        match command.verb:
            case Verb.NO_FLY:
                self._zones.pop(command.number, None)
                if command.polygon_cm:
                    self._zones[command.number] = command.polygon_cm
                self.allowed = self._without_zones(self._zones)
            case Verb.AREA:
                self._area_cm = command.polygon_cm
                self.area_cells = self._plan.area_cells & self._cells(command.polygon_cm)
                self.drop_sector()
            case Verb.SECTOR:
                self._sector_cm = command.polygon_cm
                self.sector_cells = self._cells(command.polygon_cm) if command.polygon_cm else None
            case Verb.SPEED:
                self.speed_limit_cm_s = command.number

    def drop_sector(self) -> None:
        """The sector has been seen, or makes no sense any more."""
        self._sector_cm, self.sector_cells = (), None

    def fields(self) -> dict[str, Any]:
        """The fields of an `Orders` message beyond its header."""
        return {
            "no_fly": tuple(Zone(number, polygon) for number, polygon in sorted(self._zones.items())),
            "area_cm": self._area_cm,
            "sector_cm": self._sector_cm,
            "speed_limit_cm_s": self.speed_limit_cm_s,
        }

    def _polygon_trouble(self, command: Command, home_en_m: tuple[float, float] | None) -> str:
        polygon = _corners(command.polygon_cm)
        if len(polygon) < 3 or first_crossing(polygon) is not None:
            return "the polygon must have three corners at least and must not cross itself"
        cells = self._cells(command.polygon_cm)
        if command.verb is not Verb.NO_FLY:
            return "" if (cells & self.area_cells).any() else "the polygon holds nothing of the area"
        if command.number not in self._zones and len(self._zones) >= MAX_ZONES:
            return f"there are {MAX_ZONES} zones already: lift one first"
        grid = self._plan.grid
        if home_en_m is not None and grid.contains(*home_en_m) and cells[grid.cell_of(*home_en_m)]:
            return "the zone holds this vehicle's home"
        free = self._without_zones({**self._zones, command.number: command.polygon_cm})
        return "" if free.any() else "the zone leaves nowhere to fly"

    def _point_trouble(self, command: Command) -> str:
        east_m, north_m = command.point_cm[0] / 100, command.point_cm[1] / 100
        grid = self._plan.grid
        if not grid.contains(east_m, north_m) or not self._in_fence[grid.cell_of(east_m, north_m)]:
            return "the point lies outside the fence"
        return "" if self.allowed[grid.cell_of(east_m, north_m)] else "the point lies in a no-fly zone"

    def _without_zones(self, zones: dict[int, PolygonCm]) -> BoolArray:
        allowed = self._in_fence.copy()
        for polygon in zones.values():
            allowed &= ~self._cells(polygon)
        return allowed

    def _cells(self, polygon_cm: PolygonCm) -> BoolArray:
        if not polygon_cm:
            return np.ones(self._plan.grid.shape, dtype=np.bool_)
        return cells_inside(self._plan.grid, _corners(polygon_cm))


def _corners(polygon_cm: PolygonCm) -> FloatArray:
    return np.array(polygon_cm, dtype=np.float64).reshape(-1, 2) / 100
