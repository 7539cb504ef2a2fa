"""The one place that imports pymavlink: the ArduPilot dialect as a codec, never its connection layer."""

from __future__ import annotations

import hashlib
import os
from typing import Any

os.environ.setdefault("MAVLINK20", "1")

from pymavlink.dialects.v20 import ardupilotmega as mavlink
from pymavlink.dialects.v20 import development

Message = Any
"""A decoded or built MAVLink message; pymavlink's classes carry no types."""

COMPONENT_ID = mavlink.MAV_COMP_ID_AUTOPILOT1
AVAILABLE_MODES_ID = 435
AVAILABLE_MODES_MONITOR_ID = 437
available_modes_message = development.MAVLink_available_modes_message
available_modes_monitor_message = development.MAVLink_available_modes_monitor_message
"""Vehicles send these, but the released ArduPilot dialect has not got them."""
ONE_MINUTE = 6_000_000
"""Signing timestamps count 10 microseconds."""

__all__ = [
    "AVAILABLE_MODES_ID",
    "AVAILABLE_MODES_MONITOR_ID",
    "COMPONENT_ID",
    "Codec",
    "Message",
    "available_modes_message",
    "available_modes_monitor_message",
    "mavlink",
    "new_codec",
    "new_signing",
]


class Codec(mavlink.MAVLink):  # type: ignore[misc]
    """pymavlink's codec, with signatures that are checked before anything of them is believed."""

    def check_signature(self, msgbuf: bytearray, srcSystem: int, srcComponent: int) -> bool:
        """Whether a frame is signed with the key and newer than what its sender has signed before.

        The library notes the time stamp first and checks the signature then, so that one forged frame with a time in
        the future would lock its true sender out.
        """
        signing = self.signing
        digest = hashlib.sha256(signing.secret_key + bytes(msgbuf[:-6])).digest()[:6]
        if digest != bytes(msgbuf[-6:]):
            return False
        stream = (msgbuf[-13], srcSystem, srcComponent)
        stamp = int.from_bytes(msgbuf[-12:-6], "little")
        known = signing.stream_timestamps.get(stream)
        if stamp <= known if known is not None else stamp + ONE_MINUTE < signing.timestamp:
            return False
        signing.stream_timestamps[stream] = stamp
        signing.timestamp = max(signing.timestamp, stamp)
        return True


def new_codec(system_id: int, component_id: int = COMPONENT_ID) -> Any:
    """Return a codec of its own state; garbage comes out as BAD_DATA messages instead of exceptions."""
    codec = Codec(None, srcSystem=system_id, srcComponent=component_id)
    codec.robust_parsing = True
    return codec


def new_signing() -> Any:
    """Return the state of signing, for all codecs of one vehicle: a frame replayed on another connection is old too."""
    return mavlink.MAVLinkSigning()
