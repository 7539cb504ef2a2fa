"""Faults for drills: what can strike a vehicle, by order or by the mission's timetable."""

from __future__ import annotations

from collections.abc import Sequence
from typing import get_args

from sim_bridge.navigation import Navigation
from sim_bridge.vehicle import Vehicle
from vehicle_agent.mission.load import MissionPlan
from vehicle_agent.mission.model import FaultName

FAULTS: tuple[FaultName, ...] = get_args(FaultName)


class FaultBoard:
    """Strikes and mends the vehicles of a fleet.

    Example
    -------
    ::

        fleet.faults.set(0, "gps-loss", True)
    """

    def __init__(self, plan: MissionPlan, vehicles: Sequence[Vehicle], navigation: Navigation) -> None:
        self._vehicles = vehicles
        self._navigation = navigation
        events: list[tuple[float, int, FaultName, bool]] = []
        for table in plan.mission.simulation.faults:
            index = plan.index_of(table.vehicle)
            events.append((table.at_s, index, table.fault, True))
            if table.for_s is not None:
                events.append((table.at_s + table.for_s, index, table.fault, False))
        self._events = sorted(events, key=lambda event: event[0], reverse=True)

    def tick(self, time_s: float) -> None:
        """Let strike what is due at an instant of simulated time."""
        while self._events and self._events[-1][0] <= time_s:
            _, index, fault, present = self._events.pop()
            self.set(index, fault, present)

    def set(self, index: int, fault: FaultName, present: bool) -> None:
        """Begin or end a fault of one vehicle; a battery stays what it has become."""
        vehicle = self._vehicles[index]
        if fault == "gps-loss":
            self._navigation.receiver_failed[index] = vehicle.fix_lost = present
        elif fault == "battery" and present:
            vehicle.battery.fail()
        elif fault == "motor":
            vehicle.break_motors(present)
        elif fault == "link-loss":
            vehicle.link_lost = present
        elif fault == "leak":
            vehicle.leaking = present
