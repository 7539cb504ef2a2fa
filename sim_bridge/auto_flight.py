"""Automatic flight: works through a mission as ArduPilot's mission library does.

Navigation commands are flown one after the other. Commands between two of them are done one after the other on the way
to the second; conditions among them make the following ones wait, and arriving drops what still waits.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from enum import IntEnum
from typing import TYPE_CHECKING

from sim_bridge.flight_plan import FRAME_ABOVE_TERRAIN, NAVIGATION, FlightPlan, MissionCommand, PlanItem
from sim_bridge.modes import Behaviour
from sim_bridge.return_flight import ReturnFlight, ReturnPhase
from vehicle_agent.domain.frames import Point

if TYPE_CHECKING:
    from sim_bridge.vehicle import Vehicle

FIRST = 1
"""Item 0 is home."""
LONGEST_CHAIN = 255
"""Jumps and commands between two navigation commands; a mission that goes round for longer ends."""
FOREVER = -1
NAMES = {
    MissionCommand.WAYPOINT: "WP", MissionCommand.SPLINE_WAYPOINT: "SplineWP", MissionCommand.TAKEOFF: "Takeoff",
    MissionCommand.LAND: "Land", MissionCommand.RETURN: "RTL", MissionCommand.LOITER_TIME: "LoitTime",
    MissionCommand.LOITER_TURNS: "LoitTurns", MissionCommand.LOITER_UNLIMITED: "LoitUnlim",
    MissionCommand.DELAY: "Delay", MissionCommand.CHANGE_SPEED: "ChangeSpeed", MissionCommand.SET_HOME: "SetHome",
    MissionCommand.CONDITION_DELAY: "CondDelay", MissionCommand.CONDITION_DISTANCE: "CondDist",
    MissionCommand.CONDITION_YAW: "CondYaw",
}  # fmt: skip
_C = MissionCommand


class MissionState(IntEnum):
    """MAVLink's MISSION_STATE."""

    NO_MISSION = 1
    NOT_STARTED = 2
    ACTIVE = 3
    COMPLETE = 5


