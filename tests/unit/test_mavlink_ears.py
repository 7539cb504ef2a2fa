"""Autopilots' own heartbeats: found in any bytes, and told apart from their agents."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from ground_station.conditions import Kind
from ground_station.fleet_state import fold
from ground_station.heartbeat import Heartbeat, HeartbeatReader
from ground_station.inputs import AliveChanged, AutopilotHeard, FleetInput, Heard, Tick
from ground_station.mavlink_ears import EarsError, MavlinkEars
from ground_station.picture import FleetState
from tests.fakes.talking_fleet import Voice, small_plan

PLAN = small_plan()
DEADLINE_S = 20.0


def frame(system_id: int = 3, armed: bool = True, state: int = 4, autopilot: int = 3, first: bool = False) -> bytes:
    codec = mavlink.MAVLink(None, srcSystem=system_id, srcComponent=1)
    message = mavlink.MAVLink_heartbeat_message(2, autopilot, 128 if armed else 0, 4, state, 3)
    packed: bytes = message.pack(codec, force_mavlink1=first)
    return packed


def other() -> bytes:
    packed: bytes = mavlink.MAVLink_attitude_message(1, 0, 0, 0, 0, 0, 0).pack(mavlink.MAVLink(None, srcSystem=3))
    return packed


@pytest.mark.parametrize("first", [False, True])
def test_both_versions_are_understood_as_the_library_packs_them(first: bool) -> None:
    data = other() + frame(7, armed=False, state=5, first=first) + frame(8, first=first)
    assert HeartbeatReader().feed(data) == [Heartbeat(7, False, True), Heartbeat(8, True, False)]


def test_stations_and_broken_frames_are_no_autopilots() -> None:
    broken = bytearray(frame())
    broken[-1] ^= 1
    assert HeartbeatReader().feed(frame(255, autopilot=8) + bytes(broken)) == []


@given(st.binary(max_size=300), st.integers(1, 40))
def test_noise_never_raises_and_a_heartbeat_in_pieces_is_found(noise: bytes, size: int) -> None:
    reader, found = HeartbeatReader(), []
    data = noise + bytes(300) + frame(9)
    for at in range(0, len(data), size):
        found += reader.feed(data[at : at + size])
    assert found[-1:] == [Heartbeat(9, True, False)]


def until(ears: MavlinkEars, act: Callable[[], None] = lambda: None) -> list[AutopilotHeard]:
    deadline_s = time.monotonic() + DEADLINE_S
    while not (heard := ears.poll(time.monotonic())):
        assert time.monotonic() < deadline_s, "no heartbeat came"
        act()
        time.sleep(0.01)
    return heard


@pytest.fixture
def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def test_ears_hear_datagrams_and_connections_that_come_late(free_port: int) -> None:
    ears = MavlinkEars([f"tcpout://127.0.0.1:{free_port}"])
    assert ears.poll(time.monotonic()) == []
    with socket.create_server(("127.0.0.1", free_port)) as autopilot:
        autopilot.setblocking(False)
        callers: list[socket.socket] = []

        def speak() -> None:
            try:
                callers.append(autopilot.accept()[0])
                callers[-1].sendall(frame(2))
            except BlockingIOError:
                pass

        (heard,) = until(ears, speak)
        assert (heard.system_id, heard.source) == (2, f"tcpout://127.0.0.1:{free_port}")
        for caller in callers:
            caller.close()
    ears.close()
    ears = MavlinkEars([f"udpin://127.0.0.1:{free_port}"])
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as radio:
        (heard,) = until(ears, lambda: radio.sendto(frame(4), ("127.0.0.1", free_port)) and None)
    assert heard.system_id == 4
    with pytest.raises(EarsError, match="address already in use; give --mavlink a port"):
        MavlinkEars([f"udpin://127.0.0.1:{free_port}"])
    ears.close()


def test_a_malformed_endpoint_is_a_sentence() -> None:
    with pytest.raises(EarsError, match="serial:ttyS0: no MAVLink endpoint; write it like"):
        MavlinkEars(["serial:ttyS0"])


def lost(*more: FleetInput) -> FleetState:
    """Merlin (system id 1) and osprey (3), whose agent dies at second 10."""
    state = FleetState.initial(PLAN, "station-0001", 9, 0.0)
    heard = [Heard(Voice(name).status(), 9.5) for name in ("merlin", "osprey")]
    return fold(state, [*heard, *more, AliveChanged("osprey", False, 10.0), Tick(10.1)])


def text_of(state: FleetState, kind: Kind) -> str:
    return next(one.text for one in state.troubles if (one.vehicle, one.kind) == ("osprey", kind))


def test_a_dead_agent_whose_autopilot_lives_is_told_as_such() -> None:
    assert text_of(lost(), Kind.AGENT_DEAD) == "its agent is gone"
    flies = lost(AutopilotHeard(3, True, True, "udp", 9.9))
    assert text_of(flies, Kind.AGENT_DEAD) == "its agent is gone, its autopilot lives (armed, under its failsafe)"
    both = lost(AutopilotHeard(3, True, False, "udp", 2.0))
    assert text_of(both, Kind.AGENT_DEAD) == "its agent is gone, and its autopilot is not heard either"


def test_a_system_id_heard_at_two_places_is_named_while_it_lasts() -> None:
    state = lost(AutopilotHeard(3, True, False, "udp a:1", 9.0), AutopilotHeard(3, False, False, "udp b:2", 9.5))
    assert text_of(state, Kind.DUPLICATE_ID) == "autopilots with its system id speak at udp a:1 and udp b:2"
    later = fold(state, [AutopilotHeard(3, False, False, "udp b:2", 20.0), Tick(20.0)])
    assert all(one.kind is not Kind.DUPLICATE_ID for one in later.troubles)
