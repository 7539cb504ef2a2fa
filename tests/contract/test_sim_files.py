"""MAVLink FTP as clients use it; the packed parameters are read by MAVProxy's own parser."""

from __future__ import annotations

import struct
import zlib
from typing import Any, NamedTuple

import pytest
from MAVProxy.modules.lib.param_ftp import ftp_param_decode

from sim_bridge.autopilot.dialect import mavlink
from tests.fakes.sim_client import Asker, Bench

TERMINATE, RESET, LIST, OPEN, READ, CRC32, BURST = 1, 2, 3, 4, 5, 14, 15
CREATE, WRITE, REMOVE, CREATE_DIRECTORY, REMOVE_DIRECTORY, OPEN_TO_WRITE, TRUNCATE, RENAME = 6, 7, 8, 9, 10, 11, 12, 13
ACK, NAK = 128, 129
FAIL, ERRNO, END_OF_FILE, UNKNOWN, NOT_FOUND = 1, 2, 6, 7, 10
READ_ONLY = 30
HEADER = struct.Struct("<HBBBBBBI")


class Answer(NamedTuple):
    """A reply, taken apart."""

    sequence: int
    session: int
    opcode: int
    size: int
    request: int
    offset: int
    data: bytes


class FileClient:
    """Asks for files on one connection."""

    def __init__(self, bench: Bench, session: int = 1) -> None:
        self.bench, self.asker, self.session, self.sequence = bench, Asker(bench.node), session, 0

    def heard(self) -> list[Answer]:
        return [_taken_apart(bytes(m.payload)) for m in self.asker.heard() if m.get_type() == "FILE_TRANSFER_PROTOCOL"]

    def send(self, opcode: int, data: bytes = b"", offset: int = 0, size: int | None = None) -> None:
        head = HEADER.pack(self.sequence, self.session, opcode, len(data) if size is None else size, 0, 0, 0, offset)
        payload = list((head + data).ljust(251, b"\0"))
        self.asker.send(mavlink.MAVLink_file_transfer_protocol_message(0, 1, 1, payload))

    def ask(self, opcode: int, data: bytes = b"", offset: int = 0, size: int | None = None) -> Answer:
        self.send(opcode, data, offset, size)
        (answer,) = self.heard()
        assert (answer.sequence, answer.session, answer.request) == (self.sequence + 1, self.session, opcode)
        self.sequence += 2
        return answer

    def burst(self, path: bytes, size: int = 110) -> bytes:
        opened = self.ask(OPEN, path)
        assert opened.opcode == ACK
        self.send(BURST, size=size)
        answers = self.heard()
        while answers[-1].opcode == ACK:
            self.bench.wait(0.05)
            answers += self.heard()
        assert (answers[-1].opcode, answers[-1].data) == (NAK, bytes([END_OF_FILE]))
        numbers = [answer.sequence for answer in answers]
        assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
        content = b"".join(answer.data for answer in answers[:-1])
        assert [answer.offset for answer in answers[:-1]] == list(range(0, len(content), size))
        assert answers[-1].offset == len(content) == struct.unpack("<I", opened.data)[0]
        self.sequence = numbers[-1] + 1
        return content


def _taken_apart(payload: bytes) -> Answer:
    sequence, session, opcode, size, request, _, _, offset = HEADER.unpack_from(payload)
    return Answer(sequence, session, opcode, size, request, offset, payload[12 : 12 + size])


@pytest.fixture
def bench() -> Bench:
    return Bench()


@pytest.fixture
def files(bench: Bench) -> FileClient:
    return FileClient(bench)


@pytest.mark.parametrize("path", [b"@PARAM/param.pck", b"@PARAM/param.pck?withdefaults=1"])
def test_packed_parameters_are_the_parameters(bench: Bench, files: FileClient, path: bytes) -> None:
    table = bench.fleet.vehicles[0].parameters
    assert table.set("WPNAV_SPEED", 777.5)
    decoded = ftp_param_decode(files.burst(path))
    read = {name.decode(): value for name, value, _ in decoded.params}
    assert list(read) == list(table)
    assert read == {name: table[name] for name in table}
    defaults = decoded.defaults
    if b"?" in path:
        assert (b"WPNAV_SPEED", 1000.0, 4) in defaults
    else:
        assert defaults is None


