"""Hostile MAVLink frames without end: flipped bits, cut ends, garbage, wrong checksums and lengths, wild content."""

from __future__ import annotations

import random
import struct
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

from missions.bench.interview import dialect

MAGIC = 0xFD
WIDTHS = {
    "char": 1, "int8_t": 1, "uint8_t": 1, "uint8_t_mavlink_version": 1, "int16_t": 2, "uint16_t": 2, "int32_t": 4,
    "uint32_t": 4, "float": 4, "int64_t": 8, "uint64_t": 8, "double": 8,
}  # fmt: skip
REMEMBERED = 64
_STRANGE_FLOATS = tuple(
    struct.pack("<f", value) for value in (float("nan"), float("inf"), -1e30, 3.4e38, 0.0, 1.0, -1.0, 2.0**31)
)


@dataclass(frozen=True, slots=True)
class _Kind:
    """One message kind: where in its payload stands what decides over its fate."""

    number: int
    crc_extra: int
    size: int
    offsets: dict[str, int]


class Mutations:
    """Makes one frame after the other.

    Parameters
    ----------
    rng
        Decides everything.
    target
        System id that most frames are addressed to.
    commands
        MAV_CMD numbers that half of all command messages carry.
    without
        Ids of messages that are never made.

    Example
    -------
    ::

        mutations = Mutations(random.Random(1), target=1, commands=node.commands)
        node.receive(client, mutations.frame())
    """

    def __init__(
        self, rng: random.Random, target: int, commands: Iterable[int], without: frozenset[int] = frozenset()
    ) -> None:
        self._rng = rng
        self._target = target
        self._commands = sorted(commands)
        self._kinds = [_kind(number) for number in sorted(dialect.mavlink_map) if number not in without]
        heard = ("COMMAND", "MISSION", "PARAM", "SET_", "REQUEST", "FILE", "LOG_", "TIMESYNC", "HEARTBEAT")
        self._heard = [kind for kind in self._kinds if dialect.mavlink_map[kind.number].msgname.startswith(heard)]
        self._recent: deque[bytes] = deque(maxlen=REMEMBERED)
        self._sequence = 0

    def frame(self) -> bytes:
        """The next bytes to send: mostly one frame, mutated or not."""
        rng, choice = self._rng, self._rng.randrange(8)
        if choice == 0:
            return rng.randbytes(rng.randint(1, 300))
        if choice == 1 and self._recent:
            return rng.choice(self._recent)
        frame = self.intact()
        self._recent.append(frame)
        if choice == 2:
            return _flipped(frame, rng)
        if choice == 3:
            return frame[: rng.randrange(len(frame))]
        if choice == 4:
            return rng.randbytes(rng.randint(1, 20)) + frame
        if choice == 5:
            return frame[:-2] + rng.randbytes(2)
        if choice == 6:
            return frame[:1] + bytes((rng.randrange(256),)) + frame[2:]
        return frame

    def intact(self) -> bytes:
        """A frame with the right checksum and wild content."""
        rng = self._rng
        kind = rng.choice(self._heard if rng.random() < 0.7 else self._kinds)
        payload = self._payload(kind)
        self._sequence = (self._sequence + 1) % 256
        length = len(payload.rstrip(b"\0")) or 1
        head = struct.pack(
            "<BBBBBBHB", length, 0, 0, self._sequence, rng.choice((255, 255, 1, rng.randrange(256))),
            rng.choice((190, 1, 0)), kind.number & 0xFFFF, kind.number >> 16,
        )  # fmt: skip
        body = head + bytes(payload[:length])
        crc = dialect.x25crc(body + bytes((kind.crc_extra,))).crc
        return bytes((MAGIC,)) + body + struct.pack("<H", crc)

    def _payload(self, kind: _Kind) -> bytearray:
        rng, size = self._rng, kind.size
        style = rng.randrange(4)
        if style == 0:
            payload = bytearray(rng.randbytes(size))
        elif style == 1:
            payload = bytearray(size)
        elif style == 2:
            payload = bytearray(rng.choice(_STRANGE_FLOATS) * (size // 4 + 1))[:size]
        else:
            payload = bytearray(rng.choice((0, 0, 0, 1, 2, 255)) for _ in range(size))
        for name, offset in kind.offsets.items():
            if name == "target_system" and rng.random() < 0.9:
                payload[offset] = self._target
            elif name == "target_component" and rng.random() < 0.9:
                payload[offset] = 1
            elif name == "command" and self._commands and rng.random() < 0.5:
                payload[offset : offset + 2] = struct.pack("<H", rng.choice(self._commands))
            elif name == "seq" and rng.random() < 0.5:
                payload[offset : offset + 2] = struct.pack("<H", rng.randrange(4))
            elif name == "mission_type" and rng.random() < 0.9:
                payload[offset] = rng.randrange(4)
        return payload


def _kind(number: int) -> _Kind:
    kind = dialect.mavlink_map[number]
    types = dict(zip(kind.fieldnames, kind.fieldtypes, strict=True))
    offsets, place = {}, 0
    for name, count in zip(kind.ordered_fieldnames, kind.array_lengths, strict=True):
        width = WIDTHS[types[name]]
        if width <= 2:
            offsets[name] = place
        place += width * max(count, 1)
    wanted = ("target_system", "target_component", "command", "seq", "mission_type")
    chosen = {name: offset for name, offset in offsets.items() if name in wanted}
    if types.get("command") == "uint8_t" or types.get("seq") == "uint8_t":
        chosen = {name: offset for name, offset in chosen.items() if name not in ("command", "seq")}
    return _Kind(number, kind.crc_extra, kind.unpacker.size, chosen)


def _flipped(frame: bytes, rng: random.Random) -> bytes:
    data = bytearray(frame)
    for _ in range(rng.randint(1, 8)):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return bytes(data)
