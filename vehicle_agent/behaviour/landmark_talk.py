"""What a vehicle tells its team of landmarks over a thin link, and what it makes of what it is told."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np

from vehicle_agent.behaviour.landmark_share import LandmarkShare
from vehicle_agent.behaviour.units import to_centimetres, to_metres
from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.planning.interface import Teammate
from vehicle_agent.planning.mapping.exchange import ExchangeParams, LandmarkExchange
from vehicle_agent.wire.landmark_blob import pack_landmarks, unpack_landmarks
from vehicle_agent.wire.messages import LandmarkDigest, Landmarks, Message

HEADER_BYTES, RECORD_BYTES = 64, 8
"""Of a `Landmarks` message beside its records, and most that a record of it commonly takes."""
BLOCKS = 8
"""Checksums in a digest."""
MOST_SD_CM = 10**8


@dataclass(slots=True)
class _Mate:
    """Last words of a teammate."""

    boot_id: int
    sequence: int
    position_enu_m: Point
    position_sd_m: float
    heard_at_s: float


class LandmarkTalk:
    """One vehicle's side of the exchange of Kapoutsis 2015, section 3.4, without a server.

    Attributes
    ----------
    refused
        What was heard and dropped, by reason.
    """

    def __init__(
        self, share: LandmarkShare, team: tuple[str, ...], own_index: int, capacity: int, packet_bytes: int
    ) -> None:
        fits = max(1, (packet_bytes - HEADER_BYTES) // RECORD_BYTES)
        self.refused: Counter[str] = Counter()
        self._share, self._team, self._own_index = share, team, own_index
        self._exchange = LandmarkExchange(
            share.team_map.landmarks, ExchangeParams(min(capacity, fits), keeps_backlog=True)
        )
        self._mates: dict[str, _Mate] = {}
        self._old_boots: set[tuple[str, int]] = set()
        self._here: IndexArray = np.empty(0, dtype=np.int64)
        self._backlog = False

    def sounded(self, here: IndexArray, sealed: IndexArray) -> None:
        """Take note of a sounding's landmarks; one that is left behind is news, accurate or not."""
        left = np.setdiff1d(self._here, here)
        self._here = here
        self._exchange.sensed(here, np.union1d(left, sealed))

    def fields(self, position_enu_m: Point, position_sd_m: float) -> dict[str, Any]:
        """The fields of the next `Landmarks` message beyond its header."""
        records = self._exchange.packet(position_enu_m, [mate.position_enu_m for mate in self._mates.values()])
        self._backlog = len(np.unique(records.landmarks)) >= self._exchange.params.capacity
        return {
            "position_cm": to_centimetres(position_enu_m),
            "position_sd_cm": min(round(100 * position_sd_m), MOST_SD_CM),
            "records": pack_landmarks(records),
        }

    def digest(self) -> tuple[int, ...]:
        return self._share.team_map.landmarks.digest(BLOCKS)

    def hear(self, message: Landmarks, now_s: float) -> None:
        """Take in a teammate's packet; what cannot be true is counted and dropped."""
        if not self._is_new(message):
            return
        self._mates[message.sender] = _Mate(
            message.boot_id, message.sequence, to_metres(message.position_cm), message.position_sd_cm / 100, now_s
        )
        records = unpack_landmarks(message.records)
        if records is None:
            self.refused["unreadable records"] += 1
            return
        self._share.take_records(self._exchange.sieve([records], to_metres(message.position_cm)))

    def hear_digest(self, digest: LandmarkDigest) -> None:
        """Tell again, once there is nothing newer to tell, what somebody's checksums show to be other than here."""
        if digest.sender not in self._team or self._backlog or len(digest.checksums) != BLOCKS:
            return
        landmarks = self._share.team_map.landmarks
        differing = [block for block, (a, b) in enumerate(zip(self.digest(), digest.checksums, strict=True)) if a != b]
        for block in differing:
            ids = landmarks.block_of(block, BLOCKS)
            told = landmarks.own_records(ids).landmarks
            self._exchange.sensed(self._here, np.union1d(told, ids[landmarks.accurate[ids]]))

    def teammates(self, now_s: float, silence_s: float) -> tuple[Teammate, ...]:
        """Those heard not too long ago, where they were."""
        return tuple(
            Teammate(self._team.index(name), mate.position_enu_m)
            for name, mate in sorted(self._mates.items())
            if now_s - mate.heard_at_s <= silence_s
        )

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
            return True
        if message.sequence <= known.sequence:
            self.refused["heard before"] += 1
            return False
        return True
