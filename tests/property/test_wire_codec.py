"""The codec: every message comes back as it was, and no bytes raise or smuggle in what a message cannot hold."""

from __future__ import annotations

import random
import typing

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vehicle_agent.wire.codec import MAX_MESSAGE_BYTES, Codec
from vehicle_agent.wire.messages import (
    AnyMessage,
    BodyReport,
    Claim,
    Command,
    CommandResult,
    DeltaRecord,
    Digest,
    Event,
    LandmarkDigest,
    Landmarks,
    MapDelta,
    Message,
    Orders,
    Outcome,
    Repair,
    Scan,
    Severity,
    Stage,
    Status,
    StreamHeld,
    Verb,
    WorkNote,
    Zone,
)

MUTATIONS = 100_000

U32 = st.integers(0, 2**32 - 1)
NAMES = st.from_regex(r"[a-z][a-z0-9-]{0,30}", fullmatch=True)
POSITIONS = st.tuples(*[st.integers(-(10**8), 10**8)] * 3)
POLYGONS = st.lists(st.tuples(*[st.integers(-(10**8), 10**8)] * 2), max_size=48).map(tuple)
PERMILLE = st.integers(0, 1000)
TEXTS = st.text(max_size=160)
RECORDS = st.builds(DeltaRecord, origin=NAMES, stream_id=U32, delta_sequence=U32, cells=st.binary(max_size=300))
HEADER: dict[str, st.SearchStrategy[typing.Any]] = {
    "sender": NAMES,
    "boot_id": U32,
    "sequence": U32,
    "stamp_ms": st.integers(0, 2**53),
}
STATUSES = st.builds(
    Status,
    **HEADER,
    stage=st.sampled_from(Stage),
    mode=st.text(max_size=16),
    armed=st.booleans(),
    position_cm=POSITIONS,
    velocity_cm_s=POSITIONS,
    heading_deg=st.integers(0, 360),
    battery_permille=st.integers(-1, 1000),
    leg_end_cm=POSITIONS,
    home_cm=POSITIONS,
    known_permille=PERMILLE,
    first_seen_cells=U32,
    bytes_sent=U32,
    messages_dropped=U32,
    why=TEXTS,
    path_cm=st.lists(POSITIONS, max_size=12).map(tuple),
)
BY_TYPE: dict[type, st.SearchStrategy[typing.Any]] = {
    Status: STATUSES,
    MapDelta: st.builds(MapDelta, **HEADER, record=RECORDS),
    Claim: st.builds(Claim, **HEADER, active=st.booleans(), goal_cm=POSITIONS, cost_m=st.integers(0, 10**7)),
    Event: st.builds(Event, **HEADER, severity=st.sampled_from(Severity), code=st.text(max_size=32), text=TEXTS),
    Command: st.builds(
        Command,
        **HEADER,
        command_id=U32,
        verb=st.sampled_from(Verb),
        targets=st.lists(NAMES, max_size=64).map(tuple),
        point_cm=POSITIONS,
        polygon_cm=POLYGONS,
        number=st.integers(0, 2**31),
        subject=NAMES,
    ),
    CommandResult: st.builds(
        CommandResult,
        **HEADER,
        station=NAMES,
        station_boot_id=U32,
        command_id=U32,
        verb=st.sampled_from(Verb),
        outcome=st.sampled_from(Outcome),
        text=TEXTS,
    ),
    Digest: st.builds(
        Digest,
        **HEADER,
        streams=st.lists(st.builds(StreamHeld, origin=NAMES, stream_id=U32, held=U32), max_size=20).map(tuple),
    ),
    Repair: st.builds(Repair, **HEADER, records=st.lists(RECORDS, max_size=5).map(tuple)),
    Scan: st.builds(Scan, **HEADER, cells=st.binary(max_size=500)),
    BodyReport: st.builds(
        BodyReport,
        **HEADER,
        vehicle=NAMES,
        position_cm=POSITIONS,
        armed=st.booleans(),
        has_flown=st.booleans(),
        crashed=st.booleans(),
        mode=st.text(max_size=16),
    ),
    Orders: st.builds(
        Orders,
        **HEADER,
        no_fly=st.lists(st.builds(Zone, number=U32, polygon_cm=POLYGONS), max_size=4).map(tuple),
        area_cm=POLYGONS,
        sector_cm=POLYGONS,
        speed_limit_cm_s=st.integers(0, 2**31),
    ),
    Landmarks: st.builds(
        Landmarks,
        **HEADER,
        position_cm=POSITIONS,
        position_sd_cm=st.integers(0, 10**8),
        records=st.binary(max_size=300),
    ),
    LandmarkDigest: st.builds(LandmarkDigest, **HEADER, checksums=st.lists(U32, min_size=1, max_size=64).map(tuple)),
}
MESSAGES = st.one_of(*BY_TYPE.values())


