"""What all simulated vehicles have in common: arming, flight modes, orders, start-up and failsafes; no I/O.

How a kind of vehicle moves stands in `sim_bridge.vehicles`, what differs between autopilots in
`sim_bridge.personalities`. Where a pilot's sticks count they are centred.
"""

from __future__ import annotations

import math

from sim_bridge.auto_flight import AutoFlight, MissionState
from sim_bridge.failsafe import take
from sim_bridge.modes import Behaviour, ModeTraits
from sim_bridge.reply import ACCEPTED, Outcome, Reply
from sim_bridge.vehicle_state import VehicleState
from vehicle_agent.domain.frames import Point

FARTHEST_M = 1e6
"""Targets and homes beyond this are none."""
STARTING_SHARE = 0.06
ORIGIN_SHARE = 0.4
USING_GPS_SHARE = 0.82
"""Shares of the time until arming is accepted: sensors calibrated, origin set, position counts."""


class Vehicle(VehicleState):
    """One vehicle of the fleet: takes orders, and looks after itself.

    Attributes
    ----------
    auto_flight
        How far the mission has come.
    """

    last_resort = Behaviour.LAND
    """What a failsafe does when its action cannot be done."""
    impact_limit_m_s = 2.0
    """Fastest contact with the ground that it survives."""

    def _fit_out(self) -> None:
        self.auto_flight = AutoFlight(self, self.flight_plan)

    def reboot(self) -> None:
        """Begin anew, as after switching off and on: parameters, plans, charge and damage stay."""
        self.disarm(force=True)
        self.auto_flight.stop()
        self.auto_flight.reset()
        self._boot()
        self.pilot.begin_mode()
        self.pilot.rest()

    # Orders of an agent: what a ground station's `arm`, `takeoff`, `goto` ... amount to

    def arm(self) -> Reply:
        """Switch to guided flight and start the motors."""
        mode = self.enter(Behaviour.GUIDED)
        return self.arm_motors() if mode.accepted else mode

    def take_off(self, height_m: float) -> Reply:
        """Switch to guided flight and climb straight up to a height above home."""
        mode = self.enter(Behaviour.GUIDED)
        return self.start_takeoff(height_m) if mode.accepted else mode

    def go_to(self, position_enu_m: Point) -> Reply:
        """Switch to guided flight, go straight to a point and stay there."""
        mode = self.enter(self.personality.guided_behaviour)
        return self.set_destination(position_enu_m) if mode.accepted else mode

    def hold(self) -> Reply:
        """Stop and stay."""
        return self.enter(Behaviour.HOLD)

    def return_home(self) -> Reply:
        return self.enter(Behaviour.RETURN)

    def land(self) -> Reply:
        return self.enter(Behaviour.LAND)

    # What an autopilot does when it is told to

    def enter(self, behaviour: Behaviour) -> Reply:
        """Change to the mode that this autopilot has for a behaviour."""
        mode = self.personality.mode_of.get(behaviour)
        if mode is None:
            return Reply(Outcome.UNSUPPORTED, f"{self.personality.name} has no mode to {behaviour.value}")
        return self.set_mode(mode)

    def set_mode(self, number: int) -> Reply:
        """Change the flight mode by the autopilot's own number."""
        mode = self.personality.mode(number)
        if mode is None:
            return self._refuse(4, f"No such mode {number}")
        if mode is self.mode:
            return ACCEPTED
        traits = self.personality.modes[mode]
        reason = self._refusal_of(traits)
        if reason is not None:
            return self._refuse(4, self.wording.mode_refused.format(title=traits.title, reason=reason))
        if self.behaviour is Behaviour.AUTO:
            self.auto_flight.stop()
        self.mode, self.traits = mode, traits
        self._target_until_s = math.inf
        self.pilot.begin_mode()
        if self.armed and not self.landed:
            self._begin(traits.behaviour)
        elif self.landed:
            self.pilot.rest()
        return ACCEPTED

    def _refusal_of(self, traits: ModeTraits) -> str | None:
        """Why that mode cannot be entered now; None when it can."""
        if traits.behaviour is Behaviour.AUTO:
            if self.auto_flight.state is MissionState.NO_MISSION:
                return "init failed"
            if self.armed and self.landed and not self.auto_flight.starts_with_takeoff:
                self.say(2, "Auto: Missing Takeoff Cmd")
                return "init failed"
        if traits.needs_position and not self.position_known:
            return "requires position"
        fresh_s = self.clock.time_s - self._target_heard_s
        if (
            self.personality.fresh_targets_first
            and traits.behaviour is Behaviour.GUIDED
            and fresh_s > self.settings.target_timeout_s
        ):
            return "no targets"
        return None

    def _begin(self, behaviour: Behaviour) -> None:
        """Start what a mode does, while under way."""
        if behaviour is Behaviour.AUTO:
            self.auto_flight.start()
        else:
            self.pilot.stop()

    def start_mission(self) -> Reply:
        """Fly the mission, from the ground too."""
        if self.auto_flight.state is MissionState.NO_MISSION:
            return Reply(Outcome.FAILED, "There is no mission")
        mode = self.enter(Behaviour.AUTO)
        if not mode.accepted:
            return mode
        if not self.armed:
            return Reply(Outcome.FAILED, "A mission needs running motors")
        if not self.auto_flight.running:
            self.auto_flight.start()
        return ACCEPTED

    def arm_motors(self, force: bool = False) -> Reply:
        """Start the motors in the present flight mode; home becomes where it is."""
        if self.armed:
            return ACCEPTED
        problems = [] if force and not self.crashed else self.prearm_problems(self.mode)
        if problems:
            for problem in problems:
                self.say(2, self.wording.arming_refused.format(problem=problem))
            return Reply(Outcome.FAILED, self.wording.arming_refused.format(problem=problems[0]))
        self.armed = True
        self._idle_since_s = self.clock.time_s
        if self.home_enu_m is not None:
            self.home_enu_m = self._home_here()
        self.say(6, self.wording.armed)
        self._on_armed()
        return ACCEPTED

    def _home_here(self) -> Point:
        return self.pilot.position_enu_m

    def _on_armed(self) -> None:
        """Called when the motors have started."""

    def disarm(self, force: bool = False) -> Reply:
        """Stop the motors; refused in flight unless forced."""
        if self.armed and not self.landed and not force and not self._may_disarm():
            return Reply(Outcome.FAILED, "Disarm: in flight")
        if self.armed:
            self.armed = False
            self.pilot.begin_mode()
            self.pilot.rest()
            self.auto_flight.motors_stopped()
            self.say(6, self.wording.disarmed)
            self._on_disarmed()
        return ACCEPTED

    def _may_disarm(self) -> bool:
        """Whether the motors may stop while it is under way."""
        return False

    def _on_disarmed(self) -> None:
        """Called when the motors have stopped."""

    def start_takeoff(self, height_m: float) -> Reply:
        """Climb straight up to a height above home; NaN: the height of the settings."""
        return Reply(Outcome.UNSUPPORTED, "It does not take off")

    def set_destination(self, position_enu_m: Point) -> Reply:
        """Take a guided target; on the ground it is accepted and, as by ArduCopter, nothing moves."""
        if not is_place(position_enu_m):
            return Reply(Outcome.DENIED, "Target is no position")
        self._target_heard_s = self.clock.time_s
        if self.behaviour not in (Behaviour.GUIDED, self.personality.guided_behaviour):
            return Reply(Outcome.FAILED, "Target needs guided flight")
        self.pilot.taking_off = False
        if self.armed and not self.landed:
            self.pilot.fly_to(self._within_reach(position_enu_m))
        elif self.landed:
            self.pilot.rest()
        if self.settings.positions_expire and self.behaviour is Behaviour.GUIDED:
            self._target_until_s = self.clock.time_s + self.settings.target_timeout_s
        return ACCEPTED

    def _within_reach(self, position_enu_m: Point) -> Point:
        """The nearest place that this kind of vehicle can be at."""
        return position_enu_m

    def note_target(self) -> None:
        """A target has come that the present mode does not follow."""
        self._target_heard_s = self.clock.time_s

    def set_velocity(self, velocity_enu_m_s: Point) -> Reply:
        """Take a guided velocity; it is flown until it times out unless told again."""
        if not all(math.isfinite(component) for component in velocity_enu_m_s):
            return Reply(Outcome.DENIED, "Target is no velocity")
        self._target_heard_s = self.clock.time_s
        if self.behaviour is not Behaviour.GUIDED or not self.armed or self.landed:
            return Reply(Outcome.FAILED, "Velocity needs guided flight in the air")
        self.pilot.taking_off = False
        self.pilot.fly_with(velocity_enu_m_s)
        self._target_until_s = self.clock.time_s + self.settings.target_timeout_s
        return ACCEPTED

    def set_speed(self, speed_m_s: float) -> Reply:
        """Limit the speed over ground until the flight mode changes."""
        if not (math.isfinite(speed_m_s) and speed_m_s > 0):
            return Reply(Outcome.DENIED, "Speed must be positive")
        self.pilot.commanded_speed_m_s = speed_m_s
        self.pilot.refresh_limits()
        return ACCEPTED

    def set_parameter(self, name: str, value: float) -> Reply:
        if not self.parameters.set(name, value):
            return Reply(Outcome.DENIED, f"There is no parameter {name}, or {value} is no value for it")
        self.settings = self.pilot.settings = self.personality.settings(self.parameters)
        self.pilot.refresh_limits()
        return ACCEPTED

    def set_home(self, position_enu_m: Point) -> Reply:
        """Return to another place until the next arming."""
        if self.home_enu_m is None or not is_place(position_enu_m):
            return Reply(Outcome.DENIED, "Home is no position, or the position is not known yet")
        self.home_enu_m = position_enu_m
        return ACCEPTED

    def break_motors(self, broken: bool) -> None:
        """Let the motors fail, or mend them: then they pull again at the next order."""
        self.pilot.broken = broken
        if broken:
            self.pilot.rest()
            if self.armed:
                self.say(0, "Potential Thrust Loss (1)")

    def set_origin(self, position_enu_m: Point) -> Reply:
        """Take the estimator's origin from a client; refused once there is one."""
        if self.origin_enu_m is not None or not is_place(position_enu_m):
            return Reply(Outcome.DENIED, "There is an origin already, or it is no position")
        self.origin_enu_m = position_enu_m
        return ACCEPTED

    def heard_controller(self, system_id: int) -> Reply:
        """Note a heartbeat of some controller; only that of the controlling system is watched."""
        if self.settings.controller_id in (None, system_id):
            self._controller_watch.heard(self.clock.time_s)
        return ACCEPTED

    # What it does by itself

    def update(self, dt_s: float) -> None:
        """Carry on after the body has moved by one step."""
        time_s = self.clock.time_s
        impact_m_s = self._bodies.impacts_m_s[self.index]
        if impact_m_s > self.impact_limit_m_s and not self.crashed and self._hits():
            self._crash()
        self.battery.drain(dt_s, self._load(), self.settings.capacity_mah)
        if not self._started:
            self._start_up(time_s - self.booted_us * 1e-6)
        if self.armed or not self.landed:
            self._note_ground(impact_m_s, time_s)
            if self.armed and not self.landed:
                self._steer(time_s)
        for watch in self._watches:
            watch.check(self, time_s)
        if self.armed and self.landed and not self.pilot.taking_off:
            delay_s = self.settings.landed_disarm_delay_s if self.has_flown else 0.0
            delay_s = delay_s or self.settings.disarm_delay_s
            if 0 < delay_s <= time_s - self._idle_since_s:
                self.disarm()

    def _load(self) -> float:
        """Draw on the battery, as a share of that for which its endurance is given."""
        return 1.0 if self.armed else 0.0

    def _hits(self) -> bool:
        """Whether a contact with the ground counts as a crash."""
        return not self.landed

    def _note_ground(self, impact_m_s: float, time_s: float) -> None:
        """Tell what contact with the ground means."""

    def _steer(self, time_s: float) -> None:
        """Carry the present behaviour on by one step."""
        if self.battery.remaining <= 0.0:
            self.pilot.rest()
        elif self.behaviour is Behaviour.AUTO:
            self.auto_flight.update(time_s)
        elif time_s > self._target_until_s:
            self._target_until_s = math.inf
            self._target_expired()

    def _target_expired(self) -> None:
        action = self.settings.expired_target_action
        if action is None:
            self.pilot.stop()
        else:
            self.say(2, self.wording.failsafe.format(name="Offboard", outcome=""))
            take(self, action)

    def hit_building(self) -> None:
        """Its body has touched something that is no ground: it never flies again."""
        if not self.crashed:
            self._crash()

    def _crash(self) -> None:
        self.crashed = True
        self.landed = True
        self.say(0, self.wording.crashed)
        self.disarm(force=True)
        self.pilot.rest()

    def _start_up(self, time_s: float) -> None:
        """Carry on with starting up, `time_s` after the boot."""
        if self.home_enu_m is None and time_s >= ORIGIN_SHARE * self._ready_after_s:
            self.origin_enu_m = self.origin_enu_m or self.pilot.position_enu_m
            self.home_enu_m = self._home_here()
            self.say(6, self.wording.origin_set)
        after = self.personality.mode_after_start
        if (
            after is not None
            and self.behaviour is Behaviour.STARTING
            and time_s >= STARTING_SHARE * self._ready_after_s
        ):
            self.set_mode(after)
        if not self._using_gps and time_s >= USING_GPS_SHARE * self._ready_after_s:
            self._using_gps = True
            self.say(6, self.wording.position_used)
        self._started = time_s >= self._ready_after_s

    def _refuse(self, severity: int, text: str) -> Reply:
        self.say(severity, text)
        return Reply(Outcome.FAILED, text)


def is_place(position_enu_m: Point) -> bool:
    """Whether a vehicle could be there; False for NaN and infinity too."""
    return all(abs(coordinate) <= FARTHEST_M for coordinate in position_enu_m)
