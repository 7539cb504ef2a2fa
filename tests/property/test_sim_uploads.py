"""Whatever gets lost on the way, an upload counts as a whole or not at all; packed parameters lose nothing."""

from __future__ import annotations

import random
import string
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
from MAVProxy.modules.lib.param_ftp import ftp_param_decode

from sim_bridge.autopilot.dialect import mavlink
from sim_bridge.autopilot.param_pack import packed_parameters
from sim_bridge.parameters import Parameter, ParameterTable, ParameterType
from tests.fakes.sim_client import Asker, Bench

NAMES = st.text(string.ascii_uppercase[:3] + "_", min_size=1, max_size=16)
KINDS = st.sampled_from(list(ParameterType))


def item(number: int, tag: int) -> Any:
    return mavlink.MAVLink_mission_item_int_message(
        1, 1, number, 6, 16, 0, 1, 0, 0, 0, 0, 10_000 * tag + number, 7, 20.0, 0
    )


def upload(bench: Bench, asker: Asker, count: int, tag: int, lost: random.Random, share: float) -> bool:
    """Upload over a link that loses messages both ways; returns whether the client heard that it was accepted."""

    def survives() -> bool:
        return lost.random() >= share

    if survives():
        asker.send(mavlink.MAVLink_mission_count_message(1, 1, count, 0))
    for _ in range(400):
        for message in asker.heard():
            if not survives():
                continue
            if message.get_type() == "MISSION_REQUEST" and survives():
                asker.send(item(message.seq, tag))
            elif message.get_type() == "MISSION_ACK" and message.type in (0, 15):
                return bool(message.type == 0)
        bench.wait(0.05)
    return False


@settings(max_examples=25, deadline=None)
@given(count=st.integers(1, 8), share=st.sampled_from([0.0, 0.2, 0.5, 0.9]), seed=st.integers(0, 10_000))
def test_an_upload_counts_as_a_whole_or_not_at_all(count: int, share: float, seed: int) -> None:
    bench = Bench()
    assert upload(bench, bench.asker, 3, 1, random.Random(seed), 0.0)
    accepted = upload(bench, bench.asker, count, 2, random.Random(seed), share)
    stored = [(row.x // 10_000, row.x % 10_000) for row in bench.fleet.vehicles[0].flight_plan.mission]
    old, new = [(1, number) for number in range(3)], [(2, number) for number in range(count)]
    assert stored in (old, new)
    if accepted:
        assert stored == new


@settings(deadline=None)
@given(
    st.dictionaries(NAMES, st.tuples(KINDS, st.integers(-120, 120), st.integers(-120, 120)), min_size=1, max_size=40),
    st.booleans(),
)
def test_packed_parameters_come_out_as_they_went_in(
    rows: dict[str, tuple[ParameterType, int, int]], with_defaults: bool
) -> None:
    table = ParameterTable(
        (Parameter(name, kind, default) for name, (kind, default, _) in rows.items()),
        {name: float(value) for name, (_, _, value) in rows.items()},
    )
    decoded = ftp_param_decode(packed_parameters(table, with_defaults))
    assert [(name.decode(), value) for name, value, _ in decoded.params] == [
        (name, float(value)) for name, (_, _, value) in rows.items()
    ]
    if with_defaults:
        assert [value for _, value, _ in decoded.defaults] == [float(default) for _, default, _ in rows.values()]
