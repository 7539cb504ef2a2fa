"""What the vehicles of the mapping bench tell each other: by the paper's section 3.4, or by what listeners need."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from vehicle_agent.domain.frames import Point
from vehicle_agent.domain.grid import IndexArray
from vehicle_agent.domain.landmark_records import LandmarkRecords
from vehicle_agent.domain.landmarks import LandmarkMap
from vehicle_agent.domain.polygon import BoolArray
from vehicle_agent.planning.interface import Teammate
from vehicle_agent.planning.mapping.exchange import ExchangeParams, LandmarkExchange
from vehicle_agent.planning.mapping.need_exchange import NeedExchange, Packet
from vehicle_agent.wire.landmark_blob import pack_landmarks
from vehicle_agent.wire.messages import Landmarks, PositionCm, WorkNote

CENTIMETRES = 5_000.0
"""On the wire the cube is 100 m wide."""


class Exchange(Protocol):
    """One vehicle's side."""

    @property
    def said_done(self) -> BoolArray | None:
        """(N,) bool, what teammates called done without more; None where nobody does."""
        ...

    def sensed(self, visible: IndexArray, sealed: IndexArray) -> None:
        """Take note of a step's landmarks: ids now visible, and those newly accurate."""
        ...

    def packet(self, position_enu_m: Point, teammates: Sequence[Teammate]) -> Packet:
        """What to tell those in radio range."""
        ...

    def take(self, packets: Mapping[int, Packet], position_enu_m: Point) -> LandmarkRecords:
        """What to take in of packets by the team index of who told them."""
        ...


class PaperExchange:
    """Section 3.4 as it is."""

    said_done = None

    def __init__(self, landmarks: LandmarkMap, params: ExchangeParams) -> None:
        self._exchange = LandmarkExchange(landmarks, params)

    def sensed(self, visible: IndexArray, sealed: IndexArray) -> None:
        self._exchange.sensed(visible, sealed)

    def packet(self, position_enu_m: Point, teammates: Sequence[Teammate]) -> Packet:
        return Packet(self._exchange.packet(position_enu_m, [mate.position_enu_m for mate in teammates]))

    def take(self, packets: Mapping[int, Packet], position_enu_m: Point) -> LandmarkRecords:
        return self._exchange.sieve([packet.records for packet in packets.values()], position_enu_m)


class NeededExchange:
    """What listeners need."""

    def __init__(self, landmarks: LandmarkMap, capacity: int, near_m: float) -> None:
        self._exchange = NeedExchange(landmarks, capacity, near_m)

    @property
    def said_done(self) -> BoolArray | None:
        return self._exchange.said_done

    def sensed(self, visible: IndexArray, sealed: IndexArray) -> None:
        """Nothing to note: the map says what there is to tell."""

    def packet(self, position_enu_m: Point, teammates: Sequence[Teammate]) -> Packet:
        return self._exchange.packet(teammates)

    def take(self, packets: Mapping[int, Packet], position_enu_m: Point) -> LandmarkRecords:
        return self._exchange.take(packets, position_enu_m)


def message_of(index: int, step: int, position: Point, goal: Point | None, packet: Packet) -> Landmarks:
    """A packet as it goes over the radio, with the sender's goal where it has one."""
    sketch, note = packet.sketch, None
    if goal is not None or sketch is not None:
        goal_cm = None if goal is None else _centimetres(goal)
        note = WorkNote(goal_cm) if sketch is None else WorkNote(goal_cm, sketch.centre, sketch.bits)
    return Landmarks(
        sender=f"v{index}", boot_id=0, sequence=step, stamp_ms=1_000 * step, position_cm=_centimetres(position),
        position_sd_cm=0, records=pack_landmarks(packet.records), note=note,
    )  # fmt: skip


def _centimetres(place: Point) -> PositionCm:
    east, north, up = (round(coordinate * CENTIMETRES) for coordinate in place)
    return (east, north, up)
