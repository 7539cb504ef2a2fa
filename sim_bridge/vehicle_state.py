"""What a vehicle is and tells of itself, whatever it is told to do."""

from __future__ import annotations

import math
from enum import IntEnum

from sim_bridge.battery import Battery
from sim_bridge.beam import Beam
from sim_bridge.clock import SimClock
from sim_bridge.dynamics import Bodies
from sim_bridge.failsafe import BatteryWatch, ControllerWatch, FenceWatch, LeakWatch, PositionWatch
from sim_bridge.fence import breached_part
from sim_bridge.flight_plan import FlightPlan
from sim_bridge.modes import Behaviour, LandedState, ModeTraits
from sim_bridge.parameters import ParameterTable
from sim_bridge.personality import Personality
from sim_bridge.pilot import Pilot
from sim_bridge.reply import StatusText, VehicleSnapshot
from sim_bridge.wording import Wording
from vehicle_agent.domain.frames import Datum, Point


class VehicleState:
    """One vehicle of the fleet, before it takes orders.

    Attributes
    ----------
    personality
        Which autopilot it is.
    booted_us
        Simulated time of its last start.
    mode, armed, landed
        As its heartbeat and its landed state tell; `landed` is true of whatever is not under way.
    home_enu_m
        Where it returns to; None until its origin is known, set anew at every arming.
    origin_enu_m
        Where it first knew its position; None before.
    has_flown, crashed
        Whether it has ever been under way, and whether it hit the ground too fast.
    flight_plan
        Mission, fence and rally points that were uploaded.
    fix_lost, leaking, link_lost
        Faults: no position fix, water in the hull, no bytes in or out.
    beam
        The single beam that it carries; None without one.
    """

    def __init__(
        self,
        index: int,
        bodies: Bodies,
        clock: SimClock,
        personality: Personality,
        parameters: ParameterTable,
        battery: Battery,
        ready_after_s: float,
        datum: Datum,
    ) -> None:
        self.index = index
        self.clock = clock
        self.personality = personality
        self.parameters = parameters
        self.battery = battery
        self.settings = personality.settings(parameters)
        self.pilot = Pilot(bodies, index, self.settings)
        self.armed = False
        self.landed = True
        self.has_flown = False
        self.crashed = False
        self.flight_plan = FlightPlan(datum)
        self.fix_lost = False
        self.leaking = False
        self.link_lost = False
        self.beam: Beam | None = None
        self._bodies = bodies
        self._ready_after_s = ready_after_s
        self._fit_out()
        self._boot()

    def _fit_out(self) -> None:
        """Build what works on the whole vehicle."""

    def _boot(self) -> None:
        """Set what a reboot loses."""
        self.booted_us = self.clock.elapsed_us
        self.mode: IntEnum = self.personality.start_mode
        self.traits: ModeTraits = self.personality.modes[self.mode]
        self.home_enu_m: Point | None = None
        self.origin_enu_m: Point | None = None
        self._using_gps = False
        self._started = False
        self._idle_since_s = 0.0
        self._target_until_s = math.inf
        self._target_heard_s = -math.inf
        self._texts: list[StatusText] = []
        self._controller_watch = ControllerWatch()
        self._battery_watch = BatteryWatch()
        self._fence_watch = FenceWatch()
        self._position_watch = PositionWatch()
        self._leak_watch = LeakWatch()
        self._watches = (
            self._controller_watch, self._battery_watch, self._fence_watch, self._position_watch, self._leak_watch,
        )  # fmt: skip

    @property
    def behaviour(self) -> Behaviour:
        return self.traits.behaviour

    @property
    def position_known(self) -> bool:
        """Whether modes that need a position can be entered."""
        return self._using_gps and not self._position_watch.active

    @property
    def has_fix(self) -> bool:
        """Whether satellites tell where it is."""
        return self.origin_enu_m is not None and not self.fix_lost

    @property
    def ready_to_arm(self) -> bool:
        """Whether arming in guided flight would be accepted, mode aside."""
        return not self.prearm_problems(self.personality.mode_of[Behaviour.GUIDED])

    @property
    def landed_state(self) -> LandedState:
        return LandedState.ON_GROUND if self.landed else LandedState.IN_AIR

    @property
    def failsafe_active(self) -> bool:
        return any(watch.active for watch in self._watches)

    @property
    def heading_deg(self) -> float:
        return float(self._bodies.heading_deg[self.index])

    @property
    def attitude_rad(self) -> tuple[float, float]:
        """Roll and pitch."""
        roll, pitch = self._bodies.attitude_rad[self.index].tolist()
        return (roll, pitch)

    @property
    def true_position_enu_m(self) -> Point:
        """Where it is, whatever it believes."""
        east, north, up = self._bodies.position_enu_m[self.index].tolist()
        return (east, north, up)

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
            behaviour=self.behaviour,
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

    @property
    def wording(self) -> Wording:
        return self.personality.wording

    def say(self, severity: int, text: str) -> None:
        """Queue a status text; an empty one is none."""
        if text:
            self._texts.append(StatusText(severity, text))

    def prearm_problems(self, mode: IntEnum) -> list[str]:
        """Why it would not arm in that flight mode; empty when it would."""
        traits = self.personality.modes[mode]
        problems = []
        if not traits.armable:
            problems.append(f"{traits.title} mode not armable")
        if traits.needs_position and (not self.position_known or not self._started):
            problems.append("Need Position Estimate" if self.home_enu_m else "AHRS: waiting for home")
        if self._controller_watch.active:
            problems.append("GCS failsafe on")
        if self._battery_watch.active:
            problems.append("Battery 1 low capacity failsafe")
        if self.fence_breach() is not None:
            problems.append("Vehicle breaching Fence")
        if self.leaking:
            problems.append("Leak detected")
        if self.crashed:
            problems.append("Crashed, needs repair")
        return problems

    def surface_m(self, east_m: float, north_m: float) -> float:
        """ENU z of the ground at a place, as a terrain database would have it."""
        return self._bodies.surface_m(east_m, north_m)

    def height_error_m(self, upward_m: float) -> float:
        """How much of a height difference to a waypoint counts."""
        return upward_m

    def range_down_m(self) -> float:
        """What its single beam measured last, infinite out of range; without one what a perfect one would."""
        if self.beam is not None and self.beam.reading_m is not None:
            return self.beam.reading_m
        return self.pilot.height_above_ground_m()

    def ground_distance_m(self) -> float | None:
        """What its rangefinder tells it of the ground beneath; None without one, or when that is out of its range."""
        if not self.parameters.get("RNGFND1_TYPE", 0.0):
            return None
        distance_m = self.range_down_m()
        low_cm, high_cm = self.parameters["RNGFND1_MIN_CM"], self.parameters["RNGFND1_MAX_CM"]
        return distance_m if low_cm <= 100.0 * distance_m <= high_cm else None

    def obstacle_distances_m(self, sectors: int, farthest_m: float) -> list[float]:
        """Horizontal distance to the ground around it, clockwise from its nose; `farthest_m` where nothing is."""
        return self._bodies.distances_around_m(self.index, sectors, farthest_m)

    def return_place_enu_m(self) -> Point:
        """Where it returns to from here: home, or a rally point that is nearer."""
        here = self.pilot.position_enu_m
        home_counts = self.parameters.get("RALLY_INCL_HOME", 1.0) == 1.0
        return self.flight_plan.return_place_enu_m(here, self.home_enu_m or here, home_counts)

    def fence_breach(self) -> str | None:
        """Name of the part of its own fence that it breaches; None while it keeps it, or has none."""
        settings = self.settings.fence
        if settings.action is None or self.home_enu_m is None:
            return None
        return breached_part(self.pilot.position_enu_m, self.home_enu_m, settings, self.flight_plan.fence_zones)
