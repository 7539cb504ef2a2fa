"""The map that a station makes of what its fleet tells: merged in any order, repaired where records are missing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground_station.fleet_state import digest_streams, fold
from ground_station.inputs import FleetInput, Heard, Tick
from ground_station.picture import FleetState
from ground_station.station import DIGEST_PERIOD_S, Station
from ground_station.team_map import coverage_curve, frontier_cells
from tests.fakes.talking_fleet import NAMES, ListLink, Voice, small_plan
from vehicle_agent.wire.messages import AnyMessage, DeltaRecord, StreamHeld

PLAN = small_plan()


@pytest.fixture
def state() -> FleetState:
    return FleetState.initial(PLAN, "station-0001", 9, 0.0)


def heard(*messages: AnyMessage, at_s: float = 0.0) -> list[FleetInput]:
    return [Heard(message, at_s) for message in messages]


class TestTheMap:
    def test_observations_of_the_team_are_merged(self, state: FleetState) -> None:
        merlin, osprey = Voice("merlin"), Voice("osprey")
        state = fold(state, heard(merlin.delta([0, 1, 2], 5.0), osprey.delta([2, 3], 4.0)))
        assert state.team_map.observed_cells == 4
        assert state.team_map.coverage == 4 / 400
        assert state.team_map.first_seen_cells == pytest.approx((2.0, 0.0, 2.0, 0.0))

    def test_a_tie_is_shared(self, state: FleetState) -> None:
        state = fold(state, heard(Voice("merlin").delta([7], 5.0), Voice("osprey").delta([7], 5.0)))
        assert state.team_map.first_seen_cells == pytest.approx((0.5, 0.0, 0.5, 0.0))

    def test_snapshots_do_not_change_afterwards(self, state: FleetState) -> None:
        before = fold(state, heard(Voice("merlin").delta([0])))
        after = fold(before, heard(Voice("kestrel").delta([1])))
        assert np.count_nonzero(before.team_map.elevation.observed) == 1
        assert after.team_map.version == before.team_map.version + 1
        with pytest.raises(ValueError, match="read-only"):
            after.team_map.elevation.elevation_dm[0, 0] = 1

    def test_nothing_is_copied_when_nothing_was_observed(self, state: FleetState) -> None:
        assert fold(state, [*heard(Voice("merlin").status()), Tick(1.0)]).team_map is state.team_map

    @given(st.data())
    def test_any_order_and_any_repetition_make_the_same_map(self, data: st.DataObject) -> None:
        voices = [Voice(name) for name in NAMES]
        records = [
            data.draw(st.sampled_from(voices)).record(
                data.draw(st.lists(st.integers(0, 399), min_size=1, max_size=8, unique=True)),
                data.draw(st.integers(0, 20)),
                data.draw(st.integers(0, 3)),
            )
            for _ in range(data.draw(st.integers(1, 8)))
        ]
        shuffled = data.draw(st.permutations(records)) + data.draw(st.lists(st.sampled_from(records)))
        carrier, other = Voice("merlin"), Voice("kestrel")
        start = FleetState.initial(PLAN, "station-0001", 9, 0.0)
        straight = fold(start, heard(*(carrier.repair(record) for record in records)))
        mixed = start
        for record in shuffled:
            mixed = fold(mixed, heard(other.repair(record)))
        assert straight.team_map.elevation == mixed.team_map.elevation
        assert straight.team_map.seen_per_second == mixed.team_map.seen_per_second
        assert straight.team_map.first_seen_cells == pytest.approx(mixed.team_map.first_seen_cells)
        assert straight.team_map.observed_cells == int(np.count_nonzero(straight.team_map.elevation.observed))
        for index in range(len(NAMES)):
            share = straight.team_map.elevation.first_observer_share(index)
            assert straight.team_map.first_seen_cells[index] == pytest.approx(share)
        assert set(digest_streams(straight)) == set(digest_streams(mixed))

    def test_cells_of_another_grid_are_counted_and_not_asked_for_again(self, state: FleetState) -> None:
        state = fold(state, heard(Voice("merlin").delta([4_000])))
        assert state.counters.malformed == 1
        assert state.team_map.observed_cells == 0
        assert digest_streams(state) == (StreamHeld("merlin", 7, 1),)

    def test_the_curve_is_drawn_from_the_stamps_of_the_map(self, state: FleetState) -> None:
        voice = Voice("merlin")
        state = fold(state, heard(voice.delta(range(100), 1.0), voice.delta(range(200), 60.0)))
        curve = coverage_curve(state.team_map, state.started_ms)
        assert [share for _, share in curve] == pytest.approx([0.25, 0.5])
        assert curve[1][0] - curve[0][0] == pytest.approx(59.0)

    def test_a_long_curve_is_thinned_and_keeps_its_end(self, state: FleetState) -> None:
        voice = Voice("merlin")
        state = fold(state, heard(*(voice.delta([cell], cell) for cell in range(400))))
        curve = coverage_curve(state.team_map, state.started_ms, points=50)
        assert len(curve) <= 50
        assert curve[-1][1] == 1.0

    def test_frontiers_are_observed_cells_beside_unobserved_ones(self, state: FleetState) -> None:
        rows = PLAN.grid.rows
        block = [column * rows + row for column in range(3) for row in range(3)]
        frontiers = frontier_cells(fold(state, heard(Voice("merlin").delta(block))).team_map)
        assert {tuple(cell) for cell in np.argwhere(frontiers).tolist()} == {(2, 0), (2, 1), (2, 2), (0, 2), (1, 2)}


class TestDigests:
    def test_records_count_as_held_only_without_a_gap(self, state: FleetState) -> None:
        voice = Voice("merlin")
        records = [voice.record([number]) for number in range(4)]
        state = fold(state, heard(voice.repair(records[0], records[2], records[3])))
        assert digest_streams(state) == (StreamHeld("merlin", 7, 1),)
        assert state.records_missing == 3
        state = fold(state, heard(voice.repair(records[1])))
        assert digest_streams(state) == (StreamHeld("merlin", 7, 4),)
        assert state.records_missing == 0

    def test_others_digests_tell_what_is_missing(self, state: FleetState) -> None:
        state = fold(state, heard(Voice("kestrel").digest(("merlin", 7, 12), ("stranger", 1, 99))))
        assert state.records_missing == 12
        assert digest_streams(state) == (StreamHeld("merlin", 7, 0),)

    def test_a_restarted_station_rebuilds_the_same_map_from_repairs(self, state: FleetState) -> None:
        voices = [Voice(name) for name in NAMES]
        records: list[DeltaRecord] = [
            voice.record([10 * index + n], n) for index, voice in enumerate(voices) for n in range(9)
        ]
        full = fold(state, heard(*(voices[0].repair(record) for record in records)))
        restarted = FleetState.initial(PLAN, "station-0002", 10, 50.0)
        restarted = fold(restarted, heard(voices[1].repair(*records[18:]), voices[2].repair(*records[:27])))
        assert restarted.team_map.elevation == full.team_map.elevation
        assert restarted.team_map.first_seen_cells == pytest.approx(full.team_map.first_seen_cells)

    def test_the_station_asks_at_once_and_again_when_an_agent_comes_within_reach(self) -> None:
        station, link = Station(PLAN, "station-0001", 9, 0.0), ListLink()
        station.attach(link)
        station.step(0.0)
        assert len(link.digests()) == 1
        link.alive_changes.append(("merlin", True))
        station.step(0.2)
        station.step(1.0)
        assert len(link.digests()) == 2
        station.step(1.5)
        assert len(link.digests()) == 2
        station.step(1.0 + DIGEST_PERIOD_S)
        assert len(link.digests()) == 3

    def test_the_station_asks_faster_while_it_knows_that_records_are_missing(self) -> None:
        station, link = Station(PLAN, "station-0001", 9, 0.0), ListLink()
        station.attach(link)
        station.step(0.0)
        link.arriving.append(Voice("merlin").digest(("merlin", 7, 5)))
        for tenth in range(1, 16):
            station.step(0.1 * tenth)
        assert len(link.digests()) >= 3
        assert link.digests()[-1].streams == (StreamHeld("merlin", 7, 0),)
