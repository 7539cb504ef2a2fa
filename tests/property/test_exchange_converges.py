"""Any schedule of scans, losses, repetitions, delays, silences and restarts ends in equal maps once digests flow."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_agent.behaviour.elevation_share import ElevationShare
from vehicle_agent.behaviour.map_exchange import MapExchange, encode_record
from vehicle_agent.domain.elevation import CellObservations, ElevationMap
from vehicle_agent.domain.grid import Grid
from vehicle_agent.ports import SensorScan
from vehicle_agent.wire.messages import DeltaRecord, Digest

GRID = Grid(0.0, 0.0, 10.0, 6, 5)
TEAM = ("ada", "bob", "cyd")
STATION = 3

cells = st.lists(st.integers(0, GRID.cells - 1), min_size=1, max_size=8, unique=True).map(sorted)
steps = st.lists(
    st.one_of(
        st.tuples(st.just("scan"), st.integers(0, 2), cells, st.integers(0, 3), st.integers(0, 5)),
        st.tuples(st.just("say"), st.integers(0, 2), st.sets(st.integers(0, 3))),
        st.tuples(st.just("again"), st.integers(0, 200), st.integers(0, 3)),
        st.tuples(st.just("restart"), st.integers(0, 2)),
        st.tuples(st.just("wipe"), st.integers(0, 2)),
        st.tuples(st.just("digest"), st.integers(0, 3), st.sets(st.integers(0, 3))),
    ),
    max_size=60,
)


class Network:
    """Three vehicles and a station (which holds streams, and has none of its own)."""

    def __init__(self) -> None:
        self.boots = 0
        self.journals: list[list[bytes]] = [[], [], []]
        self.dead: set[int] = set()
        self.said: list[DeltaRecord] = []
        self.truth = ElevationMap(GRID)
        self.now_s = 0.0
        self.nodes = [self.boot(index) for index in range(3)]
        # A station is a listener that never observes: any team index will do for it.
        self.nodes.append(MapExchange(ElevationShare(GRID, 0), TEAM, 0, 999_999))

    def boot(self, index: int) -> MapExchange:
        self.boots += 1
        return MapExchange(ElevationShare(GRID, index), TEAM, index, self.boots, self.journals[index])

    def say(self, index: int, heard_by: set[int]) -> None:
        record = self.nodes[index].next_record()
        if record is None:
            return
        self.journals[index].append(encode_record(record))
        self.said.append(record)
        for node in heard_by - self.dead - {index}:
            self.nodes[node].receive([record])

    def digest(self, index: int, heard_by: set[int]) -> None:
        self.now_s += 5.0
        name = TEAM[index] if index != STATION else "station"
        digest = Digest(sender=name, boot_id=0, sequence=0, stamp_ms=0, streams=self.nodes[index].digest())
        living = [TEAM[n] for n in range(3) if n not in self.dead]
        for node in sorted(heard_by - self.dead - {index, STATION}):
            repair = self.nodes[node].repair_for(digest, living, self.now_s)
            for hearer in range(4):
                if hearer not in self.dead and hearer != node:
                    self.nodes[hearer].receive(repair, self.now_s)


def play(network: Network, schedule: list[tuple[object, ...]]) -> None:
    for step in schedule:
        match step:
            case ("scan", int(index), list(indices), int(second), int(height)):
                count = len(indices)
                scan = CellObservations(
                    np.array(indices, dtype=np.int64),
                    np.full(count, height, dtype=np.int32),
                    np.full(count, 1_000 * second, dtype=np.int64),
                )
                network.nodes[index].observe(SensorScan(scan))
            case ("say", int(index), set(heard_by)):
                network.say(index, heard_by)
            case ("again", int(which), int(node)) if network.said:
                network.nodes[node].receive([network.said[which % len(network.said)]])
            case ("restart", int(index)):
                network.nodes[index] = network.boot(index)
            case ("wipe", int(index)):  # a new disk
                network.journals[index].clear()
                network.nodes[index] = network.boot(index)
            case ("digest", int(index), set(heard_by)):
                network.digest(index, heard_by)


def settle(network: Network) -> None:
    everybody = set(range(4))
    for _ in range(12):
        for index in range(4):
            if index not in network.dead:
                network.digest(index, everybody)


def assert_agreed(network: Network) -> None:
    """Living vehicles hold the same; the station, which nobody depends on, holds at least that."""
    vehicles = [network.nodes[index].team_map for index in range(3) if index not in network.dead]
    assert all(team_map == vehicles[0] for team_map in vehicles[1:])
    station = network.nodes[STATION].team_map
    joined = station.copy()
    joined.merge(vehicles[0])
    assert joined == station


@given(steps)
@settings(max_examples=150, deadline=None)
def test_all_living_maps_become_equal(schedule: list[tuple[object, ...]]) -> None:
    network = Network()
    play(network, schedule)
    for index in range(3):
        network.say(index, set())  # the last words, lost on everybody
    settle(network)
    assert_agreed(network)
    held = {(r.origin, r.stream_id, r.delta_sequence) for r in network.said}
    everything = {key for node in network.nodes for key in keys_of(node)}
    assert everything <= held


def keys_of(node: MapExchange) -> set[tuple[str, int, int]]:
    return {
        (origin, stream_id, sequence)
        for (origin, stream_id), stream in node._streams.items()
        for sequence in stream.records
    }


@given(steps, st.integers(0, 2))
@settings(max_examples=150, deadline=None)
def test_what_a_dead_vehicle_told_anybody_reaches_everybody(schedule: list[tuple[object, ...]], victim: int) -> None:
    network = Network()
    play(network, [step for step in schedule if step[0] not in ("wipe", "restart")])
    heard = [network.nodes[node].team_map.copy() for node in range(3) if node != victim]
    network.dead.add(victim)
    for index in set(range(3)) - {victim}:
        network.say(index, set())
    settle(network)
    assert_agreed(network)
    for before in heard:
        for node in set(range(4)) - network.dead:
            assert np.all(network.nodes[node].team_map.observed[before.observed])
