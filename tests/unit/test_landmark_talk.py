"""Landmarks told over a thin link: what one vehicle learns of the other, and what it drops and counts."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from tests.fakes.map_missions import map_plan
from vehicle_agent.behaviour.landmark_share import LandmarkShare
from vehicle_agent.behaviour.landmark_talk import HEADER_BYTES, LandmarkTalk
from vehicle_agent.behaviour.units import to_centimetres
from vehicle_agent.domain.done_sketch import SKETCH_BYTES
from vehicle_agent.domain.landmark_records import LandmarkRecords
from vehicle_agent.wire.codec import Codec
from vehicle_agent.wire.landmark_blob import pack_landmarks, unpack_landmarks
from vehicle_agent.wire.messages import LandmarkDigest, Landmarks, WorkNote

PLAN = map_plan()
WATER_M = PLAN.mission.simulation.water_level_m
HERE, GOAL = (10.0, 10.0, WATER_M - 2.0), (25.0, 10.0, WATER_M - 2.0)
PACKET_BYTES, CAPACITY = 200, 10


class Pair:
    """Two vehicles' shares and talks."""

    def __init__(self) -> None:
        self.shares = [LandmarkShare(PLAN, index) for index in range(2)]
        self.talks = [LandmarkTalk(self.shares[index], PLAN.vehicle_names, index, CAPACITY, 20.0) for index in range(2)]
        self.sequence = 0

    def sound_along(self, index: int, cells: int) -> None:
        for cell in range(cells):
            place = (2.0 + 2.5 * (cell % 14), 2.0 + 2.5 * (cell // 14), WATER_M - 2.0)
            for _ in range(3):
                self.shares[index].sound(place, 8.0 + 0.01 * cell, 10.0)

    def packet(self, index: int, boot_id: int = 1, room_bytes: int = PACKET_BYTES) -> Landmarks:
        self.sequence += 1
        return Landmarks(
            sender=PLAN.vehicle_names[index], boot_id=boot_id, sequence=self.sequence, stamp_ms=0,
            **self.talks[index].fields(HERE, 1.0, GOAL, self.talks[index].teammates(0.0, 90.0), room_bytes),
        )  # fmt: skip


def test_packets_fit_and_the_map_arrives_piece_by_piece() -> None:
    pair = Pair()
    pair.sound_along(0, 60)
    packets = 0
    while not np.array_equal(*(np.isfinite(share.team_map.landmarks.heights_m) for share in pair.shares)):
        packet = pair.packet(0)
        assert len(Codec().encode(packet)) <= 200
        pair.talks[1].hear(packet, float(packets), HERE)
        packets += 1
        assert packets < 20
    assert pair.talks[1].teammates(float(packets), 90.0)[0].position_enu_m == HERE
    assert pair.talks[1].teammates(1_000.0, 90.0) == ()


def test_what_was_lost_is_told_again_when_checksums_show_it() -> None:
    pair = Pair()
    pair.sound_along(0, 25)
    for _ in range(6):
        pair.packet(0)  # all lost
    assert not np.isfinite(pair.shares[1].team_map.landmarks.heights_m).any()
    for minute in range(10):
        digest = LandmarkDigest(
            sender="brisa", boot_id=2, sequence=minute, stamp_ms=0, checksums=pair.talks[1].digest()
        )
        pair.talks[0].hear_digest(digest)
        for _ in range(4):
            pair.talks[1].hear(pair.packet(0), 60.0 * minute, HERE)
    known = [np.isfinite(share.team_map.landmarks.heights_m).sum() for share in pair.shares]
    assert known[0] == known[1]


def test_repetition_and_a_boot_that_is_over_are_counted_drops() -> None:
    pair = Pair()
    pair.sound_along(0, 5)
    first = pair.packet(0, boot_id=1)
    pair.talks[1].hear(first, 0.0, HERE)
    pair.talks[1].hear(first, 1.0, HERE)
    assert pair.talks[1].refused["heard before"] == 1
    pair.talks[1].hear(pair.packet(0, boot_id=2), 2.0, HERE)
    before = pair.shares[1].team_map.copy()
    pair.talks[1].hear(msgspec.structs.replace(first, sequence=99), 3.0, HERE)
    assert pair.talks[1].refused["old boot"] == 1
    assert before.landmarks == pair.shares[1].team_map.landmarks


def test_strangers_nonsense_and_unknown_landmarks_are_counted_drops() -> None:
    pair = Pair()
    pair.sound_along(0, 5)
    good = pair.packet(0)
    pair.talks[1].hear(msgspec.structs.replace(good, sender="mallory"), 0.0, HERE)
    assert pair.talks[1].refused["unknown vehicle"] == 1
    pair.talks[1].hear(msgspec.structs.replace(good, sequence=50, records=b"\xff\xff\xff"), 0.0, HERE)
    assert pair.talks[1].refused["unreadable records"] == 1
    beyond = pack_landmarks(LandmarkRecords(*(np.array([value]) for value in (10**6, 0, 1, -80, 10))))
    pair.talks[1].hear(msgspec.structs.replace(good, sequence=51, records=beyond), 0.0, HERE)
    assert pair.shares[1].refused["unknown landmark"] == 1
    assert not np.isfinite(pair.shares[1].team_map.landmarks.heights_m).any()


def test_a_sketch_or_a_goal_that_cannot_be_is_counted_and_the_rest_taken() -> None:
    pair = Pair()
    pair.sound_along(0, 5)
    good = pair.packet(0)
    for number, (note, reason) in enumerate(
        (
            (WorkNote(None, 10**6, bytes(SKETCH_BYTES)), "unreadable sketch"),
            (WorkNote(None, 0, b"\xff"), "unreadable sketch"),
            (WorkNote((10**8, 0, 0)), "goal outside the area"),
        )
    ):
        before = pair.talks[1].refused[reason]
        pair.talks[1].hear(msgspec.structs.replace(good, sequence=60 + number, note=note), 0.0, HERE)
        assert pair.talks[1].refused[reason] == before + 1
    assert not pair.talks[1].said_done.any()
    assert pair.talks[1].teammates(0.0, 90.0)[0].goal_enu_m is None
    assert np.isfinite(pair.shares[1].team_map.landmarks.heights_m).sum() == 5


def test_where_a_teammate_goes_is_told_first() -> None:
    east_first = []
    for goal in ((37.0, 3.0, HERE[2]), (3.0, 3.0, HERE[2])):
        pair = Pair()
        pair.sound_along(0, 14)
        going = msgspec.structs.replace(pair.packet(1), note=WorkNote(to_centimetres(goal)))
        pair.talks[0].hear(msgspec.structs.replace(going, position_cm=to_centimetres(goal)), 0.0, HERE)
        records = unpack_landmarks(pair.packet(0, room_bytes=150).records)
        assert records is not None
        places = pair.shares[0].team_map.landmarks.layout.positions_en_m[records.landmarks]
        east_first.append(places[:, 0].mean() > 20.0)
    assert east_first == [True, False]


def test_a_packets_last_place_may_say_what_is_done_around_a_teammate() -> None:
    pair = Pair()
    pair.sound_along(0, 14 * 5)
    pair.talks[0].hear(pair.packet(1), 0.0, HERE)
    packet = pair.packet(0)
    records = unpack_landmarks(packet.records)
    assert records is not None
    assert packet.note is not None
    assert packet.note.done_bits
    assert len(np.unique(records.landmarks)) == CAPACITY - 1
    pair.talks[1].hear(packet, 0.0, HERE)
    called = np.flatnonzero(pair.talks[1].said_done)
    assert len(called) > CAPACITY
    assert pair.shares[0].team_map.landmarks.accurate[called].all()


@pytest.mark.parametrize("room_bytes", [0, 90, 120, 160, 200])
def test_no_message_is_larger_than_the_room_that_it_gets(room_bytes: int) -> None:
    pair = Pair()
    pair.sound_along(0, 14 * 5)
    pair.talks[0].hear(pair.packet(1), 0.0, HERE)
    for _ in range(8):
        message = pair.packet(0, boot_id=2**32 - 1, room_bytes=room_bytes)
        message = msgspec.structs.replace(message, sequence=2**20, stamp_ms=1_800_000_000_000)
        assert len(Codec().encode(message)) <= max(room_bytes, HEADER_BYTES)


def test_a_restarted_teammate_is_told_again() -> None:
    pair = Pair()
    pair.sound_along(0, 8)
    pair.talks[0].hear(pair.packet(1, boot_id=1), 0.0, HERE)
    first = pair.packet(0).records
    for _ in range(20):
        pair.packet(0)
    pair.talks[0].hear(pair.packet(1, boot_id=2), 0.0, HERE)
    assert pair.packet(0).records == first


def test_maps_become_equal_by_packets_and_checksums_even_where_both_were_sure_of_something_else() -> None:
    pair = Pair()
    pair.sound_along(0, 20)
    pair.sound_along(1, 28)
    landmarks = [share.team_map.landmarks for share in pair.shares]
    for minute in range(20):
        for own, other in ((0, 1), (1, 0)):
            checksums = pair.talks[other].digest()
            name = PLAN.vehicle_names[other]
            pair.talks[own].hear_digest(
                LandmarkDigest(sender=name, boot_id=1, sequence=minute, stamp_ms=0, checksums=checksums)
            )
            for _ in range(4):
                pair.talks[other].hear(pair.packet(own), 60.0 * minute, HERE)
    assert pair.talks[0].digest() == pair.talks[1].digest()
    assert np.array_equal(landmarks[0].heights_m, landmarks[1].heights_m, equal_nan=True)


def test_a_liar_who_is_too_sure_is_not_believed() -> None:
    pair = Pair()
    lie = pack_landmarks(LandmarkRecords(*(np.array([value]) for value in (3, 0, 1, -80, 2**22))))
    message = Landmarks(
        sender="alba", boot_id=1, sequence=1, stamp_ms=0, position_cm=(0, 0, 0), position_sd_cm=0, records=lie
    )
    pair.talks[1].hear(message, 0.0, HERE)
    assert pair.shares[1].refused["too confident"] == 1


def test_soundings_beside_the_area_or_without_a_number_change_nothing() -> None:
    share = LandmarkShare(PLAN, 0)
    share.sound((-50.0, 0.0, WATER_M - 2.0), 8.0, 0.0)
    share.sound((10.0, 10.0, WATER_M - 2.0), math.nan, 0.0)
    assert not np.isfinite(share.team_map.landmarks.heights_m).any()


def test_a_restarted_vehicle_knows_from_its_journal_what_it_had_measured() -> None:
    pair = Pair()
    pair.sound_along(0, 30)
    blob = pair.shares[0].next_blob(8_000)
    assert blob is not None
    again = LandmarkShare(PLAN, 0)
    assert again.fold(0, blob)
    assert again.team_map.landmarks == pair.shares[0].team_map.landmarks
    assert not again.fold(1, blob), "nobody's soundings are another's"
    assert not again.fold(0, b"\xff\xff")
