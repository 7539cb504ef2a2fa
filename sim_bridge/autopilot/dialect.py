"""The one place that imports pymavlink: the ArduPilot dialect as a codec, never its connection layer."""

from __future__ import annotations

import hashlib
import os
import struct
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

_HEAD = struct.Struct("<BBBBBBHB")
"""A frame's header after its magic byte."""

__all__ = [
    "AVAILABLE_MODES_ID",
    "AVAILABLE_MODES_MONITOR_ID",
    "COMPONENT_ID",
    "Codec",
    "Message",
    "available_modes_message",
    "available_modes_monitor_message",
    "frame_of",
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


def frame_of(message: Message, codec: Codec) -> bytes:
    """The bytes of a message with the codec's ids, its sequence number and, when it signs, its signature.

    What `message.pack(codec)` gives, at a third of the cost, most of which the library spends on objects that keep
    what is known already. The content is packed once, however many connections it goes to.
    """
    if codec.signing.sign_outgoing:
        message.__dict__.pop("_pack", None)
        return bytes(message.pack(codec))
    if message._payload is None:
        # The generated `pack` orders the fields and hands them to `_pack`, which here returns them as they are.
        message._pack = _content
        message._payload = message.pack(codec).rstrip(b"\0") or b"\0"
    content, number = message._payload, message.get_msgId()
    head = _HEAD.pack(len(content), 0, 0, codec.seq, codec.srcSystem, codec.srcComponent, number & 0xFFFF, number >> 16)
    checksum = mavlink.x25crc(b"%b%b%c" % (head, content, message.crc_extra)).crc
    return b"\xfd%b%b%b" % (head, content, checksum.to_bytes(2, "little"))


def _content(codec: Codec, crc_extra: int, content: bytes, force_mavlink1: bool) -> bytes:
    return content


def new_codec(system_id: int, component_id: int = COMPONENT_ID) -> Any:
    """Return a codec of its own state; garbage comes out as BAD_DATA messages instead of exceptions."""
    codec = Codec(None, srcSystem=system_id, srcComponent=component_id)
    codec.robust_parsing = True
    return codec


def new_signing() -> Any:
    """Return the state of signing, for all codecs of one vehicle: a frame replayed on another connection is old too."""
    return mavlink.MAVLinkSigning()
