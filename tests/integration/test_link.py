"""The fleet link between real sessions on loopback: order of start, history, restarts, deaths and wrong bytes."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator

import pytest
import zenoh

from tests.fakes.waiting import until
from vehicle_agent.link.pacing import BulkSender, TokenBucket
from vehicle_agent.link.profile import session_profile, zenoh_config
from vehicle_agent.link.receiving import ReceiveQueue
from vehicle_agent.link.session import FleetLink, LinkError
from vehicle_agent.wire.messages import AnyMessage, Command, DeltaRecord, Event, MapDelta, Scan, Severity, Verb

DEADLINE_S = 20.0


def free_endpoint() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


def event(sender: str, number: int, boot_id: int = 1) -> Event:
    return Event(
        sender=sender, boot_id=boot_id, sequence=number, stamp_ms=number, severity=Severity.INFO, code="n", text=""
    )


def delta(sender: str, number: int, size: int = 10) -> MapDelta:
    record = DeltaRecord(sender, 1, number, bytes(size))
    return MapDelta(sender=sender, boot_id=1, sequence=number, stamp_ms=0, record=record)


class Fleet:
    """Opens links and closes them all."""

    def __init__(self) -> None:
        self.links: list[FleetLink] = []

    def open(self, name: str, **endpoints: list[str]) -> FleetLink:
        link = FleetLink.open("trial", name, **endpoints)  # type: ignore[arg-type]
        self.links.append(link)
        return link

    def close(self) -> None:
        for link in self.links:
            link.close()


@pytest.fixture
def fleet() -> Iterator[Fleet]:
    fleet = Fleet()
    yield fleet
    fleet.close()


def heard(link: FleetLink, box: list[AnyMessage]) -> Callable[[int], Callable[[], bool]]:
    def at_least(count: int) -> Callable[[], bool]:
        def check() -> bool:
            box.extend(link.poll())
            return len(box) >= count

        return check

    return at_least


def test_a_late_joiner_hears_the_history_of_events_in_order_and_once(fleet: Fleet) -> None:
    a, b = free_endpoint(), free_endpoint()
    merlin = fleet.open("merlin", listen=[a])
    kestrel = fleet.open("kestrel", listen=[b], connect=[a])
    for number in range(30):
        merlin.publish(event("merlin", number))
        kestrel.publish(event("kestrel", number))
    station = fleet.open("station", connect=[a, b])
    station.subscribe("event")
    box: list[AnyMessage] = []
    until(heard(station, box)(60), "sixty old events")
    merlin.publish(event("merlin", 30))
    until(heard(station, box)(61), "a new event")
    for name, count in (("merlin", 31), ("kestrel", 30)):
        assert [message.sequence for message in box if message.sender == name] == list(range(count))


def test_the_order_of_start_does_not_matter_and_own_messages_do_not_come_back(fleet: Fleet) -> None:
    a = free_endpoint()
    early = fleet.open("early", connect=[a])
    early.subscribe("event")
    early.publish(event("early", 0))
    late = fleet.open("late", listen=[a])
    late.subscribe("event")
    box: list[AnyMessage] = []
    until(heard(late, box)(1), "the event said before anybody listened")
    late.publish(event("late", 0))
    back: list[AnyMessage] = []
    until(heard(early, back)(1), "the answer")
    assert [message.sender for message in back] == ["late"]
    assert [message.sender for message in box] == ["early"]


def test_a_restarted_participant_is_met_again_and_its_new_events_are_heard(fleet: Fleet) -> None:
    a = free_endpoint()
    station = fleet.open("station", connect=[a])
    station.subscribe("event")
    first = fleet.open("merlin", listen=[a])
    first.publish(event("merlin", 0, boot_id=1))
    box: list[AnyMessage] = []
    until(heard(station, box)(1), "the first event")
    first.close()
    until(lambda: station.connected_peers() == 0, "the station to notice the closing")
    second = fleet.open("merlin", listen=[a])
    second.publish(event("merlin", 0, boot_id=2))
    until(heard(station, box)(2), "the second event")
    assert [message.boot_id for message in box] == [1, 2]


def test_bulk_telemetry_and_commands_arrive_and_bytes_are_counted(fleet: Fleet) -> None:
    a = free_endpoint()
    merlin = fleet.open("merlin", listen=[a])
    kestrel = fleet.open("kestrel", connect=[a])
    for topic in ("map", "command", "scan"):
        kestrel.subscribe(topic)
    until(lambda: merlin.connected_peers() == 1, "the peers to meet")
    box: list[AnyMessage] = []
    command = Command(
        sender="merlin", boot_id=1, sequence=1, stamp_ms=0, command_id=1, verb=Verb.HOLD, targets=("kestrel",)
    )
    scan = Scan(sender="merlin", boot_id=1, sequence=2, stamp_ms=0, cells=bytes(100_000))

    def everything_arrived() -> bool:
        merlin.publish(delta("merlin", 0))
        merlin.publish(scan, "kestrel")  # telemetry: said again until it is heard
        box.extend(kestrel.poll())
        return {type(message) for message in box} >= {MapDelta, Command, Scan}

    merlin.publish(command)
    until(everything_arrived, "all three kinds")
    assert command in box
    sent = merlin.counters
    heard_by_kestrel = kestrel.counters
    assert sent.messages_sent >= 3
    assert 0 < heard_by_kestrel.bytes_received <= sent.bytes_sent < 100_000  # scans do not go over the radio


def test_wrong_bytes_are_counted_and_dropped(fleet: Fleet) -> None:
    a = free_endpoint()
    station = fleet.open("station", listen=[a])
    station.subscribe("status")
    intruder = zenoh.open(zenoh_config(session_profile([], [a])))
    try:
        until(lambda: station.connected_peers() == 1, "the intruder")
        foreign = station._codec.encode(event("merlin", 1))

        def three_counted() -> bool:
            intruder.put("fleet/trial/v1/merlin/status", b"\xff\x00nonsense")
            intruder.put("fleet/trial/v1/merlin/status", foreign)  # an event on the key of a status
            assert station.poll() == []
            return station.counters.undecodable >= 3

        until(three_counted, "three undecodable messages")
    finally:
        intruder.close()  # type: ignore[no-untyped-call]
    with pytest.raises(ValueError, match="cannot be said"):
        station.publish(event("merlin", 1))


@pytest.mark.parametrize(
    ("endpoint", "words"),
    [("tcp/127.0.0.1:99999", "not a usable Zenoh endpoint"), ("smoke/signals", "not a usable Zenoh endpoint")],
)
def test_a_malformed_endpoint_is_explained(endpoint: str, words: str) -> None:
    with pytest.raises(LinkError, match=words) as refusal:
        FleetLink.open("trial", "merlin", listen=[endpoint])
    assert endpoint in str(refusal.value)


def test_a_port_in_use_is_explained(fleet: Fleet) -> None:
    a = free_endpoint()
    fleet.open("merlin", listen=[a])
    with pytest.raises(LinkError, match="the port is in use") as refusal:
        FleetLink.open("trial", "kestrel", listen=[a])
    assert a in str(refusal.value)


MORTAL = """
import sys, time
from vehicle_agent.link.session import FleetLink
link = FleetLink.open("trial", "merlin", listen=[sys.argv[1]])
link.declare_alive()
print("ready", flush=True)
while True:
    time.sleep(1.0)
