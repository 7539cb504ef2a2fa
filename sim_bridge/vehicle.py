"""One simulated copter: arming, flight modes, orders, battery and failsafes, without any I/O.

It behaves as ArduCopter does wherever the two can be compared; where ArduCopter needs a pilot's sticks, they are
centred. For landing it is taken to carry a rangefinder, so it touches down softly on any ground.
"""

from __future__ import annotations

import math

from sim_bridge.battery import Battery
from sim_bridge.clock import SimClock
from sim_bridge.dynamics import Bodies
from sim_bridge.failsafe import BatteryWatch, ControllerWatch
from sim_bridge.modes import ARMABLE, MODE_TITLES, NEEDS_POSITION, CopterMode, LandedState
from sim_bridge.parameters import ParameterTable
from sim_bridge.pilot import ARRIVED_M, Pilot, ReturnPhase
from sim_bridge.reply import ACCEPTED, Outcome, Reply, StatusText, VehicleSnapshot
from vehicle_agent.domain.frames import Point

TOUCHDOWN_LIMIT_M_S = 2.0
"""Fastest contact with the ground that a copter survives."""
LIFTED_OFF_M = 0.3
FARTHEST_M = 1e6
"""Targets and homes beyond this are none."""
SETTLED_S = 1.0
"""Contact for this long counts as having landed, whatever the flight mode."""
ORIGIN_SHARE = 0.6
"""The position is known after this share of the time until arming is accepted."""


