"""The MAVSDK adapter against a scripted ArduCopter: what it asks, what it understands, what it survives."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from tests.fakes.copter import UNIX_EPOCH_MS, Behaviour, ScriptedCopter, free_port, scripted_copter
from tests.fakes.waiting import until
from vehicle_agent.adapters.mavsdk_autopilot import AutopilotError, MavsdkAutopilot
from vehicle_agent.domain.frames import Datum, Geodetic
from vehicle_agent.ports import (
    Action,
    ActionResult,
    Arm,
    AutopilotText,
    FlightMode,
    GoTo,
    Hold,
    Landed,
    Order,
    ReturnHome,
    SetParameter,
    TakeOff,
    VehicleState,
)

DATUM = Datum(36.57, -84.27)
CONTROLLER_ID = 101
DEADLINE_S = 20.0
SET_MODE, TAKE_OFF, REPOSITION, ARM, SET_INTERVAL = 176, 22, 192, 400, 511


class Agent:
    """Polls an adapter until something holds, keeping all that came out."""

    def __init__(self, autopilot: MavsdkAutopilot) -> None:
        self.autopilot = autopilot
        self.states: list[VehicleState] = []
        self.results: list[ActionResult] = []
        self.texts: list[AutopilotText] = []
        self._actions = 0

    def until(self, condition: Callable[[], bool], what: str) -> None:
        def polled() -> bool:
            if condition():
                return True
            state, results, texts = self.autopilot.poll()
            self.states += [state] if state else []
            self.results += results
            self.texts += texts
            return False

        until(polled, what)

    def submit(self, order: Order) -> int:
        self._actions += 1
        self.autopilot.submit(Action(self._actions, order))
        return self._actions

    def result_of(self, action_id: int) -> ActionResult:
        def found() -> list[ActionResult]:
            return [result for result in self.results if result.action_id == action_id]

        self.until(lambda: bool(found()), f"the result of action {action_id}")
        assert len(found()) == 1
        return found()[0]

    def ready(self) -> None:
        self.until(lambda: bool(self.states) and self.states[-1].ready_to_arm, "the vehicle to be ready")


@contextmanager
def flown(port: int, connect_timeout_s: float = DEADLINE_S) -> Iterator[Agent]:
    autopilot = MavsdkAutopilot(
        f"tcpout://127.0.0.1:{port}", 1, CONTROLLER_ID, DATUM, connect_timeout_s=connect_timeout_s
    )
    try:
        yield Agent(autopilot)
    finally:
        autopilot.close()


@pytest.fixture
def behaviour() -> Behaviour:
    return Behaviour(speedup=10.0)


@pytest.fixture
def pair(behaviour: Behaviour) -> Iterator[tuple[ScriptedCopter, Agent]]:
    port = free_port()
    with scripted_copter(port, behaviour) as copter, flown(port) as agent:
        yield copter, agent


def test_states_are_in_the_missions_frame_and_the_vehicles_time(pair: tuple[ScriptedCopter, Agent]) -> None:
    copter, agent = pair
    agent.ready()
    state = agent.states[-1]
    assert UNIX_EPOCH_MS < state.stamp_ms <= UNIX_EPOCH_MS + copter.boot_ms
    assert state.position_enu_m == pytest.approx((0.0, 0.0, 400.0), abs=0.02)
    assert state.velocity_enu_m_s == pytest.approx((2.0, 1.0, 3.0))
    assert state.heading_deg == pytest.approx(90.0)
    assert state.home_enu_m == pytest.approx((0.0, 0.0, 400.0), abs=0.02)
    assert state.battery_fraction == pytest.approx(0.73)
    assert (state.armed, state.landed, state.rival_controller) == (False, Landed.ON_GROUND, False)
    stamps = [each.stamp_ms for each in agent.states]
    assert stamps == sorted(set(stamps))


def test_a_flight_from_parameters_to_return(pair: tuple[ScriptedCopter, Agent]) -> None:
    copter, agent = pair
    agent.ready()
    assert agent.result_of(agent.submit(SetParameter("SYSID_MYGCS", CONTROLLER_ID))).accepted
    assert copter.behaviour.parameters["SYSID_MYGCS"] == CONTROLLER_ID
    assert agent.result_of(agent.submit(Arm())).accepted
    assert [(command.param1, command.param2) for command in copter.commands(SET_MODE)] == [(1.0, 4.0)]
    agent.until(lambda: agent.states[-1].armed and agent.states[-1].mode is FlightMode.GUIDED, "an armed state")
    assert agent.result_of(agent.submit(TakeOff(60.0))).accepted
    assert copter.commands(TAKE_OFF)[0].param7 == pytest.approx(60.0)
    assert agent.result_of(agent.submit(GoTo((1500.0, -700.0, 512.5)))).accepted
    target = copter.commands(REPOSITION)[0]
    assert (target.frame, target.param2, target.get_srcSystem(), target.get_srcComponent()) == (5, 1.0, 101, 191)
    agent.until(
        lambda: agent.states[-1].position_enu_m == pytest.approx((1500.0, -700.0, 512.5), abs=0.02), "the target"
    )
    assert agent.result_of(agent.submit(Hold())).accepted
    agent.until(lambda: agent.states[-1].mode is FlightMode.HOLD, "holding")
    assert agent.result_of(agent.submit(ReturnHome())).accepted
    agent.until(lambda: agent.states[-1].mode is FlightMode.RETURN, "returning")


def test_heartbeats_follow_the_vehicles_clock_and_stop_when_nobody_polls(pair: tuple[ScriptedCopter, Agent]) -> None:
    copter, agent = pair

    def ours() -> int:
        return sum(message.type == 18 for message in copter.heartbeats())

    agent.ready()
    begun_ms, begun = copter.boot_ms, ours()
    agent.until(lambda: copter.boot_ms > begun_ms + 20_000, "twenty vehicle seconds")
    beats = [message for message in copter.heartbeats() if message.type == 18][begun:]
    assert len(beats) >= 20
    assert {(message.get_srcSystem(), message.autopilot) for message in beats} == {(CONTROLLER_ID, 8)}
    quiet_since = begun_ms
    count = ours()

    def is_quiet() -> bool:
        nonlocal count, quiet_since
        if ours() > count:
            count, quiet_since = ours(), copter.boot_ms
        return copter.boot_ms - quiet_since >= 15_000

    until(is_quiet, "a hung agent to beat no more for 15 vehicle seconds")  # nobody polls meanwhile


def test_lost_commands_are_sent_again(pair: tuple[ScriptedCopter, Agent]) -> None:
    copter, agent = pair
    agent.ready()
    copter.behaviour.ignored_commands[ARM] = 2
    assert agent.result_of(agent.submit(Arm())).accepted
    assert [command.confirmation for command in copter.commands(ARM)] == [0, 1, 2]


def test_a_later_target_supersedes_an_unanswered_one(pair: tuple[ScriptedCopter, Agent]) -> None:
    copter, agent = pair
    agent.ready()
    copter.behaviour.ignored_commands[REPOSITION] = 1
    old, queued, newest = (agent.submit(GoTo((east_m, 0.0, 450.0))) for east_m in (100.0, 200.0, 300.0))
    assert not agent.result_of(old).accepted
    assert "superseded" in agent.result_of(queued).text
    assert agent.result_of(newest).accepted
    sent = [
        DATUM.to_enu(Geodetic(command.x * 1e-7, command.y * 1e-7, command.z))[0]
        for command in copter.commands(REPOSITION)
    ]
    assert sent == pytest.approx([100.0, 300.0], abs=0.02)


def test_no_target_is_sent_again_after_an_order_to_hold(pair: tuple[ScriptedCopter, Agent]) -> None:
    copter, agent = pair
    agent.ready()
    copter.behaviour.ignored_commands[REPOSITION] = 99
    going = agent.submit(GoTo((100.0, 0.0, 450.0)))
    holding = agent.submit(Hold())
    assert agent.result_of(holding).accepted
    assert "superseded" in agent.result_of(going).text
    begun_ms = copter.boot_ms
    agent.until(lambda: copter.boot_ms > begun_ms + 20_000, "twenty vehicle seconds")
    assert len(copter.commands(REPOSITION)) == 1
    assert copter.mode == 17


def test_a_refusal_carries_the_autopilots_reason(pair: tuple[ScriptedCopter, Agent]) -> None:
    copter, agent = pair
    agent.ready()
    copter.behaviour.results[ARM] = 4
    copter.behaviour.refusal = "Arm: Battery 1 low voltage"
    result = agent.result_of(agent.submit(Arm()))
    assert not result.accepted
    assert result.text == "the autopilot did not arm: failed (Arm: Battery 1 low voltage)"
    assert [text.text for text in agent.texts] == ["Arm: Battery 1 low voltage"]


def test_parameters_under_another_name_and_stubborn_and_unknown_ones(pair: tuple[ScriptedCopter, Agent]) -> None:
    copter, agent = pair
    agent.ready()
    copter.behaviour.parameters = {"MAV_GCS_SYSID": 255.0, "RTL_ALT": 1500.0}
    copter.behaviour.stubborn = {"RTL_ALT"}
    renamed = agent.submit(SetParameter("SYSID_MYGCS", 101.0))
    stubborn = agent.submit(SetParameter("RTL_ALT", 9000.0))
    unknown = agent.submit(SetParameter("NO_SUCH", 1.0))
    assert agent.result_of(stubborn).text == "the autopilot keeps RTL_ALT at 1500"
    assert agent.result_of(unknown).text == "the autopilot did not set NO_SUCH to 1: no answer"
    assert agent.result_of(renamed).accepted
    assert copter.behaviour.parameters["MAV_GCS_SYSID"] == 101.0


def test_a_silent_stream_is_asked_for_again(pair: tuple[ScriptedCopter, Agent]) -> None:
    copter, agent = pair
    agent.ready()
    copter.forget_streams()
    count = len(agent.states)
    asked = len(copter.commands(SET_INTERVAL))
    agent.until(lambda: len(copter.commands(SET_INTERVAL)) >= asked + 4, "the streams to be asked for")
    seen = len(agent.states)
    agent.until(lambda: len(agent.states) > max(seen, count) + 3, "positions again")
    stamps = [state.stamp_ms for state in agent.states[count:]]
    assert stamps == sorted(stamps)


def test_the_vehicle_may_come_late_and_come_back() -> None:
    port = free_port()
    with flown(port) as agent:
        with scripted_copter(port) as copter:
            agent.ready()
            assert copter.commands(SET_INTERVAL)
        count = len(agent.states)
        with scripted_copter(port):
            agent.until(lambda: len(agent.states) > count + 3, "states after the reboot")
        stamps = [state.stamp_ms for state in agent.states]
        assert all(stamp >= UNIX_EPOCH_MS for stamp in stamps)


@pytest.mark.parametrize(
    ("behaviour", "noticed"), [(Behaviour(rival=CONTROLLER_ID), True), (Behaviour(rival=CONTROLLER_ID + 1), False)]
)
def test_a_rival_with_the_same_id_is_noticed_and_another_station_is_none(
    pair: tuple[ScriptedCopter, Agent], noticed: bool
) -> None:
    _, agent = pair
    agent.until(
        lambda: len(agent.states) > 20 and agent.states[-1].rival_controller == noticed, "states and the rival in them"
    )
    assert any(state.rival_controller for state in agent.states) == noticed


@pytest.mark.parametrize(
    ("behaviour", "words"),
    [
        (None, "no autopilot answered within 0.5 s"),
        (Behaviour(system_id=7), "speaks as MAVLink system 7, not 1"),
        (Behaviour(autopilot=12), "is not an ArduPilot"),
    ],
)
def test_a_missing_or_foreign_autopilot_is_explained(behaviour: Behaviour | None, words: str) -> None:
    port = free_port()
    copter = ScriptedCopter(port, behaviour) if behaviour else None
    try:
        with (
            flown(port, 0.5 if copter is None else 3.0) as agent,
            pytest.raises(AutopilotError, match=words) as refusal,
        ):
            agent.until(lambda: False, "the error")
        assert f"tcpout://127.0.0.1:{port}" in str(refusal.value)
    finally:
        if copter is not None:
            copter.stop()


def test_a_malformed_url_is_explained() -> None:
    with pytest.raises(AutopilotError, match="smoke://signals: not a usable connection"):
        MavsdkAutopilot("smoke://signals", 1, CONTROLLER_ID, DATUM)
