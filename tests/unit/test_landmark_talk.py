"""Landmarks told over a thin link: what one vehicle learns of the other, and what it drops and counts."""

from __future__ import annotations

import math

import msgspec
import numpy as np

from tests.fakes.map_missions import map_plan
from vehicle_agent.behaviour.landmark_share import LandmarkShare
from vehicle_agent.behaviour.landmark_talk import LandmarkTalk
from vehicle_agent.domain.landmark_records import LandmarkRecords
from vehicle_agent.wire.codec import Codec
from vehicle_agent.wire.landmark_blob import pack_landmarks
from vehicle_agent.wire.messages import LandmarkDigest, Landmarks

PLAN = map_plan()
WATER_M = PLAN.mission.simulation.water_level_m
HERE = (10.0, 10.0, WATER_M - 2.0)


class Pair:
    """Two vehicles' shares and talks."""

    def __init__(self) -> None:
        self.shares = [LandmarkShare(PLAN, index) for index in range(2)]
        self.talks = [LandmarkTalk(self.shares[index], PLAN.vehicle_names, index, 10, 200) for index in range(2)]
        self.sequence = 0

    def sound_along(self, index: int, cells: int) -> None:
        for cell in range(cells):
            place = (2.0 + 2.5 * (cell % 14), 2.0 + 2.5 * (cell // 14), WATER_M - 2.0)
            for _ in range(3):
                self.talks[index].sounded(*self.shares[index].sound(place, 8.0 + 0.01 * cell, 10.0))

    def packet(self, index: int, boot_id: int = 1) -> Landmarks:
        self.sequence += 1
        return Landmarks(
            sender=PLAN.vehicle_names[index], boot_id=boot_id, sequence=self.sequence, stamp_ms=0,
            **self.talks[index].fields(HERE, 1.0),
        )  # fmt: skip


def test_packets_fit_and_the_map_arrives_piece_by_piece() -> None:
    pair = Pair()
    pair.sound_along(0, 60)
    packets = 0
    while not np.array_equal(*(np.isfinite(share.team_map.landmarks.heights_m) for share in pair.shares)):
        packet = pair.packet(0)
        assert len(Codec().encode(packet)) <= 200
        pair.talks[1].hear(packet, float(packets))
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
            pair.talks[1].hear(pair.packet(0), 60.0 * minute)
    known = [np.isfinite(share.team_map.landmarks.heights_m).sum() for share in pair.shares]
    assert known[1] >= known[0] - 1  # all but the cell that it is still over


def test_repetition_and_a_boot_that_is_over_are_counted_drops() -> None:
    pair = Pair()
    pair.sound_along(0, 5)
    first = pair.packet(0, boot_id=1)
    pair.talks[1].hear(first, 0.0)
    pair.talks[1].hear(first, 1.0)
    assert pair.talks[1].refused["heard before"] == 1
    pair.talks[1].hear(pair.packet(0, boot_id=2), 2.0)
    before = pair.shares[1].team_map.copy()
    pair.talks[1].hear(msgspec.structs.replace(first, sequence=99), 3.0)
    assert pair.talks[1].refused["old boot"] == 1
    assert before.landmarks == pair.shares[1].team_map.landmarks


def test_strangers_nonsense_and_unknown_landmarks_are_counted_drops() -> None:
    pair = Pair()
    pair.sound_along(0, 5)
    good = pair.packet(0)
    pair.talks[1].hear(msgspec.structs.replace(good, sender="mallory"), 0.0)
    assert pair.talks[1].refused["unknown vehicle"] == 1
    pair.talks[1].hear(msgspec.structs.replace(good, sequence=50, records=b"\xff\xff\xff"), 0.0)
    assert pair.talks[1].refused["unreadable records"] == 1
    beyond = pack_landmarks(LandmarkRecords(*(np.array([value]) for value in (10**6, 0, 1, -80, 10))))
    pair.talks[1].hear(msgspec.structs.replace(good, sequence=51, records=beyond), 0.0)
    assert pair.shares[1].refused["unknown landmark"] == 1
    assert not np.isfinite(pair.shares[1].team_map.landmarks.heights_m).any()


def test_a_liar_who_is_too_sure_is_not_believed() -> None:
    pair = Pair()
    lie = pack_landmarks(LandmarkRecords(*(np.array([value]) for value in (3, 0, 1, -80, 2**22))))
    message = Landmarks(
        sender="alba", boot_id=1, sequence=1, stamp_ms=0, position_cm=(0, 0, 0), position_sd_cm=0, records=lie
    )
    pair.talks[1].hear(message, 0.0)
    assert pair.shares[1].refused["too confident"] == 1


def test_soundings_beside_the_area_or_without_a_number_change_nothing() -> None:
    share = LandmarkShare(PLAN, 0)
    assert len(share.sound((-50.0, 0.0, WATER_M - 2.0), 8.0, 0.0)[0]) == 0
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
