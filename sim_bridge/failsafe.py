"""Failsafes: what each watches for, when it trips, and what is done then, in ArduPilot's words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from sim_bridge.modes import LandedState
from sim_bridge.personality import ACTION_BEHAVIOURS, Action

if TYPE_CHECKING:
    from sim_bridge.vehicle import Vehicle

_CRITICAL = 2
_WARNING = 4
_NOTICE = 5
FENCE_PERIOD_S = 0.2
LEAK_REMINDER_S = 20.0
LOST_POSITION_S = 5.0
"""Dead reckoning for longer than this is no position."""


@dataclass(slots=True)
class ControllerWatch:
    """Watches the heartbeats of the controlling system, once it has been heard."""

    active: bool = False
    last_heard_s: float | None = None

    def heard(self, time_s: float) -> None:
        self.last_heard_s = time_s

    def check(self, vehicle: Vehicle, time_s: float) -> None:
        settings = vehicle.settings
        if settings.controller_action is None or self.last_heard_s is None:
            return
        silent_s = time_s - self.last_heard_s
        if silent_s < settings.controller_timeout_s and self.active:
            self.active = False
            vehicle.say(_WARNING, vehicle.wording.controller_back)
        elif silent_s > settings.controller_timeout_s and not self.active:
            self.active = True
            act(vehicle, "GCS", settings.controller_action)


@dataclass(slots=True)
class BatteryWatch:
    """Acts on a low battery and on a critical one; each once."""

    level: int = 0
    """0 good, 1 low, 2 critical."""

    @property
    def active(self) -> bool:
        return self.level > 0

    def check(self, vehicle: Vehicle, time_s: float) -> None:
        settings, battery = vehicle.settings, vehicle.battery
        left_mah = battery.remaining * settings.capacity_mah
        level = 2 if left_mah < settings.critical_mah else 1 if left_mah < settings.low_mah else 0
        if level <= self.level:
            return
        self.level = level
        action = settings.critical_battery_action if level == 2 else settings.low_battery_action
        text = vehicle.wording.battery_critical if level == 2 else vehicle.wording.battery_low
        used_mah = (1.0 - battery.remaining) * settings.capacity_mah
        vehicle.say(_WARNING, text.format(volts=battery.voltage_v, milliampere_hours=used_mah))
        act(vehicle, "Battery", action)


@dataclass(slots=True)
class FenceWatch:
    """Acts when the vehicle leaves its fence, anew at every new breach."""

    breached: str | None = None
    _due_s: float = 0.0

    @property
    def active(self) -> bool:
        return self.breached is not None

    def check(self, vehicle: Vehicle, time_s: float) -> None:
        settings = vehicle.settings.fence
        if settings.action is None:
            self.breached = None
            return
        if time_s < self._due_s:
            return
        self._due_s = time_s + FENCE_PERIOD_S - 1e-6
        part = vehicle.fence_breach()
        if part == self.breached:
            return
        if part is None:
            vehicle.say(_NOTICE, vehicle.wording.fence_cleared.format(part=self.breached))
        elif vehicle.armed and not vehicle.landed:
            vehicle.say(_NOTICE, vehicle.wording.fence_breached.format(part=part))
            if settings.action is not Action.WARN:
                take(vehicle, settings.action)
        else:
            return
        self.breached = part


@dataclass(slots=True)
class PositionWatch:
    """Acts when the vehicle has had no position fix for too long while a mode needs one."""

    active: bool = False
    _since_s: float | None = None

    def check(self, vehicle: Vehicle, time_s: float) -> None:
        if not vehicle.fix_lost:
            if self.active:
                vehicle.say(_WARNING, vehicle.wording.position_back)
            self.active, self._since_s = False, None
            return
        if self._since_s is None:
            self._since_s = time_s
        if self.active or time_s - self._since_s < LOST_POSITION_S:
            return
        self.active = True
        if not vehicle.armed or vehicle.landed or not vehicle.traits.needs_position:
            return
        vehicle.say(_CRITICAL, vehicle.wording.position_lost)
        action = vehicle.settings.lost_position_action
        if action is None or action is Action.WARN:
            vehicle.say(_CRITICAL, vehicle.wording.failsafe.format(name="EKF", outcome=""))
            return
        take(vehicle, action)
        vehicle.say(_CRITICAL, vehicle.wording.position_failsafe.format(title=vehicle.traits.title))


@dataclass(slots=True)
class LeakWatch:
    """Acts on water inside the hull; the warning comes again every `LEAK_REMINDER_S`."""

    active: bool = False
    _due_s: float = 0.0

    def check(self, vehicle: Vehicle, time_s: float) -> None:
        if not vehicle.leaking:
            self.active = False
            return
        action = vehicle.settings.leak_action
        if action is None:
            return
        if time_s >= self._due_s:
            self._due_s = time_s + LEAK_REMINDER_S
            vehicle.say(_CRITICAL, "Leak Detected")
        if not self.active:
            self.active = True
            if vehicle.armed and action is not Action.WARN:
                take(vehicle, action)


def act(vehicle: Vehicle, name: str, action: Action | None) -> None:
    """Announce a failsafe and do what it asks for, with ArduCopter's exceptions."""
    settings = vehicle.settings

    def announce(outcome: str = "") -> None:
        vehicle.say(_WARNING, vehicle.wording.failsafe.format(name=name, outcome=outcome))

    if not vehicle.armed:
        announce()
    elif vehicle.landed:
        announce(" - Disarming")
        vehicle.disarm()
    elif vehicle.landed_state is LandedState.LANDING and settings.continue_landing:
        announce(" - Continuing Landing")
    elif name == "GCS" and vehicle.traits.flown_by_pilot and settings.continue_piloted:
        announce(" - Continuing Pilot Control")
    else:
        announce()
        take(vehicle, action)


def take(vehicle: Vehicle, action: Action | None) -> None:
    """Change to the mode of an action, or to the vehicle's last resort when that cannot be entered."""
    if action is None or action is Action.WARN:
        return
    if action is Action.DISARM:
        vehicle.disarm(force=True)
        return
    behaviour = ACTION_BEHAVIOURS[action]
    if not vehicle.enter(behaviour).accepted:
        vehicle.enter(vehicle.last_resort)
