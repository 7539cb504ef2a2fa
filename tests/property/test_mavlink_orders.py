"""Orders to an autopilot over a link that loses, repeats and refuses: every order ends once, no old target revives."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from vehicle_agent.adapters.ardupilot import steps_of
from vehicle_agent.adapters.mavlink_orders import ASK_AGAIN_S, ASKS, OrderDesk
from vehicle_agent.adapters.mavlink_requests import CommandRequest, ParameterRequest, Request
from vehicle_agent.domain.frames import Datum
from vehicle_agent.ports import (
    Action,
    ActionResult,
    Arm,
    Disarm,
    GoTo,
    Hold,
    Land,
    Order,
    ReturnHome,
    SetParameter,
    SetSpeed,
    TakeOff,
)

DATUM = Datum(36.57, -84.27)
REPOSITION = 192

orders = st.one_of(
    st.integers(0, 900).map(lambda east_m: GoTo((float(east_m), 0.0, 50.0))),
    st.sampled_from([Arm(), Disarm(), TakeOff(30.0), Hold(), ReturnHome(), Land()]),
    st.integers(1, 20).map(lambda speed: SetSpeed(float(speed))),
    st.sampled_from(["SYSID_MYGCS", "RTL_ALT"]).map(lambda name: SetParameter(name, 7.0)),
)
events = st.lists(
    st.one_of(
        orders.map(lambda order: ("order", order)),
        st.floats(0.0, 2.0).map(lambda wait_s: ("wait", wait_s)),
        st.sampled_from([0, 0, 0, 1, 4, 5]).map(lambda result: ("ack", result)),
        st.sampled_from([7.0, 8.0]).map(lambda value: ("parameter", value)),
    ),
    max_size=40,
)


class Link:
    """Keeps what was sent; answers the latest request when told to."""

    def __init__(self) -> None:
        self.sent: list[Request] = []
        self.results: list[ActionResult] = []
        self.now_s = 0.0
        self.desk = OrderDesk(lambda order: steps_of(order, DATUM), lambda request, _asked: self.sent.append(request))

    def play(self, kind: str, value: object) -> None:
        latest = self.sent[-1] if self.sent else None
        if kind == "wait":
            assert isinstance(value, float)
            self.now_s += value
        elif kind == "ack" and isinstance(latest, CommandRequest):
            assert isinstance(value, int)
            self.desk.on_ack(latest.command, value, self.now_s)
        elif kind == "parameter" and isinstance(latest, ParameterRequest):
            assert isinstance(value, float)
            self.desk.on_parameter(latest.name, value, self.now_s)
        self.results += self.desk.tick(self.now_s)

    def settle(self, orders_given: int) -> None:
        """Let every order run out of patience."""
        for _ in range(orders_given * 20 * ASKS):
            self.now_s += ASK_AGAIN_S
            self.results += self.desk.tick(self.now_s)


@given(events)
def test_every_order_ends_exactly_once(history: list[tuple[str, object]]) -> None:
    link = Link()
    given_orders = 0
    for kind, value in history:
        if kind == "order":
            given_orders += 1
            link.desk.submit(Action(given_orders, value), link.now_s)  # type: ignore[arg-type]
        link.play(kind, value)
    link.settle(given_orders)
    assert sorted(result.action_id for result in link.results) == list(range(1, given_orders + 1))
    quiet_since = len(link.sent)
    link.settle(3)
    assert len(link.sent) == quiet_since


@given(events, st.sampled_from([Hold(), ReturnHome(), Land(), Disarm()]), events)
def test_no_target_from_before_an_order_to_stop_is_sent_after_it(
    before: list[tuple[str, object]], stop: Order, after: list[tuple[str, object]]
) -> None:
    link = Link()
    action_id = 0
    for kind, value in before:
        if kind == "order":
            action_id += 1
            link.desk.submit(Action(action_id, value), link.now_s)  # type: ignore[arg-type]
        link.play(kind, value)
    link.desk.submit(Action(action_id + 1, stop), link.now_s)
    sent = len(link.sent)
    for kind, value in after:
        if kind != "order":
            link.play(kind, value)
    link.settle(action_id + 1)
    assert not [r for r in link.sent[sent:] if isinstance(r, CommandRequest) and r.command == REPOSITION]


@given(st.lists(st.integers(0, 900), min_size=2, max_size=8, unique=True), events)
def test_of_several_targets_the_last_is_the_last_sent(east_m: list[int], noise: list[tuple[str, object]]) -> None:
    link = Link()
    for number, metres in enumerate(east_m):
        link.desk.submit(Action(number, GoTo((float(metres), 0.0, 50.0))), link.now_s)
    for kind, value in noise:
        if kind != "order":
            link.play(kind, value)
    link.settle(len(east_m))
    (last,) = steps_of(GoTo((float(east_m[-1]), 0.0, 50.0)), DATUM)[0].alternatives
    assert link.sent[-1] == last
    assert len({id(request) for request in link.sent}) <= 2
