"""What all vehicles in the water share: they set out as soon as they are armed, from a home at its surface."""

from __future__ import annotations

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
