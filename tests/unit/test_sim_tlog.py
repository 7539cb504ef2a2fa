"""Telemetry logs: what stands in them, in which order, and what ends them early."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

from sim_bridge.clock import SimClock
from sim_bridge.tlog import TelemetryLog, TelemetryLogError
from tests.fakes.sim_client import Bench


def entries(path: Path) -> list[tuple[int, bytes]]:
    """Stamp and frame of every entry; MAVLink 2 without signatures."""
    data, found = path.read_bytes(), []
    while data:
        (stamp_us,) = struct.unpack_from(">Q", data)
        end = 8 + 12 + data[9]
        assert data[8] == 0xFD
        found.append((stamp_us, data[8:end]))
        data = data[end:]
    return found


def test_frames_of_both_directions_stand_in_the_order_of_time(tmp_path: Path) -> None:
    bench = Bench()
    log = TelemetryLog(tmp_path / "merlin.tlog", bench.fleet.clock, print)
    bench.node.record = log.write
    bench.wait(2.0)
    bench.asker.command(512, 148)
    bench.asker.node.receive(bench.asker.connection, b"garbage \xfd\x01\x00")
    log.close()
    log.close()
    kept = entries(tmp_path / "merlin.tlog")
    stamps = [stamp_us for stamp_us, _ in kept]
    assert stamps == sorted(stamps)
    assert stamps[-1] == bench.fleet.clock.unix_us
    senders = [frame[5] for _, frame in kept]
    assert {1, 255} == set(senders)
    asked = senders.index(255)
    assert int.from_bytes(kept[asked][1][7:10], "little") == 76  # COMMAND_LONG
    assert [int.from_bytes(frame[7:10], "little") for _, frame in kept[asked + 1 :]] == [77, 148]


def test_it_ends_when_it_is_long_enough_and_says_so_once(tmp_path: Path) -> None:
    said: list[str] = []
    log = TelemetryLog(tmp_path / "merlin.tlog", SimClock(), said.append, most_bytes=100)
    for _ in range(20):
        log.write(b"\xfd" + bytes(29))
    log.close()
    assert (tmp_path / "merlin.tlog").stat().st_size == 2 * 38
    assert len(said) == 1


def test_a_full_disk_ends_the_record_and_not_the_flight() -> None:
    said: list[str] = []
    log = TelemetryLog(Path("/dev/full"), SimClock(), said.append)
    for _ in range(5_000):
        log.write(b"\xfd" + bytes(29))
    log.close()
    assert len(said) == 1 or said[1].startswith("/dev/full: its end is lost")
    assert said[0].startswith("/dev/full: the record ends here (No space left")


def test_a_log_that_cannot_be_begun_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "merlin.tlog").mkdir()
    with pytest.raises(TelemetryLogError, match=r"merlin\.tlog: cannot be written .*choose another --tlog-dir"):
        TelemetryLog(tmp_path / "merlin.tlog", SimClock(), print)
