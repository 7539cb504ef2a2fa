"""The reducer: what a station believes after what it heard, in any order, twice, or not at all."""

from __future__ import annotations

import unicodedata
from dataclasses import replace

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground_station.fleet_state import MAX_LOG_ENTRIES, digest_streams, fold, reduce
from ground_station.inputs import AliveChanged, CommandSent, FleetInput, Heard, LinkCounted, Tick
from ground_station.ledger import MAX_RANGES, SequenceRanges
from ground_station.link import StationLink
from ground_station.picture import Condition, FleetState, Phase, VehiclePicture
from ground_station.text import clean
from tests.fakes.talking_fleet import EPOCH_MS, NAMES, ListLink, Voice, small_plan
from vehicle_agent.domain.elevation import ElevationMap
from vehicle_agent.wire.messages import AnyMessage, Command, Outcome, Severity, Stage, Verb

PLAN = small_plan()


@pytest.fixture
def state() -> FleetState:
    return FleetState.initial(PLAN, "station-0001", 9, 0.0)


def heard(*messages: AnyMessage, at_s: float = 0.0) -> list[FleetInput]:
    return [Heard(message, at_s) for message in messages]


def vehicle(state: FleetState, name: str) -> VehiclePicture:
    return next(one for one in state.vehicles if one.name == name)


def texts(state: FleetState, source: str) -> list[str]:
    return [entry.text for entry in state.log if entry.source == source]


class TestStatuses:
    def test_a_status_shows_where_a_vehicle_is_and_why(self, state: FleetState) -> None:
        state = reduce(state, Heard(Voice("osprey").status(12.0, position_cm=(100, -250, 3_000)), 5.0))
        osprey = vehicle(state, "osprey")
        assert osprey.position_enu_m == (1.0, -2.5, 30.0)
        assert osprey.status is not None
        assert osprey.status.why.startswith("frontier 40 m E")
        assert osprey.age_s(6.5) == 1.5

    def test_an_older_status_of_the_same_boot_changes_nothing(self, state: FleetState) -> None:
        voice = Voice("merlin")
        old, new = voice.status(1.0, battery_permille=900), voice.status(2.0, battery_permille=800)
        state = fold(state, heard(new, old))
        assert vehicle(state, "merlin").status == new

    def test_the_same_message_twice_is_counted_and_ignored(self, state: FleetState) -> None:
        message = Voice("merlin").event("landed")
        once = fold(state, heard(message))
        twice = fold(once, heard(message))
        assert twice.log == once.log
        assert twice.counters.repeated == 1

    def test_a_restarted_agent_starts_counting_from_zero(self, state: FleetState) -> None:
        first, second = Voice("merlin", boot_id=1), Voice("merlin", boot_id=2)
        for _ in range(5):
            late = first.status(10.0)
        state = fold(state, heard(late, second.status(11.0, battery_permille=500)))
        status = vehicle(state, "merlin").status
        assert status is not None
        assert status.battery_permille == 500
        assert "its agent was started anew" in texts(state, "merlin")

    def test_what_the_former_life_still_says_is_ignored(self, state: FleetState) -> None:
        first, second = Voice("merlin", boot_id=1), Voice("merlin", boot_id=2)
        late = [first.status(10.0), first.status(12.0), first.claim()]
        state = fold(state, heard(late[0], second.status(11.0, battery_permille=500), *late[1:]))
        merlin = vehicle(state, "merlin")
        assert merlin.status is not None
        assert merlin.status.boot_id == 2
        assert merlin.claim is None

    def test_strangers_are_counted_and_not_shown(self, state: FleetState) -> None:
        state = fold(state, heard(Voice("intruder").status(), Voice("intruder").event("hello")))
        assert state.counters.foreign == 2
        assert [one.name for one in state.vehicles] == list(NAMES)
        assert state.log == ()

    def test_bytes_per_second_are_of_vehicle_time(self, state: FleetState) -> None:
        voice = Voice("merlin")
        state = fold(state, heard(*(voice.status(second, bytes_sent=400 * second) for second in range(30))))
        assert vehicle(state, "merlin").bytes_per_s == pytest.approx(400)

    def test_a_restart_does_not_make_the_rate_negative(self, state: FleetState) -> None:
        state = fold(state, heard(Voice("merlin", 1).status(1.0, bytes_sent=90_000), Voice("merlin", 2).status(2.0)))
        assert vehicle(state, "merlin").bytes_per_s == 0.0

    def test_the_trail_is_bounded_and_ends_where_the_vehicle_is(self, state: FleetState) -> None:
        voice = Voice("merlin")
        statuses = [voice.status(second, position_cm=(2_000 * second, 0, 0)) for second in range(2_000)]
        trail = vehicle(fold(state, heard(*statuses)), "merlin").trail_en_m
        assert len(trail) <= 300
        assert trail[-1] == (20.0 * 1_999, 0.0)

    def test_a_claim_is_kept_until_a_newer_one(self, state: FleetState) -> None:
        voice = Voice("merlin")
        first, second = voice.claim(), voice.claim(active=False)
        assert vehicle(fold(state, heard(first)), "merlin").claim == first
        assert vehicle(fold(state, heard(second, first)), "merlin").claim == second


