"""Automatic flight: works through a mission as ArduPilot's mission library does.

Navigation commands are flown one after the other. Commands between two of them are done one after the other on the way
to the second; conditions among them make the following ones wait, and arriving drops what still waits.
"""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING

from sim_bridge.flight_plan import NAVIGATION, FlightPlan, MissionCommand, PlanItem
from sim_bridge.mission_tasks import MissionTasks, Task

if TYPE_CHECKING:
    from sim_bridge.vehicle import Vehicle

FIRST = 1
"""Item 0 is home."""
LONGEST_CHAIN = 255
"""Jumps and commands between two navigation commands; a mission that goes round for longer ends."""
FOREVER = -1
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
    """

    def __init__(self, vehicle: Vehicle, plan: FlightPlan) -> None:
        self._vehicle = vehicle
        self._plan = plan
        self._tasks = MissionTasks(vehicle, plan)
        self._reached: list[int] = []
        self._jumps: dict[int, int] = {}
        self._pending: list[int] = []
        self._verify: Task | None = None
        self._condition: Task | None = None
        self.current = 0
        self.running = False
        self.complete = False

    @property
    def landing(self) -> bool:
        """Whether it is sinking to the ground on purpose."""
        return self._tasks.landing

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
        self._verify = self._tasks.begin(following, self._plan.mission[following])

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
        self._tasks.forget()

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

    def _do(self, item: PlanItem, time_s: float) -> Task:
        """Do a command and return when it counts as done."""
        first, second = item.parameters[:2]
        if item.command == _C.CONDITION_DELAY:
            return lambda now_s: now_s - time_s >= first
        if item.command == _C.CONDITION_DISTANCE:
            return lambda now_s: self._tasks.distance_m <= first
        if item.command == _C.CHANGE_SPEED and second > 0:
            self._vehicle.set_speed(second)
        elif item.command == _C.SET_HOME:
            here = self._vehicle.pilot.position_enu_m
            self._vehicle.set_home(here if first == 1 or not item.has_place else self._tasks.place(item))
        elif item.command == _C.ENABLE_FENCE:
            self._vehicle.set_parameter("FENCE_ENABLE", float(first == 1))
        return lambda now_s: True
