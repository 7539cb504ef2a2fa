"""The one place that imports pymavlink: the ArduPilot dialect as a codec, never its connection layer."""

from __future__ import annotations

import os
from typing import Any

os.environ.setdefault("MAVLINK20", "1")

from pymavlink.dialects.v20 import ardupilotmega as mavlink

Message = Any
"""A decoded or built MAVLink message; pymavlink's classes carry no types."""

COMPONENT_ID = mavlink.MAV_COMP_ID_AUTOPILOT1

__all__ = ["COMPONENT_ID", "Message", "mavlink", "new_codec"]


def new_codec(system_id: int, component_id: int = COMPONENT_ID) -> Any:
    """Return a codec of its own state; garbage comes out as BAD_DATA messages instead of exceptions."""
    codec = mavlink.MAVLink(None, srcSystem=system_id, srcComponent=component_id)
    codec.robust_parsing = True
    return codec
