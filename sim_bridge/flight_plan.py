"""What a vehicle keeps for its clients: the mission, the fence and the rally points, as they were uploaded.

Numbers are MAVLink's: `MissionCommand` is MAV_CMD, frames are MAV_FRAME, latitudes and longitudes 1e-7 degrees.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from sim_bridge.fence import CircleZone, PolygonZone, Zone
from vehicle_agent.domain.frames import Datum, Geodetic, Point

FRAME_GLOBAL = 0
FRAME_MISSION = 2
FRAME_ABOVE_HOME = 3
FRAME_ABOVE_TERRAIN = 10
NOT_INT = {5: FRAME_GLOBAL, 6: FRAME_ABOVE_HOME, 11: FRAME_ABOVE_TERRAIN, FRAME_MISSION: FRAME_GLOBAL}
"""Frames that come back under another number than they were given with."""


class MissionCommand(IntEnum):
    """Commands of mission, fence and rally items that the simulated vehicles know."""

    WAYPOINT = 16
    LOITER_UNLIMITED = 17
    LOITER_TURNS = 18
    LOITER_TIME = 19
    RETURN = 20
    LAND = 21
    TAKEOFF = 22
    SPLINE_WAYPOINT = 82
    DELAY = 93
    CONDITION_DELAY = 112
    CONDITION_DISTANCE = 114
    CONDITION_YAW = 115
    JUMP = 177
    CHANGE_SPEED = 178
    SET_HOME = 179
    RETURN_PATH_START = 188
    LAND_START = 189
    REGION_OF_INTEREST_LOCATION = 195
    REGION_OF_INTEREST_NONE = 197
    REGION_OF_INTEREST = 201
    MOUNT_CONTROL = 205
    TRIGGER_DISTANCE = 206
    ENABLE_FENCE = 207
    JUMP_TAG = 600
    JUMP_TO_TAG = 601
    FENCE_RETURN_POINT = 5000
    FENCE_INCLUSION = 5001
    FENCE_EXCLUSION = 5002
    FENCE_INCLUSION_CIRCLE = 5003
    FENCE_EXCLUSION_CIRCLE = 5004
    RALLY_POINT = 5100


_C = MissionCommand
NAVIGATION = frozenset(command for command in _C if command <= _C.DELAY)
"""Commands that the mission waits for; the others are done on the way to the next of these."""
POLYGONS = frozenset({_C.FENCE_INCLUSION, _C.FENCE_EXCLUSION})
CIRCLES = frozenset({_C.FENCE_INCLUSION_CIRCLE, _C.FENCE_EXCLUSION_CIRCLE})
INCLUSIONS = frozenset({_C.FENCE_INCLUSION, _C.FENCE_INCLUSION_CIRCLE})


@dataclass(frozen=True, slots=True)
class PlanItem:
    """One item of a mission, a fence or a list of rally points.

    Attributes
    ----------
    command, frame
        MAV_CMD, and MAV_FRAME as it comes back when read.
    parameters
        1 to 4.
    x, y
        Latitude and longitude in 1e-7 degrees, or parameters 5 and 6.
    z
        Altitude in metres, or parameter 7.
    """

    command: int
    frame: int
    parameters: tuple[float, float, float, float]
    x: int
    y: int
    z: float

    @property
    def has_place(self) -> bool:
        """ArduPilot takes 0, 0 for "where I am"."""
        return self.x != 0 or self.y != 0


class FlightPlan:
    """The three lists of one vehicle.

    Attributes
    ----------
    mission
        Item 0 stands for home, whatever was uploaded as such.
    fence, rally
        As uploaded.
    fence_zones
        The fence as areas in the mission's frame.
    changes
        Counts the replacements of the mission.
    """

    __slots__ = ("_datum", "changes", "fence", "fence_zones", "mission", "rally")

    def __init__(self, datum: Datum) -> None:
        self._datum = datum
        self.mission: tuple[PlanItem, ...] = ()
        self.fence: tuple[PlanItem, ...] = ()
        self.rally: tuple[PlanItem, ...] = ()
        self.fence_zones: tuple[Zone, ...] = ()
        self.changes = 0

    def set_mission(self, items: tuple[PlanItem, ...]) -> None:
        self.mission = items
        self.changes += 1

    def set_fence(self, items: tuple[PlanItem, ...]) -> None:
        """Replace the fence; ValueError, and the old one stays, when a polygon has not the corners that it tells."""
        zones: list[Zone] = []
        rest = [item for item in items if item.command != _C.FENCE_RETURN_POINT]
        while rest:
            first = rest[0]
            inclusion = first.command in INCLUSIONS
            if first.command in CIRCLES:
                zones.append(CircleZone(inclusion, *self.place_en_m(first), first.parameters[0]))
                rest = rest[1:]
                continue
            count = int(first.parameters[0])
            corners = rest[:count]
            fits = len(corners) == count and all(
                corner.command == first.command and int(corner.parameters[0]) == count for corner in corners
            )
            if count < 3 or not fits:
                raise ValueError(f"a polygon tells {count} corners and has not so many")
            zones.append(PolygonZone(inclusion, np.array([self.place_en_m(corner) for corner in corners])))
            rest = rest[count:]
        self.fence, self.fence_zones = items, tuple(zones)

    def place_enu_m(self, item: PlanItem, home_up_m: float, ground_up_m: float) -> Point:
        """Where an item is, given the heights that its frame may count from."""
        amsl_m = item.z if item.frame == FRAME_GLOBAL else 0.0
        east_m, north_m, up_m = self._datum.to_enu(Geodetic(item.x * 1e-7, item.y * 1e-7, amsl_m))
        if item.frame == FRAME_ABOVE_HOME:
            up_m = home_up_m + item.z
        elif item.frame == FRAME_ABOVE_TERRAIN:
            up_m = ground_up_m + item.z
        return (east_m, north_m, up_m)

    def return_place_enu_m(self, here_enu_m: Point, home_enu_m: Point, home_counts: bool) -> Point:
        """Where to return to: the nearest rally point, or home if that is nearer and counts; height as home's."""
        places = [(*self.place_en_m(item), home_enu_m[2]) for item in self.rally]
        if home_counts or not places:
            places.append(home_enu_m)
        return min(places, key=lambda place: math.hypot(place[0] - here_enu_m[0], place[1] - here_enu_m[1]))

    def place_en_m(self, item: PlanItem) -> tuple[float, float]:
        """Where an item is on the map."""
        east_m, north_m, _ = self._datum.to_enu(Geodetic(item.x * 1e-7, item.y * 1e-7, 0.0))
        return (east_m, north_m)