def is_valid(message: Message) -> bool:
    """Tell whether a message would pass its own bounds, checked by another path than decoding msgpack."""
    return bool(msgspec.convert(msgspec.to_builtins(message), type(message)) == message)


def test_every_message_is_tried_here() -> None:
    assert set(BY_TYPE) == set(typing.get_args(AnyMessage))


@given(MESSAGES)
@settings(suppress_health_check=[HealthCheck.too_slow])
def test_round_trip(message: AnyMessage) -> None:
    codec = Codec()
    assert codec.decode(codec.encode(message)) == message
    assert codec.dropped == 0


def samples() -> list[AnyMessage]:
    """One ordinary message of each type."""
    header: dict[str, typing.Any] = {"sender": "merlin", "boot_id": 7, "sequence": 300, "stamp_ms": 1_767_225_600_000}
    record = DeltaRecord("merlin", 99, 3, bytes(range(60)))
    here = (12_345, -67_890, 45_000)
    return [
        Status(
            **header, stage=Stage.WORKING, mode="guided", armed=True, position_cm=here, velocity_cm_s=(1, 2, -3),
            heading_deg=359, battery_permille=-1, leg_end_cm=here, home_cm=here, known_permille=500,
            first_seen_cells=70_000, bytes_sent=2**31, messages_dropped=0, why="frontier 23 m NE", path_cm=(here, here),
        ),
        MapDelta(**header, record=record),
        Claim(**header, active=True, goal_cm=here, cost_m=120),
        Event(**header, severity=Severity.NOTICE, code="took-off", text="up and away"),
        Command(**header, command_id=1, verb=Verb.RETURN, targets=("merlin", "osprey")),
        CommandResult(
            **header, station="station-1", station_boot_id=1, command_id=1, verb=Verb.HOLD,
            outcome=Outcome.REFUSED, text="no",
        ),
        Digest(**header, streams=(StreamHeld("merlin", 99, 4), StreamHeld("osprey", 12, 0))),
        Repair(**header, records=(record, record)),
        Scan(**header, cells=bytes(100)),
        BodyReport(**header, vehicle="merlin", position_cm=here, armed=True, has_flown=True, crashed=False, mode="rtl"),
        Landmarks(**header, position_cm=here, position_sd_cm=120, records=bytes(60)),
        Landmarks(
            **header, position_cm=here, position_sd_cm=0, records=b"", note=WorkNote(here, 2**32 - 1, bytes(32))
        ),
        LandmarkDigest(**header, checksums=(1, 2**32 - 1)),
    ]  # fmt: skip


def test_a_hundred_thousand_wrong_byte_strings_change_nothing() -> None:
    dice = random.Random(2026)
    codec = Codec()
    good = [codec.encode(message) for message in samples()]
    seeds = [*good, *(bytes([0xDD, 0xFF, 0xFF, 0xFF, 0xFF]) + data for data in good), b"\x91" * 5_000]
    loud = (0xC0, 0xC6, 0xCA, 0xCB, 0xCF, 0xD3, 0xDB, 0xDD, 0xDF, 0x7F, 0x80, 0x9F, 0xFF, 0x00)
    accepted = dropped = 0
    for number in range(MUTATIONS):
        if number % 4 == 0:
            data = dice.randbytes(dice.randrange(40))
        else:
            changed = bytearray(dice.choice(seeds))
            for _ in range(dice.randint(1, 3)):
                where = dice.randrange(len(changed))
                kind = dice.random()
                if kind < 0.7:
                    changed[where] = dice.choice(loud) if kind < 0.35 else dice.randrange(256)
                elif kind < 0.85:
                    changed[where:where] = dice.randbytes(dice.choice((1, 4, 8)))
                else:
                    del changed[where : where + dice.choice((1, 2, 1_000))]
                if not changed:
                    break
            data = bytes(changed)
        message = codec.decode(data)
        if message is None:
            dropped += 1
        else:
            accepted += 1
            assert is_valid(message)
    assert codec.dropped == dropped
    assert accepted > 0
    assert [codec.decode(data) for data in good] == samples()


