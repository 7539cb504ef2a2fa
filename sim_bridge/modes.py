"""What a vehicle does in a flight mode, apart from how its autopilot numbers and names that mode."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum


class Behaviour(Enum):
    """What an autopilot makes of a flight mode; the pilot's sticks, where they count, are centred."""

    PILOTED = "piloted"
    """Holds what its sticks ask for: nothing."""
    DEPTH_HOLD = "depth hold"
    """Keeps its height and drifts."""
    TRACK_BOTTOM = "track the bottom"
    """Keeps its distance from the ground beneath, as its single beam measures it, and drifts."""
    HOLD = "hold"
    """Stops and stays."""
    BRAKE = "brake"
    """Stops as hard as it can and stays."""
    GUIDED = "guided"
    """Follows targets from a companion computer."""
    AUTO = "auto"
    """Flies the mission that it holds."""
    TAKE_OFF = "take off"
    RETURN = "return"
    LAND = "land"
    SURFACE = "surface"
    STARTING = "starting"


class LandedState(IntEnum):
    """MAVLink's MAV_LANDED_STATE."""

    UNDEFINED = 0
    ON_GROUND = 1
    IN_AIR = 2
    TAKING_OFF = 3
    LANDING = 4


@dataclass(frozen=True, slots=True)
class ModeTraits:
    """What belongs to one flight mode of one autopilot.

    Attributes
    ----------
    title
        As its status texts call it.
    behaviour
        What the vehicle does in it.
    needs_position
        Whether it cannot be entered without a position.
    armable
        Whether the motors may be started in it.
    flown_by_pilot
        Whether failsafes take it for a mode in which a pilot flies.
    """

    title: str
    behaviour: Behaviour
    needs_position: bool = False
    armable: bool = False
    flown_by_pilot: bool = False
