"""MAVLink heartbeats out of bytes, and nothing else of MAVLink: enough to tell that an autopilot lives.

Frames as in https://mavlink.io/en/guide/serialization.html, HEARTBEAT as in its common message set.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

HEARTBEAT_ID = 0
HEARTBEAT_CRC_EXTRA = 50
HEARTBEAT_BYTES = 9
NO_AUTOPILOT = 8
"""MAV_AUTOPILOT_INVALID: ground stations, cameras and companions say this."""
ARMED = 0x80
IN_FAILSAFE = (5, 6)
"""MAV_STATE_CRITICAL and MAV_STATE_EMERGENCY."""
SIGNATURE_BYTES = 13
LONGEST_FRAME = 280


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """What one autopilot says of itself."""

    system_id: int
    armed: bool
    in_failsafe: bool


class HeartbeatReader:
    """Takes bytes of one connection as they come; what is no heartbeat of an autopilot is passed over. Never raises."""

    def __init__(self) -> None:
        self._kept = b""

    def feed(self, data: bytes) -> list[Heartbeat]:
        """Heartbeats that are whole by now."""
        buffer = self._kept + data
        found, at = [], 0
        while at < len(buffer):
            if buffer[at] not in (0xFD, 0xFE):
                at += 1
                continue
            size = _frame_bytes(buffer, at)
            if size is None or at + size > len(buffer):
                break
            heartbeat = _parsed(buffer[at : at + size])
            if heartbeat is None:  # it may be noise with a heartbeat inside: look at every byte
                at += 1
                continue
            found.append(heartbeat)
            at += size
        self._kept = buffer[at:][-LONGEST_FRAME:]
        return found


def _frame_bytes(buffer: bytes, at: int) -> int | None:
    """Length of the frame that begins there; None when its head is not whole."""
    if len(buffer) - at < 3:
        return None
    if buffer[at] == 0xFE:
        return 8 + buffer[at + 1]
    return 12 + buffer[at + 1] + (SIGNATURE_BYTES if buffer[at + 2] & 1 else 0)


def _parsed(frame: bytes) -> Heartbeat | None:
    """The heartbeat of a frame; None for other messages, noise, and heartbeats of what is no autopilot."""
    second = frame[0] == 0xFD
    head = 10 if second else 6
    size = frame[1]
    message_id = int.from_bytes(frame[7:10], "little") if second else frame[5]
    if message_id != HEARTBEAT_ID:
        return None
    payload = frame[head : head + size]
    told = int.from_bytes(frame[head + size : head + size + 2], "little")
    if size > HEARTBEAT_BYTES or told != crc(frame[1 : head + size] + bytes((HEARTBEAT_CRC_EXTRA,))):
        return None
    _, _, autopilot, base_mode, state, _ = struct.unpack("<IBBBBB", payload.ljust(HEARTBEAT_BYTES, b"\0"))
    if autopilot == NO_AUTOPILOT:
        return None
    return Heartbeat(frame[5] if second else frame[3], bool(base_mode & ARMED), state in IN_FAILSAFE)


def crc(data: bytes) -> int:
    """CRC-16/MCRF4XX."""
    value = 0xFFFF
    for byte in data:
        mixed = (byte ^ value) & 0xFF
        mixed = (mixed ^ (mixed << 4)) & 0xFF
        value = (value >> 8) ^ (mixed << 8) ^ (mixed << 3) ^ (mixed >> 4)
    return value & 0xFFFF