@pytest.mark.parametrize(
    "wrong",
    [float("nan"), float("inf"), -float("inf"), 0.5, 2**53 + 1, 2**64 - 1, -(2**63), -1, None, True, "7", b"7", [], {}],
    ids=repr,
)
@pytest.mark.parametrize("place", range(1, 5), ids=["sender", "boot_id", "sequence", "stamp_ms"])
def test_no_header_holds_what_is_not_its_kind(place: int, wrong: object) -> None:
    codec = Codec()
    for message in samples():
        fields = msgspec.msgpack.decode(codec.encode(message))
        fields[place] = wrong
        assert codec.decode(msgspec.msgpack.encode(fields)) is None
    assert codec.dropped == len(samples())


NUMBERS_OUT_OF_BOUNDS = (float("nan"), float("inf"), -float("inf"), 1e300, 0.5, 2**64 - 1, -(2**63), 10**8 + 1, None)


def test_no_number_anywhere_can_be_nan_infinite_or_huge() -> None:
    codec = Codec()
    tried = 0
    for message in samples():
        fields = msgspec.msgpack.decode(codec.encode(message))
        for place in number_places(fields):
            for wrong in NUMBERS_OUT_OF_BOUNDS:
                forged = msgspec.msgpack.encode(with_value(fields, place, wrong))
                decoded = codec.decode(forged)
                # Only counters and stamps may be as large as 10**8 + 1.
                assert decoded is None or (wrong == 10**8 + 1 and is_valid(decoded))
                tried += 1
    assert tried > 500


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\xc1",
        b"\x90",
        b"\xdd\xff\xff\xff\xff",
        b"\xc6\xff\xff\xff\xff",
        b"\xdf\xff\xff\xff\xff",
        b"\x91" * 100_000,
    ],
    ids=["empty", "unused", "no-tag", "array-bomb", "blob-bomb", "map-bomb", "nesting"],
)
def test_hostile_openings(data: bytes) -> None:
    assert Codec().decode(data) is None


def test_nesting_in_a_field_that_nobody_reads() -> None:
    codec = Codec()
    data = codec.encode(Digest(sender="merlin", boot_id=0, sequence=0, stamp_ms=0, streams=()))
    assert data[0] == 0x96
    codec.decode(b"\x97" + data[1:] + b"\x91" * 100_000 + b"\xc0")
    assert codec.dropped == 1


def test_what_is_too_long_is_not_even_read() -> None:
    codec = Codec()
    message = Scan(sender="merlin", boot_id=0, sequence=0, stamp_ms=0, cells=bytes(MAX_MESSAGE_BYTES))
    assert codec.decode(codec.encode(message)) is None


def number_places(fields: list[typing.Any]) -> list[tuple[int, ...]]:
    """Where in nested lists there are numbers, beyond the tag."""
    places: list[tuple[int, ...]] = []
    for index, value in enumerate(fields):
        if isinstance(value, list):
            places += [(index, *rest) for rest in number_places(value)]
        elif isinstance(value, int) and not isinstance(value, bool):
            places.append((index,))
    return [place for place in places if place != (0,)]


def with_value(fields: list[typing.Any], place: tuple[int, ...], value: object) -> list[typing.Any]:
    changed = list(fields)
    changed[place[0]] = value if len(place) == 1 else with_value(changed[place[0]], place[1:], value)
    return changed
