"""What can be asked of an autopilot over MAVLink, as plain data."""

from __future__ import annotations

from dataclasses import dataclass

COMMAND_DO_SET_MODE = 176
COMMAND_NAV_RETURN = 20
COMMAND_NAV_LAND = 21
COMMAND_NAV_TAKEOFF = 22
COMMAND_DO_CHANGE_SPEED = 178
COMMAND_DO_REPOSITION = 192
COMMAND_ARM_DISARM = 400
COMMAND_SET_MESSAGE_INTERVAL = 511
COMMAND_REQUEST_MESSAGE = 512

FRAME_GLOBAL_INT = 5
"""MAV_FRAME_GLOBAL_INT: degrees x 1e7 and metres above mean sea level."""


@dataclass(frozen=True, slots=True)
class CommandRequest:
    """A MAV_CMD, answered by a COMMAND_ACK.

    Attributes
    ----------
    command
        MAV_CMD.
    parameters
        param1 ... param7 of COMMAND_LONG; for COMMAND_INT param1 ... param4.
    position
        Makes it a COMMAND_INT: latitude and longitude in degrees x 1e7, altitude above mean sea level in metres.
    label
        What it does, for sentences: "arm", "switch to GUIDED".
    """

    command: int
    label: str
    parameters: tuple[float, ...] = ()
    position: tuple[int, int, float] | None = None


@dataclass(frozen=True, slots=True)
class ParameterRequest:
    """A PARAM_SET, answered by a PARAM_VALUE that echoes the value."""

    name: str
    value: float

    @property
    def label(self) -> str:
        return f"set {self.name} to {self.value:g}"


Request = CommandRequest | ParameterRequest


@dataclass(frozen=True, slots=True)
class Step:
    """One thing to get done: the first of `alternatives` that the autopilot takes."""

    alternatives: tuple[Request, ...]