class AutoFlight:
    """The mission of one vehicle and where it stands.

    Attributes
    ----------
    current
        Item that is flown or comes next; 0 before the first start.
    running, complete
        Whether it is being flown, and whether it has been flown to its end.
    landing
        Whether it is sinking to the ground on purpose.
    distance_m
        To the present waypoint over ground.
    """

    def __init__(self, vehicle: Vehicle, plan: FlightPlan) -> None:
        self._vehicle = vehicle
        self._plan = plan
        self._reached: list[int] = []
        self._jumps: dict[int, int] = {}
        self._pending: list[int] = []
        self._verify: Callable[[float], bool] | None = None
        self._condition: Callable[[float], bool] | None = None
        self.current = 0
        self.running = False
        self.complete = False
        self.landing = False
        self.distance_m = 0.0

    @property
    def state(self) -> MissionState:
        if len(self._plan.mission) <= FIRST:
            return MissionState.NO_MISSION
        if self.complete:
            return MissionState.COMPLETE
        return MissionState.ACTIVE if self.running else MissionState.NOT_STARTED

    @property
    def starts_with_takeoff(self) -> bool:
        """Whether the first navigation command from where it would go on is a take-off."""
        following = self._next_navigation(max(self.current, FIRST), count_jumps=False)
        return following is not None and self._plan.mission[following].command == _C.TAKEOFF

    def drain_reached(self) -> list[int]:
        """Take the numbers of the items finished since the last call."""
        reached, self._reached[:] = list(self._reached), []
        return reached

    # Orders

    def start(self) -> None:
        """Begin the mission, or go on with it where it was left (MIS_RESTART = 0)."""
        again = self.complete or self._vehicle.parameters.get("MIS_RESTART", 0.0) == 1 or self.current < FIRST
        if again:
            self._jumps.clear()
        self.running, self.complete = True, False
        self._advance(FIRST if again else self.current)

    def stop(self) -> None:
        """Leave the mission where it is."""
        self.running = False
        self._forget_task()

    def set_current(self, index: int) -> bool:
        """Go on with another item; False when there is none of that number."""
        if index == 0 and self._plan.mission:
            index = FIRST
        if not FIRST <= index < len(self._plan.mission):
            return False
        self.complete = False
        if self.running:
            self._advance(index)
        else:
            self.current = index
        return True

    def reset(self) -> None:
        """Begin anew at the next start, counting jumps from zero."""
        self._jumps.clear()
        self.current, self.complete = 0, False

    def motors_stopped(self) -> None:
        """Note the end of a landing; anywhere else the mission stops where it is."""
        if self.running and self.landing and self._vehicle.landed:
            self._reached.append(self.current)
            self.complete = self._next_navigation(self.current + 1, count_jumps=False) is None
        self.stop()

    def mission_replaced(self) -> None:
        """Carry on after the mission has changed: what is being flown goes on if it still exists."""
        self._jumps.clear()
        self.complete = False
        if self.current >= len(self._plan.mission):
            self.current = 0

    # Flying

    def update(self, time_s: float) -> None:
        """Carry on by one step; call while the vehicle flies its mission, armed."""
        if not self.running:
            return
        self._do_pending(time_s)
        if self._verify is not None and self._verify(time_s):
            done = self.current
            self._reached.append(done)
            if self.running:
                self._advance(done + 1)

    def _advance(self, index: int) -> None:
        self._forget_task()
        following = self._next_navigation(index, count_jumps=True)
        if following is None:
            self._finish()
            return
        self.current = following
        self._begin(self._plan.mission[following])

    def _next_navigation(self, index: int, count_jumps: bool) -> int | None:
        """Index of the next navigation command from `index` on; those before it are kept to be done."""
        mission = self._plan.mission
        jumps = self._jumps if count_jumps else dict(self._jumps)
        for _ in range(LONGEST_CHAIN):
            if not FIRST <= index < len(mission):
                return None
            item = mission[index]
            target = self._jump_target(item)
            if target is not None:
                times = int(item.parameters[1])
                if times == FOREVER or jumps.get(index, 0) < times:
                    jumps[index] = jumps.get(index, 0) + 1
                    index = target
                else:
                    index += 1
            elif item.command in NAVIGATION:
                return index
            else:
                if count_jumps:
                    self._pending.append(index)
                index += 1
        return None

    def _jump_target(self, item: PlanItem) -> int | None:
        if item.command == _C.JUMP:
            return int(item.parameters[0])
        if item.command == _C.JUMP_TO_TAG:
            for index, other in enumerate(self._plan.mission):
                if other.command == _C.JUMP_TAG and other.parameters[0] == item.parameters[0]:
                    return index
            return len(self._plan.mission)
        return None

    def _finish(self) -> None:
        self.running, self.complete = False, True
        self.current = max(len(self._plan.mission) - 1, 0)
        vehicle = self._vehicle
        if vehicle.landed:
            vehicle.disarm()
        else:
            vehicle.pilot.stop()

    def _forget_task(self) -> None:
        self._pending.clear()
        self._condition = self._verify = None
        self.landing = False
        self.distance_m = 0.0

    def _begin(self, item: PlanItem) -> None:
        vehicle, command = self._vehicle, _C(item.command)
        vehicle.say(6, f"Mission: {self.current} {NAMES[command]}")
        now_s = vehicle.clock.time_s
        if command is _C.TAKEOFF:
            self._verify = self._take_off(item)
        elif command in (_C.WAYPOINT, _C.SPLINE_WAYPOINT, _C.LOITER_TIME):
            self._verify = self._go(item, lambda arrived_s, time_s: time_s - arrived_s >= item.parameters[0])
        elif command is _C.LOITER_UNLIMITED:
            self._verify = self._go(item, lambda arrived_s, time_s: False)
        elif command is _C.LOITER_TURNS:
            self._verify = self._circle(item)
        elif command is _C.DELAY:
            vehicle.pilot.stop()
            self._verify = lambda time_s: time_s - now_s >= item.parameters[0]
        elif command is _C.LAND:
            self._verify = self._land(item)
        else:
            self._verify = self._return_home()

    def _place(self, item: PlanItem) -> Point:
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

    def _go(self, item: PlanItem, stay: Callable[[float, float], bool]) -> Callable[[float], bool]:
        """Fly to an item; done once it is reached and `stay(arrived_s, time_s)` holds."""
        target = self._place(item)
        pilot, arrived_s = self._vehicle.pilot, math.inf
        pilot.fly_to(target)
        text = f"Reached command #{self.current}"

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

    def _take_off(self, item: PlanItem) -> Callable[[float], bool]:
        if not self._flies:
            return lambda time_s: True
        pilot = self._vehicle.pilot
        up_m = self._place(item)[2]
        if self._vehicle.landed:
            pilot.climb_to(up_m)
        else:
            pilot.fly_to((*pilot.position_enu_m[:2], max(up_m, pilot.position_enu_m[2])))
        return lambda time_s: not self._vehicle.landed and pilot.position_enu_m[2] > up_m - self._arrival_radius_m()

    def _circle(self, item: PlanItem) -> Callable[[float], bool]:
        """Fly to an item, then round it: turns in parameter 1, radius in parameter 3 (negative: to the left)."""
        vehicle, centre = self._vehicle, self._place(item)
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

    def _land(self, item: PlanItem) -> Callable[[float], bool]:
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

    def _return_home(self) -> Callable[[float], bool]:
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

    # Commands done on the way

    def _do_pending(self, time_s: float) -> None:
        while self._pending:
            index = self._pending[0]
            if self._condition is None:
                self._condition = self._do(self._plan.mission[index], time_s)
            if not self._condition(time_s):
                return
            self._condition = None
            self._pending.pop(0)
            self._reached.append(index)

    def _do(self, item: PlanItem, time_s: float) -> Callable[[float], bool]:
        """Do a command and return when it counts as done."""
        first, second = item.parameters[:2]
        if item.command == _C.CONDITION_DELAY:
            return lambda now_s: now_s - time_s >= first
        if item.command == _C.CONDITION_DISTANCE:
            return lambda now_s: self.distance_m <= first
        if item.command == _C.CHANGE_SPEED and second > 0:
            self._vehicle.set_speed(second)
        elif item.command == _C.SET_HOME:
            here = self._vehicle.pilot.position_enu_m
            self._vehicle.set_home(here if first == 1 or not item.has_place else self._place(item))
        elif item.command == _C.ENABLE_FENCE:
            self._vehicle.set_parameter("FENCE_ENABLE", float(first == 1))
        return lambda now_s: True
