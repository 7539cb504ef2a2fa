"""A multicopter: takes off, hovers, lands; for landing it is taken to carry a rangefinder."""

from __future__ import annotations

import math

from sim_bridge.battery import IDLE_LOAD
from sim_bridge.modes import Behaviour, LandedState
from sim_bridge.pilot import ARRIVED_M
from sim_bridge.reply import ACCEPTED, Outcome, Reply
from sim_bridge.return_flight import ReturnFlight, ReturnPhase
from sim_bridge.vehicle import FARTHEST_M, Vehicle

LIFTED_OFF_M = 0.3
SETTLED_S = 1.0
"""Contact for this long counts as having landed, whatever the flight mode."""
CLIMB_LOAD_S_M = 0.08
"""More draw per metre a second of climb, as a share of hovering."""
TRANSLATIONAL_GAIN = 0.15
TRANSLATIONAL_SPEED_M_S = 10.0
"""Rotors in forward flight draw less by this share, reached at this speed ..."""
DRAG_LOAD_S2_M2 = 0.3 / 20.0**2
"""... until the air's resistance outweighs it."""


class Copter(Vehicle):
    """One multicopter."""

    _contact_since_s = math.inf
    _return: ReturnFlight | None = None

    @property
    def landed_state(self) -> LandedState:
        if self.landed:
            return LandedState.ON_GROUND
        if self.pilot.taking_off:
            return LandedState.TAKING_OFF
        descending = self._return is not None and self._return.phase is ReturnPhase.DESCEND
        if self.behaviour is Behaviour.LAND or descending or self.auto_flight.landing:
            return LandedState.LANDING
        return LandedState.IN_AIR

    def set_mode(self, number: int) -> Reply:
        before = self.mode
        reply = super().set_mode(number)
        if self.mode is not before and self.behaviour is not Behaviour.RETURN:
            self._return = None
        return reply

    def disarm(self, force: bool = False) -> Reply:
        reply = super().disarm(force)
        if not self.armed:
            self._return = None
        return reply

    def _begin(self, behaviour: Behaviour) -> None:
        if behaviour is Behaviour.RETURN and self.home_enu_m is not None:
            self._return = ReturnFlight(self.pilot, self.return_place_enu_m())
        elif behaviour is Behaviour.LAND:
            self.pilot.begin_landing()
        else:
            super()._begin(behaviour)

    def take_off(self, height_m: float) -> Reply:
        if self.personality.takes_off_in_guided:
            return super().take_off(height_m)
        return self.start_takeoff(height_m)

    def start_takeoff(self, height_m: float) -> Reply:
        guided_first = self.personality.takes_off_in_guided
        if guided_first and self.behaviour is not Behaviour.GUIDED:
            return Reply(Outcome.FAILED, "Takeoff needs guided flight, armed and on the ground")
        if not self.armed or not self.landed or self.home_enu_m is None:
            return Reply(Outcome.FAILED, "Takeoff needs guided flight, armed and on the ground")
        if math.isnan(height_m) and not guided_first:
            height_m = self.settings.takeoff_height_m
        up_m = self.home_enu_m[2] + height_m
        if not abs(up_m) <= FARTHEST_M or up_m <= self.pilot.position_enu_m[2] + LIFTED_OFF_M:
            return Reply(Outcome.FAILED, "Takeoff altitude is below the vehicle, or no altitude")
        if not guided_first:
            reply = self.enter(Behaviour.TAKE_OFF)
            if not reply.accepted:
                return reply
        self.pilot.climb_to(up_m)
        return ACCEPTED

    def _load(self) -> float:
        if not self.armed:
            return 0.0
        if self.landed:
            return IDLE_LOAD
        east, north, up = self.pilot.velocity_enu_m_s
        flow_east, flow_north = self._bodies.flows_m_s[self.index]
        airspeed = math.hypot(east - flow_east, north - flow_north)
        forward = TRANSLATIONAL_GAIN * min(1.0, airspeed / TRANSLATIONAL_SPEED_M_S)
        return 1.0 - forward + DRAG_LOAD_S2_M2 * airspeed**2 + CLIMB_LOAD_S_M * max(up, 0.0)

    def _steer(self, time_s: float) -> None:
        if self.battery.remaining <= 0.0:
            self.pilot.rest()
        elif self._return is not None:
            self._return.fly(time_s)
        elif self.behaviour is Behaviour.LAND:
            self.pilot.descend()
        elif self.pilot.taking_off:
            target = self.pilot.target_enu_m
            self.pilot.taking_off = target is not None and target[2] - self.pilot.position_enu_m[2] > ARRIVED_M
            if not self.pilot.taking_off and self.behaviour is Behaviour.TAKE_OFF:
                self.enter(Behaviour.HOLD)
        else:
            super()._steer(time_s)

    def _note_ground(self, impact_m_s: float, time_s: float) -> None:
        """Tell lift-off and landing from height and contact."""
        if self.landed:
            if self.pilot.height_above_ground_m() > LIFTED_OFF_M:
                self.landed = False
                self.has_flown = True
                self._contact_since_s = math.inf
            elif self.pilot.taking_off:
                self._idle_since_s = time_s
            return
        if impact_m_s < 0.0:
            self._contact_since_s = math.inf
            return
        self._contact_since_s = min(self._contact_since_s, time_s)
        meant = self.landed_state is LandedState.LANDING
        if meant or time_s - self._contact_since_s >= SETTLED_S:
            self.landed = True
            self._idle_since_s = time_s
            self.pilot.rest()
            if meant and not self.settings.landed_disarm_delay_s:
                self.disarm()