def test_a_part_of_the_parameters(files: FileClient) -> None:
    content = files.burst(b"@PARAM/param.pck?start=10&count=5")
    assert struct.unpack_from("<HH", content) == (0x671B, 5)


def test_directories_are_listed_page_by_page(files: FileClient) -> None:
    assert files.ask(LIST, b"/").data == b"D@MISSION\0D@PARAM\0D@SYS\0"
    assert files.ask(LIST, b"/", offset=2).data == b"D@SYS\0"
    assert files.ask(LIST, b"/", offset=3).data == bytes([END_OF_FILE])
    assert files.ask(LIST, b"@PARAM").data.startswith(b"Fparam.pck\t")
    assert files.ask(LIST, b"/nowhere").data == bytes([NOT_FOUND])


def test_reading_checksum_and_closing(files: FileClient) -> None:
    content = files.burst(b"@SYS/tasks.txt", 239)
    files.ask(OPEN, b"@SYS/tasks.txt")
    assert files.ask(READ, offset=3, size=20).data == content[3:23]
    assert files.ask(READ, offset=10_000, size=20).data == bytes([END_OF_FILE])
    checksum = struct.unpack("<I", files.ask(CRC32, b"@SYS/tasks.txt").data)[0]
    assert checksum == zlib.crc32(content, 0xFFFFFFFF) ^ 0xFFFFFFFF
    assert files.ask(TERMINATE).opcode == ACK
    assert files.ask(READ, size=20).data == bytes([NOT_FOUND])
    assert files.ask(BURST, size=20).data == bytes([NOT_FOUND])


def test_what_cannot_be_done_is_refused(files: FileClient) -> None:
    assert files.ask(OPEN, b"@PARAM/none").data == bytes([NOT_FOUND])
    assert files.ask(77).data == bytes([UNKNOWN])
    assert files.ask(RESET).opcode == ACK


@pytest.mark.parametrize("opcode", [CREATE, REMOVE, CREATE_DIRECTORY, REMOVE_DIRECTORY, OPEN_TO_WRITE, RENAME])
def test_writing_is_refused_as_on_a_disk_for_reading_only(files: FileClient, opcode: int) -> None:
    answer = files.ask(opcode, b"@PARAM/param.pck\0@PARAM/other.pck")
    assert (answer.opcode, answer.data) == (NAK, bytes([ERRNO, READ_ONLY]))
    assert files.ask(OPEN, b"@PARAM/param.pck").opcode == ACK


def test_writing_into_a_file_needs_one_that_is_open_for_it(files: FileClient) -> None:
    assert files.ask(WRITE, b"data").data == bytes([NOT_FOUND])
    before = files.burst(b"@SYS/tasks.txt")
    assert files.ask(OPEN, b"@SYS/tasks.txt").opcode == ACK
    assert files.ask(WRITE, b"data").data == bytes([FAIL])
    assert files.ask(TRUNCATE, b"@SYS/tasks.txt").data == bytes([UNKNOWN])
    assert files.burst(b"@SYS/tasks.txt") == before


def test_answers_of_others_get_none(files: FileClient) -> None:
    for opcode in (ACK, NAK):
        files.send(opcode, b"data")
    assert files.heard() == []


def test_a_repeated_request_gets_the_same_answer(files: FileClient) -> None:
    files.send(OPEN, b"@SYS/tasks.txt")
    files.send(OPEN, b"@SYS/tasks.txt")
    first, second = files.heard()
    assert first == second


def test_clients_with_the_same_session_do_not_disturb_each_other(bench: Bench) -> None:
    one, two = FileClient(bench), FileClient(bench)
    one.ask(OPEN, b"@SYS/tasks.txt")
    two.ask(OPEN, b"@PARAM/param.pck")
    assert one.ask(READ, size=5).data == b"Heart"
    assert two.ask(READ, size=2).data == b"\x1b\x67"
    two.ask(RESET)
    assert one.ask(READ, size=5).data == b"Heart"


def test_uploaded_lists_are_files_too(bench: Bench, files: FileClient) -> None:
    content: Any = files.burst(b"@MISSION/fence.dat")
    assert struct.unpack("<5H", content) == (0x763D, 1, 0, 0, 0)
