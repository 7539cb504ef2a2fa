"""What a vehicle tells its team of landmarks over a thin link, and what it makes of what it is told."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

from vehicle_agent.behaviour.landmark_share import LandmarkShare
from vehicle_agent.behaviour.units import to_centimetres, to_metres
from vehicle_agent.domain.done_sketch import DoneSketch
from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.landmark_records import LandmarkRecords
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.planning.interface import Teammate
from vehicle_agent.planning.mapping.need_exchange import NeedExchange, Packet
from vehicle_agent.wire.landmark_blob import pack_landmarks, unpack_landmarks
from vehicle_agent.wire.messages import LandmarkDigest, Landmarks, Message, WorkNote

HEADER_BYTES, RECORD_BYTES = 88, 8
"""Of a `Landmarks` message with its note beside its records, and most that a record of it commonly takes."""
BLOCKS = 8
"""Checksums in a digest."""
MOST_SD_CM = 10**8


@dataclass(slots=True)
class _Mate:
    """Last words of a teammate."""

    boot_id: int
    sequence: int
    position_enu_m: Point
    goal_enu_m: Point | None
    heard_at_s: float


class LandmarkTalk:
    """One vehicle's side of the exchange of landmarks: what listeners need first, in packets that fit.

    Parameters
    ----------
    capacity
        Landmarks in a packet.
    near_m
        Distance from where a teammate is or goes at which landmarks are 1/e as urgent to tell it.

    Attributes
    ----------
    refused
        What was heard and dropped, by reason.
    """

    def __init__(
        self, share: LandmarkShare, team: tuple[str, ...], own_index: int, capacity: int, near_m: float
    ) -> None:
        self.refused: Counter[str] = Counter()
        self._share, self._team, self._own_index = share, team, own_index
        self._exchange = NeedExchange(share.team_map.landmarks, capacity, near_m)
        self._mates: dict[str, _Mate] = {}
        self._old_boots: set[tuple[str, int]] = set()

    @property
    def said_done(self) -> BoolArray:
        """(N,) bool, landmarks that teammates called done without telling their heights."""
        return self._exchange.said_done

    def fields(
        self, position_enu_m: Point, position_sd_m: float, goal_enu_m: Point | None, listeners: tuple[Teammate, ...],
        room_bytes: int,
    ) -> dict[str, Any]:  # fmt: skip
        """The fields of the next `Landmarks` message beyond its header, for a message of so many bytes."""
        packet = self._exchange.packet(listeners, max(0, (room_bytes - HEADER_BYTES) // RECORD_BYTES))
        return {
            "position_cm": to_centimetres(position_enu_m),
            "position_sd_cm": min(round(100 * position_sd_m), MOST_SD_CM),
            "records": pack_landmarks(packet.records),
            "note": _note(goal_enu_m, packet.sketch),
        }

    def digest(self) -> tuple[int, ...]:
        return self._share.team_map.landmarks.digest(BLOCKS)

    def hear(self, message: Landmarks, now_s: float, here_enu_m: Point) -> None:
        """Take in a teammate's packet at a place; what cannot be true is counted and dropped."""
        if not self._is_new(message):
            return
        note = message.note or WorkNote()
        self._mates[message.sender] = _Mate(
            message.boot_id, message.sequence, to_metres(message.position_cm), self._goal_of(note), now_s
        )
        records = unpack_landmarks(message.records)
        if records is None:
            self.refused["unreadable records"] += 1
            records = LandmarkRecords.empty()
        packet = Packet(records, self._sketch_of(note))
        self._share.take_records(self._exchange.take({self._team.index(message.sender): packet}, here_enu_m))

    def hear_digest(self, digest: LandmarkDigest) -> None:
        """Tell again, once all is told, what somebody's checksums show to be other than here."""
        if digest.sender not in self._team or self._exchange.has_untold or len(digest.checksums) != BLOCKS:
            return
        for block, (own, theirs) in enumerate(zip(self.digest(), digest.checksums, strict=True)):
            if own != theirs:
                ids = self._share.team_map.landmarks.block_of(block, BLOCKS)
                self._exchange.doubt(self._team.index(digest.sender), ids)

    def teammates(self, now_s: float, silence_s: float) -> tuple[Teammate, ...]:
        """Those heard not too long ago, where they were and where they went."""
        return tuple(
            Teammate(self._team.index(name), mate.position_enu_m, mate.goal_enu_m)
            for name, mate in sorted(self._mates.items())
            if now_s - mate.heard_at_s <= silence_s
        )

    def _goal_of(self, note: WorkNote) -> Point | None:
        """Where a teammate goes; None when it does not say so, or names a place that it has nothing to do at."""
        if note.goal_cm is None:
            return None
        goal = to_metres(note.goal_cm)
        if not self._share.team_map.grid.contains(*goal[:2]):
            self.refused["goal outside the area"] += 1
            return None
        return goal

    def _sketch_of(self, note: WorkNote) -> DoneSketch | None:
        if not note.done_bits:
            return None
        sketch = DoneSketch(note.done_centre, note.done_bits)
        if not self._exchange.is_readable(sketch):
            self.refused["unreadable sketch"] += 1
            return None
        return sketch

    def _is_new(self, message: Message) -> bool:
        """Whether a packet is of the team, of its sender's present boot and not heard before."""
        if message.sender not in self._team:
            self.refused["unknown vehicle"] += 1
            return False
        known = self._mates.get(message.sender)
        if (message.sender, message.boot_id) in self._old_boots:
            self.refused["old boot"] += 1
            return False
        if known is None:
            return True
        if known.boot_id != message.boot_id:
            self._old_boots.add((message.sender, known.boot_id))
            self._exchange.forget(self._team.index(message.sender))
            return True
        if message.sequence <= known.sequence:
            self.refused["heard before"] += 1
            return False
        return True


def _note(goal_enu_m: Point | None, sketch: DoneSketch | None) -> WorkNote | None:
    if goal_enu_m is None and sketch is None:
        return None
    goal_cm = None if goal_enu_m is None else to_centimetres(goal_enu_m)
    return WorkNote(goal_cm) if sketch is None else WorkNote(goal_cm, sketch.centre, sketch.bits)
