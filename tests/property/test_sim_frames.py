"""Frames are packed here, not by the library: they must be the library's, byte for byte."""

from __future__ import annotations

import inspect
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from sim_bridge.autopilot.dialect import available_modes_message, frame_of, mavlink, new_codec

KINDS = [
    mavlink.MAVLink_heartbeat_message,
    mavlink.MAVLink_global_position_int_message,
    mavlink.MAVLink_attitude_message,
    mavlink.MAVLink_statustext_message,
    mavlink.MAVLink_battery_status_message,
    mavlink.MAVLink_param_value_message,
    mavlink.MAVLink_water_depth_message,
    mavlink.MAVLink_obstacle_distance_message,
    mavlink.MAVLink_file_transfer_protocol_message,
    available_modes_message,
]


def _field(kind: Any, name: str) -> st.SearchStrategy[Any]:
    position = kind.fieldnames.index(name)
    wire, length = kind.fieldtypes[position], kind.array_lengths[kind.orders[position]]
    if wire == "char":
        return st.binary(max_size=length)
    if wire in ("float", "double"):
        one: st.SearchStrategy[Any] = st.floats(width=32, allow_nan=False)
    else:
        bits, signed = int(wire.removeprefix("u").removeprefix("int").removesuffix("_t")), not wire.startswith("u")
        one = st.integers(-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) if signed else st.integers(0, 2**bits - 1)
    one = st.one_of(st.just(0), one)
    return st.lists(one, min_size=length, max_size=length) if length else one


@st.composite
def messages(draw: st.DrawFn) -> Any:
    kind = draw(st.sampled_from(KINDS))
    names = list(inspect.signature(kind.__init__).parameters)[1:]
    values = [draw(_field(kind, name)) for name in names]
    return lambda: kind(*values)


@given(messages(), st.integers(0, 255), st.integers(1, 255))
def test_a_frame_is_the_one_that_the_library_packs(build: Any, sequence: int, system_id: int) -> None:
    codec = new_codec(system_id)
    codec.seq = sequence
    expected, message = bytes(build().pack(codec)), build()
    assert frame_of(message, codec) == expected
    # Again, to another connection: only the sequence number and the checksum differ.
    codec.seq = (sequence + 1) % 256
    assert frame_of(message, codec) == bytes(build().pack(codec))


@given(messages(), st.binary(min_size=32, max_size=32))
def test_a_signed_frame_is_the_one_that_the_library_signs(build: Any, key: bytes) -> None:
    ours, theirs, plain = new_codec(1), new_codec(1), new_codec(1)
    for codec in (ours, theirs):
        codec.signing.secret_key, codec.signing.sign_outgoing, codec.signing.timestamp = key, True, 7_000
    message = build()
    frame_of(message, plain)
    assert frame_of(message, ours) == bytes(build().pack(theirs))
    assert frame_of(message, plain) == bytes(build().pack(plain))
