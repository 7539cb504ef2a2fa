"""An acoustic modem carries one packet per period, the most urgent words first, and never more than fits."""

from __future__ import annotations

from vehicle_agent.behaviour.modem import Modem
from vehicle_agent.wire.messages import AnyMessage, Claim, Event, Landmarks, Severity


def landmarks(sequence: int, size: int) -> Landmarks:
    return Landmarks(
        sender="alba", boot_id=1, sequence=sequence, stamp_ms=0, position_cm=(0, 0, 0), position_sd_cm=0,
        records=bytes(size),
    )  # fmt: skip


def event(sequence: int, severity: Severity, text: str = "words") -> Event:
    return Event(sender="alba", boot_id=1, sequence=sequence, stamp_ms=0, severity=severity, code="code", text=text)


def test_one_packet_per_period_and_no_more_than_fits() -> None:
    modem = Modem(200, 10.0)
    modem.put([event(n, Severity.INFO, "x" * 60) for n in range(6)])
    first = modem.take(0.0)
    assert 1 <= len(first) < 6
    assert sum(modem.size_of(message) for message in first) <= 200
    assert modem.take(9.9) == []
    rest: list[AnyMessage] = []
    for packet in range(1, 6):
        rest += modem.take(10.0 * packet)
    assert len(first) + len(rest) == 6


def test_warnings_go_before_landmarks_and_those_before_small_talk() -> None:
    modem = Modem(200, 10.0)
    modem.put([event(0, Severity.INFO, "x" * 70), landmarks(1, 100), event(2, Severity.WARNING)])
    assert [message.sequence for message in modem.take(0.0)] == [2, 1]


def test_only_the_newest_landmarks_wait() -> None:
    modem = Modem(200, 10.0)
    modem.put([landmarks(0, 50), landmarks(1, 50)])
    assert [message.sequence for message in modem.take(0.0)] == [1]


def test_what_fits_into_no_packet_is_counted_and_what_nobody_needs_is_not_said() -> None:
    modem = Modem(200, 10.0)
    modem.put([landmarks(0, 300)])
    assert modem.dropped == 1
    modem.put([Claim(sender="alba", boot_id=1, sequence=2, stamp_ms=0, active=False, goal_cm=(0, 0, 0), cost_m=0)])
    assert modem.take(0.0) == []
    assert modem.dropped == 1


def test_a_flood_is_bounded_and_loses_the_least_urgent() -> None:
    modem = Modem(200, 10.0)
    modem.put([event(n, Severity.INFO) for n in range(100)] + [event(100, Severity.CRITICAL)])
    assert modem.dropped == 61
    assert modem.take(0.0)[0].sequence == 100
