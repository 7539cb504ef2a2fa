"""ArduCopter's flight modes, as far as the simulated copter knows them, and what each demands."""

from __future__ import annotations

from enum import IntEnum


class CopterMode(IntEnum):
    """ArduCopter's `custom_mode` numbers."""

    STABILIZE = 0
    ALT_HOLD = 2
    AUTO = 3
    GUIDED = 4
    LOITER = 5
    RTL = 6
    LAND = 9
    BRAKE = 17


class LandedState(IntEnum):
    """MAVLink's MAV_LANDED_STATE."""

    ON_GROUND = 1
    IN_AIR = 2
    TAKING_OFF = 3
    LANDING = 4


MODE_TITLES = {
    CopterMode.STABILIZE: "STABILIZE",
    CopterMode.ALT_HOLD: "ALT_HOLD",
    CopterMode.AUTO: "AUTO",
    CopterMode.GUIDED: "GUIDED",
    CopterMode.LOITER: "LOITER",
    CopterMode.RTL: "RTL",
    CopterMode.LAND: "LAND",
    CopterMode.BRAKE: "BRAKE",
}
NEEDS_POSITION = frozenset({CopterMode.AUTO, CopterMode.GUIDED, CopterMode.LOITER, CopterMode.RTL, CopterMode.BRAKE})
ARMABLE = frozenset({CopterMode.STABILIZE, CopterMode.ALT_HOLD, CopterMode.GUIDED, CopterMode.LOITER})
PILOTED = frozenset({CopterMode.STABILIZE, CopterMode.ALT_HOLD, CopterMode.LOITER, CopterMode.BRAKE})
"""No autopilot modes in ArduCopter's eyes: by default it leaves them alone when the GCS falls silent."""
