"""Whatever states, results, scans and messages come in, in whatever order: a step never raises and what is said is said
in the wire's words."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.fakes.agent_bench import EPOCH_S
from tests.fakes.sim_missions import sim_plan
from vehicle_agent.agent import VehicleAgent
from vehicle_agent.domain.elevation import CellObservations
from vehicle_agent.ports import (
    ActionResult,
    Arm,
    AutopilotText,
    FlightMode,
    GoTo,
    Inbox,
    Land,
    Landed,
    SensorScan,
    TakeOff,
    VehicleState,
)
from vehicle_agent.wire.cells import pack_cells
from vehicle_agent.wire.codec import Codec
from vehicle_agent.wire.messages import (
    AnyMessage,
    Claim,
    Command,
    DeltaRecord,
    Digest,
    MapDelta,
    Repair,
    Stage,
    Status,
    StreamHeld,
    Verb,
)

PLAN = sim_plan(vehicles=3)
NAMES = (*PLAN.vehicle_names, "station-1", "eve")

numbers = st.one_of(st.floats(-50.0, 1_100.0), st.floats(allow_nan=True, allow_infinity=True))
points = st.one_of(
    st.tuples(st.floats(0.0, 1_000.0), st.floats(0.0, 1_000.0), st.floats(0.0, 400.0)),
    st.tuples(numbers, numbers, numbers),
)
slow = st.one_of(st.just((0.0, 0.0, 0.0)), st.tuples(*[st.floats(-20.0, 20.0)] * 3), st.tuples(*[numbers] * 3))
senders, small = st.sampled_from(NAMES), st.integers(0, 5)
cm = st.integers(-(10**8), 10**8)
positions_cm = st.one_of(
    st.tuples(st.integers(0, 10**5), st.integers(0, 10**5), st.integers(0, 40_000)), st.tuples(cm, cm, cm)
)
states = st.builds(
    VehicleState,
    stamp_ms=st.one_of(st.just(int(EPOCH_S * 1000)), st.integers(-5, 2**60)),
    position_enu_m=points,
    velocity_enu_m_s=slow,
    heading_deg=numbers,
    armed=st.booleans(),
    landed=st.sampled_from(Landed),
    mode=st.sampled_from(FlightMode),
    battery_fraction=st.one_of(st.none(), st.floats(0.0, 1.0), numbers),
    ready_to_arm=st.booleans(),
    home_enu_m=st.one_of(st.none(), points),
    rival_controller=st.sampled_from([False] * 9 + [True]),
)


def observations(indices: list[int], stamp_ms: int, elevation_dm: int) -> CellObservations:
    count = len(indices)
    return CellObservations(
        np.array(indices, dtype=np.int64),
        np.full(count, elevation_dm, dtype=np.int32),
        np.full(count, stamp_ms, dtype=np.int64),
    )


cells = st.builds(
    observations,
    st.lists(st.integers(0, PLAN.grid.cells - 1), max_size=30, unique=True).map(sorted),
    st.integers(0, 2**50),
    st.integers(-5_000, 9_000),
)
senseless_cells = st.builds(
    observations,
    st.lists(st.integers(-3, PLAN.grid.cells + 3), max_size=6),
    st.integers(-(2**40), 2**63 - 1),
    st.integers(-(2**31), 2**31 - 1),
)
header = {"sender": senders, "boot_id": small, "sequence": small, "stamp_ms": st.integers(0, 2**53)}
records = st.builds(DeltaRecord, senders, small, small, st.one_of(cells.map(pack_cells), st.binary(max_size=30)))
messages: st.SearchStrategy[AnyMessage] = st.one_of(
    st.builds(
        Status,
        stage=st.sampled_from(Stage),
        mode=st.sampled_from(["guided", "return", "odd"]),
        armed=st.booleans(),
        position_cm=positions_cm,
        velocity_cm_s=positions_cm,
        heading_deg=st.integers(0, 360),
        battery_permille=st.integers(-1, 1_000),
        leg_end_cm=positions_cm,
        home_cm=positions_cm,
        known_permille=st.integers(0, 1_000),
        first_seen_cells=small,
        bytes_sent=small,
        messages_dropped=small,
        why=st.just(""),
        return_up_cm=cm,
        **header,
    ),
    st.builds(Claim, active=st.booleans(), goal_cm=positions_cm, cost_m=st.integers(0, 10**7), **header),
    st.builds(MapDelta, record=records, **header),
    st.builds(Repair, records=st.lists(records, max_size=3).map(tuple), **header),
    st.builds(
        Digest,
        streams=st.lists(st.builds(StreamHeld, senders, small, st.integers(0, 2**32 - 1)), max_size=4).map(tuple),
        **header,
    ),
    st.builds(
        Command,
        command_id=small,
        verb=st.sampled_from([Verb.HOLD, Verb.RESUME, Verb.RETURN, Verb.LAND]),
        targets=st.lists(senders, max_size=4).map(tuple),
        **header,
    ),
)
inboxes = st.builds(
    Inbox,
    state=st.one_of(states, st.none()),
    scans=st.lists(st.one_of(cells, senseless_cells).map(SensorScan), max_size=2),
    messages=st.lists(messages, max_size=4),
    results=st.lists(st.builds(ActionResult, st.integers(1, 20), st.booleans(), st.text(max_size=300)), max_size=3),
    texts=st.lists(st.builds(AutopilotText, st.integers(-1, 9), st.text(max_size=300)), max_size=2),
)


@given(
    st.lists(st.tuples(st.floats(0.0, 20.0), inboxes), max_size=25),
    st.integers(0, 2),
    st.lists(st.binary(max_size=20), max_size=2),
)
@settings(max_examples=100, deadline=None)
def test_a_step_never_raises(steps: list[tuple[float, Inbox]], index: int, journal: list[bytes]) -> None:
    agent = VehicleAgent(PLAN, index, 4, np.random.default_rng(0), journal)
    codec = Codec()
    now_s = EPOCH_S
    for dt_s, inbox in steps:
        now_s += dt_s
        was_refused = agent.stage is Stage.REFUSED
        outbox = agent.step(now_s, inbox)
        for message in outbox.messages:
            assert codec.decode(codec.encode(message)) == message
        for action in outbox.actions:
            if isinstance(action.order, GoTo):
                assert all(math.isfinite(coordinate) for coordinate in action.order.position_enu_m)
        if was_refused:
            assert agent.stage is Stage.REFUSED
            assert not outbox.actions


good_state = st.builds(
    VehicleState,
    stamp_ms=st.just(int(EPOCH_S * 1000)),
    position_enu_m=st.tuples(st.floats(20.0, 980.0), st.floats(20.0, 980.0), st.floats(50.0, 200.0)),
    armed=st.booleans(),
    landed=st.sampled_from(Landed),
    mode=st.sampled_from([mode for mode in FlightMode if mode is not FlightMode.GUIDED]),
    battery_fraction=st.floats(0.0, 1.0),
    ready_to_arm=st.just(True),
    home_enu_m=st.just((200.0, 200.0, 50.0)),
)


@given(st.lists(good_state, min_size=3, max_size=40))
@settings(max_examples=100, deadline=None)
def test_whoever_flies_in_another_mode_is_left_alone(told: list[VehicleState]) -> None:
    """Without a command, no flight order goes to an armed vehicle off the ground that is not in guided flight."""
    agent = VehicleAgent(PLAN, 0, 4, np.random.default_rng(0))
    now_s, results = EPOCH_S, []
    for state in told:
        now_s += 1.0
        outbox = agent.step(now_s, Inbox(state=state, results=results))
        results = [ActionResult(action.action_id, True) for action in outbox.actions]
        if state.armed and state.landed is not Landed.ON_GROUND:
            assert not [a for a in outbox.actions if isinstance(a.order, GoTo | Arm | TakeOff | Land)]
