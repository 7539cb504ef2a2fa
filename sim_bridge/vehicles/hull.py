"""What all vehicles in the water share: they set out as soon as they are armed, from a home at its surface."""

from __future__ import annotations

import math

from sim_bridge.battery import IDLE_LOAD
from sim_bridge.modes import LandedState
from sim_bridge.vehicle import Vehicle
from vehicle_agent.domain.frames import Point


class Hull(Vehicle):
    """A vehicle on or in the water."""

    @property
    def landed_state(self) -> LandedState:
        return LandedState.IN_AIR if self.armed else LandedState.ON_GROUND

    def _home_here(self) -> Point:
        east_m, north_m, _ = self.pilot.position_enu_m
        return (east_m, north_m, self._bodies.water_level_m)

    def _may_disarm(self) -> bool:
        return True

    def _on_armed(self) -> None:
        self.landed = False
        self._begin(self.behaviour)

    def _on_disarmed(self) -> None:
        self.landed = True

    def _load(self) -> float:
        """With the cube of the speed through the water."""
        if not self.armed:
            return 0.0
        east, north, up = self.pilot.velocity_enu_m_s
        flow_east, flow_north = self._bodies.flows_m_s[self.index]
        speed = math.sqrt((east - flow_east) ** 2 + (north - flow_north) ** 2 + up**2)
        return IDLE_LOAD + (1.0 - IDLE_LOAD) * min(speed / self.settings.speed_m_s, 1.5) ** 3