class TestLiveliness:
    def living(self, state: FleetState) -> FleetState:
        return fold(state, [*heard(Voice("merlin").status(), at_s=10.0), Tick(10.0)])

    @pytest.mark.parametrize(
        ("now_s", "condition"),
        [
            (10.5, Condition.LIVE),
            (11.9, Condition.LIVE),
            (12.1, Condition.SUSPECT),
            (13.9, Condition.SUSPECT),
            (14.1, Condition.LOST),
        ],
    )
    def test_silence_is_judged_from_when_the_next_status_was_due(
        self, state: FleetState, now_s: float, condition: Condition
    ) -> None:
        assert vehicle(reduce(self.living(state), Tick(now_s)), "merlin").condition is condition

    def test_at_ten_times_real_time_a_status_is_due_ten_times_as_soon(self, state: FleetState) -> None:
        voice = Voice("merlin")
        for tenth in range(60):
            state = fold(state, [*heard(voice.status(tenth), at_s=0.1 * tenth), Tick(0.1 * tenth)])
        assert state.speedup == pytest.approx(10.0)
        assert vehicle(reduce(state, Tick(5.9 + 1.05)), "merlin").condition is Condition.LIVE
        assert vehicle(reduce(state, Tick(5.9 + 1.2)), "merlin").condition is Condition.SUSPECT
        assert vehicle(reduce(state, Tick(5.9 + 3.2)), "merlin").condition is Condition.LOST

    def test_old_events_and_repairs_do_not_look_like_haste(self, state: FleetState) -> None:
        voice = Voice("merlin")
        state = fold(state, [*heard(voice.event("took off", 1.0), voice.delta([1], 2.0)), Tick(0.0)])
        for tenth in range(40):
            state = fold(state, [*heard(voice.status(600 + 0.1 * tenth), at_s=0.1 * tenth), Tick(0.1 * tenth)])
        assert state.speedup == pytest.approx(1.0)

    def test_a_dead_token_is_a_lost_vehicle_at_once(self, state: FleetState) -> None:
        state = fold(self.living(state), [AliveChanged("merlin", False, 10.1), Tick(10.1)])
        assert vehicle(state, "merlin").condition is Condition.LOST
        assert any(text.startswith("lost: its agent is gone") for text in texts(state, "merlin"))

    def test_a_status_after_the_dead_token_is_a_new_life(self, state: FleetState) -> None:
        state = fold(self.living(state), [AliveChanged("merlin", False, 10.1), Tick(10.1)])
        state = fold(state, [*heard(Voice("merlin", boot_id=2).status(1.0), at_s=10.6), Tick(10.7)])
        assert vehicle(state, "merlin").condition is Condition.LIVE
        assert any(text.startswith("heard again") for text in texts(state, "merlin"))

    def test_a_lost_vehicle_is_reported_once(self, state: FleetState) -> None:
        state = self.living(state)
        for second in range(11, 40):
            state = reduce(state, Tick(float(second)))
        assert len([text for text in texts(state, "merlin") if text.startswith("lost")]) == 1

    def test_a_vehicle_that_is_done_may_fall_silent(self, state: FleetState) -> None:
        state = fold(state, [*heard(Voice("merlin").status(stage=Stage.DONE)), Tick(0.0)])
        state = fold(state, [AliveChanged("merlin", False, 1.0), Tick(60.0)])
        assert vehicle(state, "merlin").condition is Condition.LEFT
        assert not any("lost" in text for text in texts(state, "merlin"))

    def test_a_vehicle_that_was_never_heard_is_awaited(self, state: FleetState) -> None:
        assert vehicle(reduce(state, Tick(500.0)), "merlin").condition is Condition.AWAITED


