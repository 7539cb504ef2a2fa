"""How each navigation command of a mission is flown; the order in which they come is `AutoFlight`'s."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from sim_bridge.flight_plan import FRAME_ABOVE_TERRAIN, FlightPlan, MissionCommand, PlanItem
from sim_bridge.modes import Behaviour
from sim_bridge.return_flight import ReturnFlight, ReturnPhase
from vehicle_agent.domain.frames import Point

if TYPE_CHECKING:
    from sim_bridge.vehicle import Vehicle

Task = Callable[[float], bool]
"""Carries a command on at a time, seconds, and tells whether it is done."""
NAMES = {
    MissionCommand.WAYPOINT: "WP", MissionCommand.SPLINE_WAYPOINT: "SplineWP", MissionCommand.TAKEOFF: "Takeoff",
    MissionCommand.LAND: "Land", MissionCommand.RETURN: "RTL", MissionCommand.LOITER_TIME: "LoitTime",
    MissionCommand.LOITER_TURNS: "LoitTurns", MissionCommand.LOITER_UNLIMITED: "LoitUnlim",
    MissionCommand.DELAY: "Delay", MissionCommand.CHANGE_SPEED: "ChangeSpeed", MissionCommand.SET_HOME: "SetHome",
    MissionCommand.CONDITION_DELAY: "CondDelay", MissionCommand.CONDITION_DISTANCE: "CondDist",
    MissionCommand.CONDITION_YAW: "CondYaw",
}  # fmt: skip
_C = MissionCommand


class MissionTasks:
    """Flies one command at a time.

    Attributes
    ----------
    landing
        Whether the vehicle is sinking to the ground on purpose.
    distance_m
        To the present waypoint over ground.
    """

    __slots__ = ("_number", "_plan", "_vehicle", "distance_m", "landing")

    def __init__(self, vehicle: Vehicle, plan: FlightPlan) -> None:
        self._vehicle = vehicle
        self._plan = plan
        self._number = 0
        self.forget()

    def forget(self) -> None:
        """Drop what belonged to the command before."""
        self.landing = False
        self.distance_m = 0.0

    def begin(self, number: int, item: PlanItem) -> Task:
        """Start a navigation command."""
        self._number = number
        vehicle, command = self._vehicle, _C(item.command)
        vehicle.say(6, f"Mission: {self._number} {NAMES[command]}")
        now_s = vehicle.clock.time_s
        if command is _C.TAKEOFF:
            return self._take_off(item)
        if command in (_C.WAYPOINT, _C.SPLINE_WAYPOINT, _C.LOITER_TIME):
            return self._go(item, lambda arrived_s, time_s: time_s - arrived_s >= item.parameters[0])
        if command is _C.LOITER_UNLIMITED:
            return self._go(item, lambda arrived_s, time_s: False)
        if command is _C.LOITER_TURNS:
            return self._circle(item)
        if command is _C.DELAY:
            vehicle.pilot.stop()
            return lambda time_s: time_s - now_s >= item.parameters[0]
        if command is _C.LAND:
            return self._land(item)
        return self._return_home()

    def place(self, item: PlanItem) -> Point:
        """Where an item wants the vehicle; what it leaves at zero stays as it is (as ArduPilot does)."""
        vehicle = self._vehicle
        east_m, north_m, up_m = vehicle.pilot.position_enu_m
        home = vehicle.home_enu_m or (east_m, north_m, up_m)
        if item.has_place:
            east_m, north_m = self._plan.place_en_m(item)
        ground_m = vehicle.surface_m(east_m, north_m) if item.frame == FRAME_ABOVE_TERRAIN else 0.0
        if item.z != 0.0 or item.has_place:
            up_m = self._plan.place_enu_m(item, home[2], ground_m)[2]
        return (east_m, north_m, up_m)

    def _go(self, item: PlanItem, stay: Callable[[float, float], bool]) -> Task:
        """Fly to an item; done once it is reached and `stay(arrived_s, time_s)` holds."""
        target = self.place(item)
        pilot, arrived_s = self._vehicle.pilot, math.inf
        pilot.fly_to(target)
        text = f"Reached command #{self._number}"

        def verify(time_s: float) -> bool:
            nonlocal arrived_s
            if arrived_s == math.inf and self._distance_to(target) <= self._arrival_radius_m():
                arrived_s = time_s
            if arrived_s == math.inf or not stay(arrived_s, time_s):
                return False
            self._vehicle.say(6, text)
            return True

        return verify

    def _arrival_radius_m(self) -> float:
        return max(0.05, self._vehicle.pilot.settings.arrival_radius_m)

    def _distance_to(self, target: Point) -> float:
        east_m, north_m, up_m = self._vehicle.pilot.position_enu_m
        self.distance_m = math.hypot(target[0] - east_m, target[1] - north_m)
        return math.hypot(self.distance_m, self._vehicle.height_error_m(target[2] - up_m))

    def _take_off(self, item: PlanItem) -> Task:
        if not self._flies:
            return lambda time_s: True
        pilot = self._vehicle.pilot
        up_m = self.place(item)[2]
        if self._vehicle.landed:
            pilot.climb_to(up_m)
        else:
            pilot.fly_to((*pilot.position_enu_m[:2], max(up_m, pilot.position_enu_m[2])))
        return lambda time_s: not self._vehicle.landed and pilot.position_enu_m[2] > up_m - self._arrival_radius_m()

    def _circle(self, item: PlanItem) -> Task:
        """Fly to an item, then round it: turns in parameter 1, radius in parameter 3 (negative: to the left)."""
        vehicle, centre = self._vehicle, self.place(item)
        radius_m = item.parameters[2] or vehicle.parameters.get("CIRCLE_RADIUS", 1_000.0) / 100.0
        turns, sense = abs(item.parameters[0]), math.copysign(1.0, radius_m)
        radius_m = abs(radius_m)
        east_m, north_m, _ = vehicle.pilot.position_enu_m
        start = math.atan2(east_m - centre[0], north_m - centre[1])
        # No faster than the speed limit and at most 20 degrees a second, ArduCopter's CIRCLE_RATE.
        rate = min(math.radians(20.0), 0.8 * vehicle.pilot.settings.speed_m_s / max(radius_m, 0.1))
        began_s = math.inf

        def point(angle: float) -> Point:
            bearing = start + sense * angle
            return (centre[0] + radius_m * math.sin(bearing), centre[1] + radius_m * math.cos(bearing), centre[2])

        def verify(time_s: float) -> bool:
            nonlocal began_s
            if began_s == math.inf:
                if self._distance_to(point(0.0)) <= self._arrival_radius_m():
                    began_s = time_s
                return False
            angle = rate * (time_s - began_s)
            vehicle.pilot.fly_to(point(angle))
            return angle >= 2.0 * math.pi * turns

        vehicle.pilot.fly_to(point(0.0))
        return verify

    def _land(self, item: PlanItem) -> Task:
        if not self._flies:
            return lambda time_s: True
        vehicle, pilot = self._vehicle, self._vehicle.pilot
        target: Point | None = None
        if item.has_place:
            target = (*self._plan.place_en_m(item), pilot.position_enu_m[2])
            pilot.fly_to(target)
        else:
            self._sink()

        def verify(time_s: float) -> bool:
            nonlocal target
            if vehicle.landed:
                return True
            if target is not None and self._distance_to(target) <= self._arrival_radius_m():
                target = None
                self._sink()
            elif target is None:
                pilot.descend()
            return False

        return verify

    def _sink(self) -> None:
        self.landing = True
        self._vehicle.pilot.begin_landing()

    def _return_home(self) -> Task:
        vehicle = self._vehicle
        home = vehicle.return_place_enu_m()
        if not self._flies:
            target = (home[0], home[1], vehicle.pilot.position_enu_m[2])
            vehicle.pilot.fly_to(target)
            return lambda time_s: self._distance_to(target) <= self._arrival_radius_m()
        flight = ReturnFlight(vehicle.pilot, home)

        def verify(time_s: float) -> bool:
            if vehicle.landed:
                return True
            flight.fly(time_s)
            self.landing = flight.phase is ReturnPhase.DESCEND
            return False

        return verify

    @property
    def _flies(self) -> bool:
        """Whether it takes off and lands; boats and underwater vehicles skip what asks for that."""
        return Behaviour.LAND in self._vehicle.personality.mode_of