class Copter:
    """One vehicle of the fleet.

    Attributes
    ----------
    mode, armed, landed
        As its heartbeat and its landed state tell.
    home_enu_m
        Where it returns to; None until its position is known, set anew at every arming.
    origin_enu_m
        Where it first knew its position; None before.
    has_flown, crashed
        Whether it has ever left the ground, and whether it hit it too fast.
    """

    def __init__(
        self, index: int, bodies: Bodies, clock: SimClock, parameters: ParameterTable, battery: Battery,
        ready_after_s: float,
    ) -> None:  # fmt: skip
        self.index = index
        self.clock = clock
        self.parameters = parameters
        self.battery = battery
        self.pilot = Pilot(bodies, index, parameters)
        self.mode = CopterMode.STABILIZE
        self.armed = False
        self.landed = True
        self.has_flown = False
        self.crashed = False
        self.home_enu_m: Point | None = None
        self.origin_enu_m: Point | None = None
        self._bodies = bodies
        self._ready_after_s = ready_after_s
        self._ready_announced = False
        self._grounded_since_s = 0.0
        self._contact_since_s = math.inf
        self._velocity_until_s = math.inf
        self._texts: list[StatusText] = []
        self._controller_watch = ControllerWatch()
        self._battery_watch = BatteryWatch()

    # What it tells

    @property
    def position_known(self) -> bool:
        return self.home_enu_m is not None

    @property
    def ready_to_arm(self) -> bool:
        """Whether arming in guided flight would be accepted, mode aside."""
        return not self.prearm_problems(CopterMode.GUIDED)

    @property
    def landed_state(self) -> LandedState:
        if self.landed:
            return LandedState.ON_GROUND
        if self.pilot.taking_off:
            return LandedState.TAKING_OFF
        if self.mode is CopterMode.LAND or self.pilot.return_phase is ReturnPhase.DESCEND:
            return LandedState.LANDING
        return LandedState.IN_AIR

    @property
    def failsafe_active(self) -> bool:
        return self._controller_watch.active or self._battery_watch.active

    @property
    def heading_deg(self) -> float:
        return float(self._bodies.heading_deg[self.index])

    @property
    def snapshot(self) -> VehicleSnapshot:
        return VehicleSnapshot(
            time_s=self.clock.time_s,
            stamp_ms=self.clock.unix_ms,
            position_enu_m=self.pilot.position_enu_m,
            velocity_enu_m_s=self.pilot.velocity_enu_m_s,
            heading_deg=self.heading_deg,
            armed=self.armed,
            landed=self.landed_state,
            mode=self.mode,
            battery_fraction=self.battery.remaining,
            home_enu_m=self.home_enu_m,
            ready_to_arm=self.ready_to_arm,
            has_flown=self.has_flown,
            crashed=self.crashed,
        )

    def drain_texts(self) -> list[StatusText]:
        """Take the status texts said since the last call."""
        texts, self._texts[:] = list(self._texts), []
        return texts

    def say(self, severity: int, text: str) -> None:
        self._texts.append(StatusText(severity, text))

    def prearm_problems(self, mode: CopterMode) -> list[str]:
        """Why it would not arm in that flight mode; empty when it would."""
        problems = []
        if mode not in ARMABLE:
            problems.append(f"{MODE_TITLES[mode]} mode not armable")
        if mode in NEEDS_POSITION and (not self.position_known or self.clock.time_s < self._ready_after_s):
            problems.append("Need Position Estimate")
        if self._controller_watch.active:
            problems.append("GCS failsafe on")
        if self._battery_watch.active:
            problems.append("Battery 1 low capacity failsafe")
        if self.crashed:
            problems.append("Crashed, needs repair")
        return problems

    # Orders of an agent: what a ground station's `arm`, `takeoff`, `goto` ... amount to

    def arm(self) -> Reply:
        """Switch to guided flight and start the motors."""
        mode = self.set_mode(CopterMode.GUIDED)
        return self.arm_motors() if mode.accepted else mode

    def take_off(self, height_m: float) -> Reply:
        """Switch to guided flight and climb straight up to a height above home."""
        mode = self.set_mode(CopterMode.GUIDED)
        return self.start_takeoff(height_m) if mode.accepted else mode

    def go_to(self, position_enu_m: Point) -> Reply:
        """Switch to guided flight, fly straight to a point and stay there."""
        mode = self.set_mode(CopterMode.GUIDED)
        return self.set_destination(position_enu_m) if mode.accepted else mode

    def hold(self) -> Reply:
        """Stop and stay (LOITER, which is what MAVSDK's hold asks for)."""
        return self.set_mode(CopterMode.LOITER)

    def return_home(self) -> Reply:
        return self.set_mode(CopterMode.RTL)

    def land(self) -> Reply:
        return self.set_mode(CopterMode.LAND)

    # What an autopilot does when it is told to

    def set_mode(self, number: int) -> Reply:
        """Change the flight mode by ArduCopter's number."""
        try:
            mode = CopterMode(number)
        except ValueError:
            return self._refuse(4, f"No such mode {number}")
        if mode is self.mode:
            return ACCEPTED
        if mode is CopterMode.AUTO:
            return self._refuse(4, "Mode change to AUTO failed: init failed")
        if mode in NEEDS_POSITION and not self.position_known:
            return self._refuse(4, f"Mode change to {MODE_TITLES[mode]} failed: requires position")
        self.mode = mode
        self.pilot.begin_mode()
        if self.armed and not self.landed:
            self._enter_mode_in_flight()
        elif self.landed:
            self.pilot.rest()
        return ACCEPTED

    def _enter_mode_in_flight(self) -> None:
        if self.mode is CopterMode.RTL:
            assert self.home_enu_m is not None
            self.pilot.begin_return(self.home_enu_m)
        elif self.mode is CopterMode.LAND:
            self.pilot.begin_landing()
        else:
            self.pilot.stop()

    def arm_motors(self, force: bool = False) -> Reply:
        """Start the motors in the present flight mode; home becomes where it stands."""
        if self.armed:
            return ACCEPTED
        problems = [] if force and not self.crashed else self.prearm_problems(self.mode)
        if problems:
            for problem in problems:
                self.say(2, f"Arm: {problem}")
            return Reply(Outcome.FAILED, f"Arm: {problems[0]}")
        self.armed = True
        self._grounded_since_s = self.clock.time_s
        if self.position_known:
            self.home_enu_m = self.pilot.position_enu_m
        self.say(6, "Arming motors")
        return ACCEPTED

    def disarm(self, force: bool = False) -> Reply:
        """Stop the motors; refused in flight unless forced."""
        if self.armed and not self.landed and not force:
            return Reply(Outcome.FAILED, "Disarm: in flight")
        if self.armed:
            self.armed = False
            self.pilot.begin_mode()
            self.pilot.rest()
            self.say(6, "Disarming motors")
        return ACCEPTED

    def start_takeoff(self, height_m: float) -> Reply:
        """Climb straight up to a height above home; needs guided flight, running motors and the ground."""
        if self.mode is not CopterMode.GUIDED or not self.armed or not self.landed or self.home_enu_m is None:
            return Reply(Outcome.FAILED, "Takeoff needs guided flight, armed and on the ground")
        up_m = self.home_enu_m[2] + height_m
        if not abs(up_m) <= FARTHEST_M or up_m <= self.pilot.position_enu_m[2] + LIFTED_OFF_M:
            return Reply(Outcome.FAILED, "Takeoff altitude is below the vehicle, or no altitude")
        self.pilot.climb_to(up_m)
        return ACCEPTED

    def set_destination(self, position_enu_m: Point) -> Reply:
        """Take a guided target; on the ground it is accepted and, as by ArduCopter, nothing moves."""
        if not is_place(position_enu_m):
            return Reply(Outcome.DENIED, "Target is no position")
        if self.mode is not CopterMode.GUIDED:
            return Reply(Outcome.FAILED, "Target needs guided flight")
        self.pilot.taking_off = False
        if self.armed and not self.landed:
            self.pilot.fly_to(position_enu_m)
        elif self.landed:
            self.pilot.rest()
        return ACCEPTED

    def set_velocity(self, velocity_enu_m_s: Point) -> Reply:
        """Take a guided velocity; it is flown for GUID_TIMEOUT seconds unless told again."""
        if not all(math.isfinite(component) for component in velocity_enu_m_s):
            return Reply(Outcome.DENIED, "Target is no velocity")
        if self.mode is not CopterMode.GUIDED or not self.armed or self.landed:
            return Reply(Outcome.FAILED, "Velocity needs guided flight in the air")
        self.pilot.taking_off = False
        self.pilot.fly_with(velocity_enu_m_s)
        self._velocity_until_s = self.clock.time_s + self.parameters["GUID_TIMEOUT"]
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
            return Reply(Outcome.DENIED, f"There is no parameter {name}, or {value} is no number")
        self.pilot.refresh_limits()
        return ACCEPTED

    def set_home(self, position_enu_m: Point) -> Reply:
        """Return to another place until the next arming."""
        if not self.position_known or not is_place(position_enu_m):
            return Reply(Outcome.DENIED, "Home is no position, or the position is not known yet")
        self.home_enu_m = position_enu_m
        return ACCEPTED

    def heard_controller(self, system_id: int) -> Reply:
        """Note a heartbeat of some controller; only that of SYSID_MYGCS is watched."""
        if system_id == int(self.parameters["SYSID_MYGCS"]):
            self._controller_watch.heard(self.clock.time_s)
        return ACCEPTED

    # What it does by itself

    def update(self, dt_s: float) -> None:
        """Carry on after the body has moved by one step."""
        time_s = self.clock.time_s
        impact_m_s = float(self._bodies.impact_m_s[self.index])
        if impact_m_s > TOUCHDOWN_LIMIT_M_S and not self.landed:
            self._crash()
        self.battery.drain(dt_s, self.armed, not self.landed, self.parameters["BATT_CAPACITY"])
        self._note_readiness(time_s)
        if self.armed or not self.landed:
            self._note_ground(impact_m_s, time_s)
        if self.armed and not self.landed:
            self._fly(time_s)
        self._controller_watch.check(self)
        self._battery_watch.check(self)
        delay_s = self.parameters["DISARM_DELAY"]
        idle = self.armed and self.landed and not self.pilot.taking_off
        if idle and delay_s > 0 and time_s - self._grounded_since_s >= delay_s:
            self.disarm()

    def _fly(self, time_s: float) -> None:
        if self.battery.remaining <= 0.0:
            self.pilot.rest()
        elif self.mode is CopterMode.RTL:
            self.pilot.fly_return(time_s)
        elif self.mode is CopterMode.LAND:
            self.pilot.descend()
        elif self.pilot.taking_off:
            target = self.pilot.target_enu_m
            self.pilot.taking_off = target is not None and target[2] - self.pilot.position_enu_m[2] > ARRIVED_M
        elif self.pilot.flies_with_velocity and time_s > self._velocity_until_s:
            self.pilot.stop()

    def _note_ground(self, impact_m_s: float, time_s: float) -> None:
        """Tell lift-off and landing from height and contact."""
        if self.landed:
            if self.pilot.height_above_ground_m() > LIFTED_OFF_M:
                self.landed = False
                self.has_flown = True
                self._contact_since_s = math.inf
            elif self.pilot.taking_off:
                self._grounded_since_s = time_s
            return
        if impact_m_s < 0.0:
            self._contact_since_s = math.inf
            return
        self._contact_since_s = min(self._contact_since_s, time_s)
        meant = self.landed_state is LandedState.LANDING
        if meant or time_s - self._contact_since_s >= SETTLED_S:
            self.landed = True
            self._grounded_since_s = time_s
            self.pilot.rest()
            if meant:
                self.disarm()

    def _crash(self) -> None:
        self.crashed = True
        self.landed = True
        self.say(0, "Crash: Disarming")
        self.disarm(force=True)
        self.pilot.rest()

    def _note_readiness(self, time_s: float) -> None:
        if self.home_enu_m is None and time_s >= ORIGIN_SHARE * self._ready_after_s:
            self.home_enu_m = self.origin_enu_m = self.pilot.position_enu_m
            self.say(6, "EKF3 IMU0 origin set")
        if not self._ready_announced and time_s >= self._ready_after_s:
            self._ready_announced = True
            self.say(6, "EKF3 IMU0 is using GPS")

    def _refuse(self, severity: int, text: str) -> Reply:
        self.say(severity, text)
        return Reply(Outcome.FAILED, text)


def is_place(position_enu_m: Point) -> bool:
    """Whether a vehicle could be there; False for NaN and infinity too."""
    return all(abs(coordinate) <= FARTHEST_M for coordinate in position_enu_m)