class TestPhases:
    def test_waiting_then_starting_then_working_then_done(self, state: FleetState) -> None:
        voices = [Voice(name) for name in NAMES]
        assert state.phase is Phase.WAITING
        phases = []
        for second, stage in enumerate((Stage.ARMING, Stage.WORKING, Stage.RETURNING, Stage.DONE)):
            state = fold(state, [*heard(*(voice.status(second, stage) for voice in voices), at_s=second), Tick(second)])
            phases.append(state.phase)
        assert phases == [Phase.STARTING, Phase.WORKING, Phase.RETURNING, Phase.DONE]

    def test_a_lost_vehicle_holds_up_the_end_for_a_while_only(self, state: FleetState) -> None:
        others = heard(*(Voice(name).status(stage=Stage.DONE) for name in NAMES[1:]))
        state = fold(state, [*others, *heard(Voice("merlin").status()), Tick(0.0)])
        state = fold(state, [AliveChanged("merlin", False, 1.0), Tick(1.0)])
        assert not state.finished
        assert state.phase is Phase.SILENT
        state = reduce(state, Tick(12.0))
        assert state.finished
        assert state.phase is Phase.DONE

    def test_silence_before_the_first_vehicle_is_no_end(self, state: FleetState) -> None:
        assert not reduce(state, Tick(1_000.0)).finished


class TestCommands:
    def sent(self, state: FleetState) -> tuple[FleetState, Command]:
        command = StationLink(ListLink(), "station-0001", 9).send_command(Verb.HOLD, ("merlin", "osprey"), EPOCH_MS)
        return reduce(state, CommandSent(command, 100.0)), command

    def test_each_target_answers_for_itself(self, state: FleetState) -> None:
        state, command = self.sent(state)
        answers = (Voice("merlin").answer(command), Voice("osprey").answer(command, Outcome.REFUSED, "a pilot flies"))
        state = fold(state, heard(*answers, at_s=100.5))
        track = state.commands[0]
        assert track.result_of("merlin", 101.0) == "accepted"
        assert track.result_of("osprey", 101.0) == "refused: a pilot flies"

    def test_silence_is_a_result_after_five_seconds(self, state: FleetState) -> None:
        state, command = self.sent(state)
        state = fold(state, [*heard(Voice("merlin").answer(command)), Tick(104.9)])
        assert state.commands[0].result_of("osprey", state.now_s) == "sent"
        state = fold(state, [Tick(105.1), Tick(106.0)])
        assert state.commands[0].result_of("osprey", state.now_s) == "timed out"
        assert texts(state, "osprey") == ["hold not answered within 5 s"]
        assert state.commands[0].result_of("merlin", state.now_s) == "accepted"

    def test_a_late_answer_still_counts(self, state: FleetState) -> None:
        state, command = self.sent(state)
        state = fold(state, [Tick(110.0), *heard(Voice("osprey").answer(command))])
        assert state.commands[0].result_of("osprey", 111.0) == "accepted"

    @pytest.mark.parametrize("change", [{"station": "station-9999"}, {"station_boot_id": 8}, {"command_id": 77}])
    def test_answers_to_others_are_logged_only(self, state: FleetState, change: dict[str, object]) -> None:
        state, command = self.sent(state)
        answer = msgspec.structs.replace(Voice("merlin").answer(command), **change)
        state = fold(state, heard(answer))
        assert state.commands[0].answers == {}
        assert texts(state, "merlin")[-1].startswith("hold accepted")


