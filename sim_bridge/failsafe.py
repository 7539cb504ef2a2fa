"""The copter's failsafes, with ArduCopter's conditions, texts and parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from sim_bridge.modes import PILOTED, CopterMode, LandedState

if TYPE_CHECKING:
    from sim_bridge.vehicle import Copter

CONTINUE_IF_LANDING = 8
CONTINUE_IF_PILOTED = 16
"""Bits of FS_OPTIONS."""
_WARNING = 4
_GCS_ACTIONS = {4: CopterMode.LAND, 5: CopterMode.LAND, 7: CopterMode.BRAKE}
"""FS_GCS_ENABLE to flight mode; every other value but 0 returns home."""
_BATTERY_ACTIONS = {1: CopterMode.LAND, 2: CopterMode.RTL, 3: CopterMode.RTL, 4: CopterMode.RTL}


@dataclass(slots=True)
class ControllerWatch:
    """Watches the heartbeats of the system SYSID_MYGCS, once it has been heard (ArduCopter's GCS failsafe)."""

    active: bool = False
    last_heard_s: float | None = None

    def heard(self, time_s: float) -> None:
        self.last_heard_s = time_s

    def check(self, copter: Copter) -> None:
        enabled = int(copter.parameters["FS_GCS_ENABLE"])
        if enabled == 0 or self.last_heard_s is None:
            return
        silent_s = copter.clock.time_s - self.last_heard_s
        timeout_s = copter.parameters["FS_GCS_TIMEOUT"]
        if silent_s < timeout_s and self.active:
            self.active = False
            copter.say(_WARNING, "GCS Failsafe Cleared")
        elif silent_s > timeout_s and not self.active:
            self.active = True
            act(copter, "GCS", _GCS_ACTIONS.get(enabled, CopterMode.RTL))


@dataclass(slots=True)
class BatteryWatch:
    """Returns home on a low battery and lands on a critical one; each once."""

    level: int = 0
    """0 good, 1 low, 2 critical."""

    @property
    def active(self) -> bool:
        return self.level > 0

    def check(self, copter: Copter) -> None:
        parameters = copter.parameters
        left_mah = copter.battery.remaining * parameters["BATT_CAPACITY"]
        level = 2 if left_mah < parameters["BATT_CRT_MAH"] else 1 if left_mah < parameters["BATT_LOW_MAH"] else 0
        if level <= self.level:
            return
        self.level = level
        word, name = (("critical", "BATT_FS_CRT_ACT"), ("low", "BATT_FS_LOW_ACT"))[0 if level == 2 else 1]
        used_mah = (1.0 - copter.battery.remaining) * parameters["BATT_CAPACITY"]
        copter.say(_WARNING, f"Battery 1 is {word} {copter.battery.voltage_v:.2f}V used {used_mah:.0f} mAh")
        act(copter, "Battery", _BATTERY_ACTIONS.get(int(parameters[name])))


def act(copter: Copter, name: str, mode: CopterMode | None) -> None:
    """Announce a failsafe and do what it asks for, with ArduCopter's exceptions."""
    options = int(copter.parameters["FS_OPTIONS"])
    if not copter.armed:
        copter.say(_WARNING, f"{name} Failsafe")
    elif copter.landed:
        copter.say(_WARNING, f"{name} Failsafe - Disarming")
        copter.disarm()
    elif copter.landed_state is LandedState.LANDING and options & CONTINUE_IF_LANDING:
        copter.say(_WARNING, f"{name} Failsafe - Continuing Landing")
    elif name == "GCS" and copter.mode in PILOTED and options & CONTINUE_IF_PILOTED:
        copter.say(_WARNING, f"{name} Failsafe - Continuing Pilot Control")
    else:
        copter.say(_WARNING, f"{name} Failsafe")
        if mode is not None and not copter.set_mode(mode).accepted:
            copter.set_mode(CopterMode.LAND)