"""


def mortal(endpoint: str) -> subprocess.Popen[str]:
    process = subprocess.Popen([sys.executable, "-c", MORTAL, endpoint], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    return process


@pytest.mark.processes
def test_the_death_of_a_process_and_its_return_are_noticed(fleet: Fleet) -> None:
    a = free_endpoint()
    station = fleet.open("station", connect=[a])
    station.declare_alive()
    station.watch_alive()
    changes: list[tuple[str, bool]] = []

    def last_is(alive: bool) -> Callable[[], bool]:
        def check() -> bool:
            changes.extend(station.poll_alive())
            return bool(changes) and changes[-1] == ("merlin", alive)

        return check

    for blow in (signal.SIGKILL, signal.SIGSTOP):
        process = mortal(a)
        try:
            until(last_is(True), "merlin to live")
            os.kill(process.pid, blow)
            until(last_is(False), f"merlin to be missed after {blow.name}")
        finally:
            process.kill()
            process.wait()
            assert process.stdout is not None
            process.stdout.close()
    assert {name for name, _ in changes} == {"merlin"}


def test_a_full_receive_queue_gives_up_telemetry_first_and_keeps_order() -> None:
    queue = ReceiveQueue(max_messages=4)
    for number, expendable in enumerate([True, False, True, False, False, True]):
        queue.put(str(number), b"", expendable)
    assert [arrival.key_text for arrival in queue.take_all()] == ["1", "3", "4", "5"]
    assert queue.overflowed == 2
    assert queue.take_all() == []


def test_the_bucket_holds_bulk_back_until_time_has_passed() -> None:
    now_s = 0.0
    bucket = TokenBucket(100.0, lambda: now_s)
    assert bucket.take(100)
    assert not bucket.take(60)
    now_s = 0.7
    assert bucket.take(60)
    bucket.charge(50)  # telemetry overdraws
    now_s = 1.2
    assert not bucket.take(60)
    now_s = 2.3
    assert bucket.take(500)  # a message larger than one burst goes out and leaves a debt
    now_s = 6.2
    assert not bucket.take(60)
    now_s = 7.0
    assert bucket.take(60)


def test_bulk_that_the_rate_never_lets_out_is_counted() -> None:
    sent: list[bytes] = []
    bucket = TokenBucket(1.0, lambda: 0.0)
    bucket.charge(10)
    sender = BulkSender(lambda _key, payload: sent.append(payload), bucket, "trial")
    for _ in range(600):
        sender.put("key", b"payload")
    sender.stop(DEADLINE_S)
    assert not sent
    assert sender.paced_out > 0