class TestHostileInput:
    def test_control_characters_never_reach_the_picture(self, state: FleetState) -> None:
        evil = "\x1b[2J\x07\u202ered\x9b31m\tok\r\nnext"
        voice = Voice("merlin")
        state = fold(state, heard(voice.event(evil, code="a\x1bb"), voice.status(why=evil, mode="\x1b]0;x\x07")))
        status = vehicle(state, "merlin").status
        assert status is not None
        for text in (state.log[0].text, state.log[0].code, status.why, status.mode):
            assert text.isprintable()

    @given(st.text())
    def test_clean_text_is_printable_and_as_wide_as_it_is_long(self, text: str) -> None:
        safe = clean(text, 40)
        assert len(safe) <= 40
        assert safe.isprintable()
        assert not any(unicodedata.east_asian_width(character) in "WF" for character in safe)
        assert not any(unicodedata.category(character)[0] in "MC" for character in safe)

    def test_over_long_text_is_cut_and_says_so(self) -> None:
        assert clean("x" * 500, 10) == "x" * 9 + "…"

    def test_the_log_is_bounded_and_knows_how_much_there_was(self, state: FleetState) -> None:
        voice = Voice("merlin")
        for _ in range(3):
            state = fold(state, heard(*(voice.event(f"number {n}") for n in range(MAX_LOG_ENTRIES))))
        assert len(state.log) == MAX_LOG_ENTRIES
        assert state.log_total == 3 * MAX_LOG_ENTRIES
        assert state.log[-1].number == state.log_total - 1

    def test_link_counts_become_bad_messages(self, state: FleetState) -> None:
        assert reduce(state, LinkCounted(3, 4)).counters.bad == 7

    def test_endless_new_streams_are_refused(self, state: FleetState) -> None:
        for stream_id in range(400):
            state = fold(state, heard(Voice("merlin", boot_id=stream_id, stream_id=stream_id).delta([1])))
        assert len(digest_streams(state)) <= 256

    def test_a_stamp_before_the_year_2000_does_not_begin_the_mission(self, state: FleetState) -> None:
        odd = msgspec.structs.replace(Voice("merlin").status(), stamp_ms=5_000)
        state = fold(state, heard(odd, Voice("kestrel").status(10.0), Voice("osprey").event("later", 25.0)))
        assert state.elapsed_s == 15.0

    def test_severities_are_kept(self, state: FleetState) -> None:
        state = fold(state, heard(Voice("merlin").event("engine", severity=Severity.CRITICAL)))
        assert state.log[0].severity is Severity.CRITICAL


class TestSequenceRanges:
    @given(st.lists(st.integers(0, 40)))
    def test_it_is_a_set(self, numbers: list[int]) -> None:
        ranges = SequenceRanges()
        for number in numbers:
            ranges = ranges.with_number(number)
        assert [number for number in range(42) if number in ranges] == sorted(set(numbers))
        missing = [number for number in range(42) if number not in set(numbers)]
        assert ranges.contiguous == missing[0]
        assert all(stop < start for (_, stop), (start, _) in zip(ranges.ranges, ranges.ranges[1:], strict=False))

    def test_it_is_bounded(self) -> None:
        ranges = SequenceRanges()
        for number in range(0, 4 * MAX_RANGES, 2):
            ranges = ranges.with_number(number)
        assert len(ranges.ranges) == MAX_RANGES
        assert 4 * MAX_RANGES - 2 in ranges


def test_equal_inputs_make_equal_states(state: FleetState) -> None:
    def inputs() -> list[FleetInput]:
        voice = Voice("merlin")
        return [*heard(voice.status(1.0), voice.delta([1, 2]), voice.event("x")), Tick(3.0)]

    one, other = fold(state, inputs()), fold(state, inputs())
    assert one.team_map.elevation == other.team_map.elevation
    assert replace(one, team_map=state.team_map) == replace(other, team_map=state.team_map)


def test_the_reducer_in_one_batch_equals_the_reducer_one_by_one(state: FleetState) -> None:
    voices = [Voice(name) for name in NAMES]
    inputs: list[FleetInput] = []
    for second in range(8):
        inputs += heard(
            *(voice.status(second) for voice in voices), *(voice.delta([second]) for voice in voices), at_s=second
        )
        inputs.append(Tick(float(second)))
    single = state
    for event in inputs:
        single = reduce(single, event)
    batch = fold(state, inputs)
    assert batch.team_map.elevation == single.team_map.elevation
    assert ElevationMap(PLAN.grid) != batch.team_map.elevation
    assert batch.log == single.log
    assert batch.vehicles == single.vehicles
