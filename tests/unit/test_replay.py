"""Recordings: what is read back is what was heard, a replay ends where the live run ended, and broken files say so."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import msgspec
import pytest
from hypothesis import given
from mcap.reader import make_reader

from ground_station.inputs import Acknowledged, FleetInput, Heard, Muted
from ground_station.payload import polygon
from ground_station.picture import FleetState
from ground_station.plain import replay_lines
from ground_station.player import Player
from ground_station.recording import FILE_NAME, Recording, RecordingError, RecordingWriter
from ground_station.station import Station
from ground_station.wire_json import from_object, schema_of, to_object, topic_name
from tests.fakes.pictures import same_picture
from tests.fakes.talking_fleet import NAMES, ListLink, Voice, small_plan
from tests.property.test_wire_codec import MESSAGES
from vehicle_agent.wire.keys import topic_of
from vehicle_agent.wire.messages import Message, Orders, Outcome, Stage, Verb, Zone

CORNERS = ((1_000, 1_000), (9_000, 1_000), (9_000, 9_000))


def fly(folder: Path, seconds: int = 60) -> FleetState:
    """Record a small run with everything in it; the last picture."""
    recording = RecordingWriter(folder / FILE_NAME)
    station, link = Station(small_plan(), "station-0001", 9, 1_000.1, recording=recording), ListLink()
    station.attach(link)
    voices = {name: Voice(name) for name in NAMES}
    for second in range(seconds):
        for at, name in enumerate(NAMES):
            voice = voices[name]
            if name == "osprey" and second > 30:
                continue
            link.arriving += [voice.status(second / 3, position_cm=(2_000 + 100 * second, 2_000 * at, 3_000))]
            link.arriving += [voice.delta(range(100 * at + second, 100 * at + second + 3), second / 3)]
        if second == 5:
            number = station.command(Verb.NO_FLY, NAMES, 1_000.1 + second, polygon([(10, 10), (90, 10), (90, 90)], 1))
            assert number == 0
            command = link.commands()[0]
            link.arriving += [voices["merlin"].answer(command), voices["osprey"].answer(command, Outcome.REFUSED, "no")]
            head = voices["merlin"].event("x")
            link.arriving.append(
                Orders(
                    sender="merlin", boot_id=1, sequence=head.sequence, stamp_ms=head.stamp_ms,
                    no_fly=(Zone(1, CORNERS),),
                )
            )  # fmt: skip
        if second == 20:
            link.alive_changes += [("merlin", True), ("kestrel", False)]
            link.counters.undecodable = 3
        if second == 40:
            station.take([Acknowledged("osprey", "OUT_OF_REACH"), Muted("kestrel", "AGENT_DEAD")])
            link.arriving += [voices["merlin"].claim(), voices["merlin"].digest(("merlin", 7, 90))]
            link.arriving += [voices["kestrel"].event("grüße\x1b[2J", second / 3)]
        station.step(1_000.1 + second + 0.1)
        link.arriving += [Voice("stranger").status(1.0)] if second == 3 else []
        station.step(1_000.1 + second + 0.6)
    station.close()
    return station.state


def test_a_replay_ends_in_exactly_the_live_runs_picture(tmp_path: Path) -> None:
    live = fly(tmp_path)
    player = Player(Recording(tmp_path))
    assert same_picture(player.play_to_end(), live)
    assert player.recording.complete


def test_seeking_there_and_back_changes_nothing(tmp_path: Path) -> None:
    live = fly(tmp_path)
    player = Player(Recording(tmp_path))
    player.seek(35.0)
    middle = player.state
    assert middle.now_s == pytest.approx(1_035.1, abs=0.7)
    player.seek(5.0)
    assert player.state.team_map.coverage < middle.team_map.coverage
    player.seek(35.0)
    assert same_picture(player.state, middle)
    player.seek(1e9)
    assert same_picture(player.state, live)


def test_time_passes_at_the_chosen_speed_and_stands_when_paused(tmp_path: Path) -> None:
    fly(tmp_path)
    player = Player(Recording(tmp_path))
    player.step(50.0)
    player.step(55.0)
    assert player.position_s == pytest.approx(5.0, abs=1.0)
    player.faster(1)
    player.step(60.0)
    assert player.position_s == pytest.approx(15.0, abs=1.0)
    player.toggle()
    before = player.state
    player.step(99.0)
    assert player.state is before
    player.step_forward()
    assert player.position_s > before.now_s - 1_000.1
    assert not player.playing


def test_nothing_can_be_sent_into_the_past(tmp_path: Path) -> None:
    fly(tmp_path)
    player = Player(Recording(tmp_path))
    assert player.command(Verb.HOLD, NAMES, 0.0) is None


@pytest.mark.parametrize("share", [0.999, 0.9, 0.7, 0.5])
def test_a_recording_cut_off_in_the_middle_plays_what_is_there_and_says_so(tmp_path: Path, share: float) -> None:
    fly(tmp_path)
    content = (tmp_path / FILE_NAME).read_bytes()
    chunks_end = Recording(tmp_path)._spans[-1].offset
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(content[: max(int(share * len(content)), chunks_end if share > 0.8 else 0)])
    recording = Recording(cut)
    assert not recording.complete
    player = Player(recording)
    assert player.play_to_end().heard_any
    assert "is cut off" in list(replay_lines(Player(Recording(cut)), 5.0))[-1]


def test_damage_in_the_middle_is_survived(tmp_path: Path) -> None:
    fly(tmp_path)
    content = bytearray((tmp_path / FILE_NAME).read_bytes())
    spans = Recording(tmp_path)._spans
    at = spans[len(spans) // 2].offset + 200
    content[at : at + 60] = bytes(60)
    bad = tmp_path / "bad.mcap"
    bad.write_bytes(bytes(content))
    assert Player(Recording(bad)).play_to_end().heard_any


@pytest.mark.parametrize("content", [None, b"", b"not a recording", b"\x89MCAP0\r\n" + bytes(200)])
def test_what_is_no_recording_is_refused_in_one_sentence(tmp_path: Path, content: bytes | None) -> None:
    path = tmp_path / "run.mcap"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(RecordingError, match=r"run\.mcap") as refusal:
        Recording(path)
    assert "\n" not in str(refusal.value)


def test_any_mcap_reader_finds_json_with_schemas_and_places_on_earth(tmp_path: Path) -> None:
    fly(tmp_path)
    topics: dict[str, Any] = {}
    with (tmp_path / FILE_NAME).open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema is not None
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            content, declared = json.loads(message.data), json.loads(schema.data)
            assert declared["type"] == "object"
            assert set(content) <= set(declared["properties"])
            topics[channel.topic] = content
    assert topics["/merlin/status"]["stage"] == Stage.WORKING.name.lower()
    assert topics["/merlin/location"]["latitude"] == pytest.approx(47.0, abs=0.01)
    assert {"/station/tick", "/station/sent", "/merlin/map", "/merlin/result", "/others/status"} <= set(topics)


def test_plain_lines_of_a_replay_tell_the_end(tmp_path: Path) -> None:
    live = fly(tmp_path)
    lines = list(replay_lines(Player(Recording(tmp_path)), 5.0))
    assert f"coverage={100 * live.team_map.coverage:.1f}%" in lines[-1]
    assert sum(line.startswith("event") for line in lines) == live.log_total


@given(MESSAGES.filter(lambda message: topic_of(message).over_radio))
def test_messages_come_back_from_json_as_they_were(message: Message) -> None:
    event = Heard(message, 12.5)  # type: ignore[arg-type]
    content = msgspec.json.decode(msgspec.json.encode(to_object(event)))
    assert from_object(topic_name(event), content) == event
    assert set(content) <= set(schema_of(topic_name(event))["properties"])


@pytest.mark.parametrize("content", [{}, {"station_s": 1.0}, {"station_s": "x", "sender": 3}, {"now_s": 1, "x": 2}])
def test_wrong_objects_are_left_out(content: dict[str, Any]) -> None:
    for name in ("status", "tick", "sent", "claim", "nonsense"):
        found: FleetInput | None = from_object(name, content)
        assert found is None
