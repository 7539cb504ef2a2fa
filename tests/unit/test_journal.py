"""The file journal: what it keeps through deaths, torn tails and wrong owners."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.adapters.file_journal import MAGIC, FileJournal, JournalError, JournalHeader

HEADER = JournalHeader("ridge", "merlin", "0123")


def reopened(path: Path) -> list[bytes]:
    journal = FileJournal.open(path, HEADER)
    records = list(journal.records())
    journal.close()
    return records


def written(path: Path, records: list[bytes]) -> bytes:
    journal = FileJournal.open(path, HEADER)
    journal.append(records)
    journal.close()
    return path.read_bytes()


def test_records_come_back_in_order_and_more_can_be_added(tmp_path: Path) -> None:
    path = tmp_path / "merlin" / "journal.bin"
    written(path, [b"one", b"", b"three" * 1000])
    written(path, [b"four"])
    assert reopened(path) == [b"one", b"", b"three" * 1000, b"four"]


@given(cut=st.integers(min_value=0), records=st.lists(st.binary(max_size=40), max_size=6))
def test_a_journal_cut_anywhere_keeps_a_prefix_and_takes_more(
    tmp_path_factory: pytest.TempPathFactory, cut: int, records: list[bytes]
) -> None:
    path = tmp_path_factory.mktemp("cut") / "journal.bin"
    content = written(path, records)
    path.write_bytes(content[: cut % (len(content) + 1)])
    kept = reopened(path)
    assert kept == records[: len(kept)]
    written(path, [b"later"])
    assert reopened(path) == [*kept, b"later"]


@given(position=st.integers(min_value=0), flip=st.integers(min_value=1, max_value=255))
def test_a_flipped_byte_costs_that_record_and_those_after_it(
    tmp_path_factory: pytest.TempPathFactory, position: int, flip: int
) -> None:
    path = tmp_path_factory.mktemp("flip") / "journal.bin"
    records = [bytes([number]) * 30 for number in range(5)]
    start = len(written(path, []))
    content = bytearray(written(path, records))
    position = start + position % (len(content) - start)
    content[position] ^= flip
    path.write_bytes(content)
    assert reopened(path) == records[: (position - start) // 38]


@pytest.mark.parametrize(
    ("header", "words"),
    [
        (JournalHeader("ridge", "kestrel", "0123"), "is the journal of merlin in mission ridge, not of kestrel"),
        (JournalHeader("valley", "merlin", "0123"), "is the journal of merlin in mission ridge"),
        (JournalHeader("ridge", "merlin", "4567"), "another area or cell size"),
    ],
)
def test_a_journal_of_somebody_else_is_refused(tmp_path: Path, header: JournalHeader, words: str) -> None:
    path = tmp_path / "journal.bin"
    before = written(path, [b"mine"])
    with pytest.raises(JournalError, match=words) as refusal:
        FileJournal.open(path, header)
    assert str(path) in str(refusal.value)
    assert path.read_bytes() == before


def test_a_second_agent_and_a_foreign_file_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "journal.bin"
    first = FileJournal.open(path, HEADER)
    with pytest.raises(JournalError, match="another agent is using"):
        FileJournal.open(path, HEADER)
    first.close()
    foreign = tmp_path / "notes.txt"
    foreign.write_bytes(b"shopping list")
    with pytest.raises(JournalError, match="is not a journal"):
        FileJournal.open(foreign, HEADER)
    assert foreign.read_bytes() == b"shopping list"
    with pytest.raises(JournalError, match="cannot be opened"):
        FileJournal.open(tmp_path, HEADER)
    with pytest.raises(JournalError, match="is not a journal"):
        FileJournal.open(Path(os.devnull), HEADER)


def test_a_full_disk_is_explained_and_leaves_whole_records(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "journal.bin"
    write = os.pwrite
    journal = FileJournal.open(path, HEADER)
    journal.append([b"kept"])
    monkeypatch.setattr(os, "pwrite", lambda descriptor, data, offset: write(descriptor, data[:7], offset))
    with pytest.raises(JournalError, match="the disk is full"):
        journal.append([b"lost"])
    monkeypatch.undo()
    journal.append([b"later"])
    journal.close()
    assert reopened(path) == [b"kept", b"later"]


def test_the_disk_is_reached_within_a_second_of_appending(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    now_s = 0.0
    synced: list[float] = []
    monkeypatch.setattr(os, "fsync", lambda _descriptor: synced.append(now_s))
    journal = FileJournal.open(tmp_path / "journal.bin", HEADER, clock=lambda: now_s)
    journal.append([b"a"])
    assert not synced
    now_s = 0.9
    journal.append([b"b"])
    assert not synced
    now_s = 1.0
    journal.sync_if_due()
    journal.sync_if_due()
    assert synced == [1.0]
    journal.close()
    assert (tmp_path / "journal.bin").read_bytes().startswith(MAGIC)
