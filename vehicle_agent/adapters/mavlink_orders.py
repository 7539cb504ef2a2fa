"""Carries orders to an autopilot: asks, asks again, and says what became of each. No I/O and no clock.

One lane per parameter, one for the speed and one for everything that steers: in a lane, one order at a time. A later
target supersedes earlier ones, and an order to hold, return or land supersedes whatever still steers elsewhere, so that
no old target is ever sent after a newer order.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from vehicle_agent.adapters.mavlink_requests import CommandRequest, ParameterRequest, Request, Step
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

ASK_AGAIN_S = 0.7
ASKS = 4
IN_PROGRESS_S = 10.0
"""How long an autopilot may work on a command after saying so."""
EXPLANATION_S = 0.25
"""How long to wait, after a refusal, for the text that explains it."""
PARAMETER_TOLERANCE = 1e-5

ACCEPTED = 0
IN_PROGRESS = 5
REFUSALS = {1: "not now", 2: "denied", 3: "not supported", 4: "failed", 6: "cancelled"}
"""MAV_RESULT in words."""
_STEERING_AWAY = (Hold, ReturnHome, Land, Disarm)
_SUPERSEDED_BY_THEM = (GoTo, TakeOff, Arm)


@dataclass(slots=True)
class _Pending:
    """An order under way: which step, which alternative, how often asked."""

    action: Action
    steps: tuple[Step, ...]
    step: int = 0
    alternative: int = 0
    asked: int = 0
    ask_again_s: float = 0.0
    superseded: bool = False
    refusal: str = ""
    explain_until_s: float | None = None

    @property
    def request(self) -> Request:
        return self.steps[self.step].alternatives[self.alternative]


@dataclass(slots=True)
class OrderDesk:
    """Orders under way at one autopilot.

    Attributes
    ----------
    steps_of
        Which requests carry out an order, by this autopilot's ways.
    send
        Puts a request on the wire; the second argument counts the times asked before.
    """

    steps_of: Callable[[Order], tuple[Step, ...]]
    send: Callable[[Request, int], None]
    _lanes: dict[str, deque[_Pending]] = field(default_factory=dict)
    _results: list[ActionResult] = field(default_factory=list)
    _last_text: tuple[float, str] = (-1e9, "")

    def submit(self, action: Action, now_s: float) -> None:
        """Take an order on; `now_s` is any steadily growing clock, the same in every call."""
        lane = self._lanes.setdefault(_lane(action.order), deque())
        pending = _Pending(action, self.steps_of(action.order))
        superseded: tuple[type[Order], ...] = ()
        if isinstance(action.order, GoTo):
            superseded = (GoTo,)
        elif isinstance(action.order, _STEERING_AWAY):
            superseded = _SUPERSEDED_BY_THEM
        elif isinstance(action.order, SetSpeed):
            superseded = (SetSpeed,)
        for waiting in [other for other in lane if isinstance(other.action.order, superseded)]:
            self._supersede(lane, waiting, pending)
        lane.append(pending)
        self._advance(lane, now_s)

    def on_ack(self, command: int, result: int, now_s: float) -> None:
        """Take note of a COMMAND_ACK that is meant for this controller."""
        for lane in self._lanes.values():
            pending = lane[0] if lane else None
            if pending is None or pending.asked == 0 or pending.explain_until_s is not None:
                continue
            request = pending.request
            if not isinstance(request, CommandRequest) or request.command != command:
                continue
            if result == ACCEPTED:
                self._done(lane, pending, now_s)
            elif result == IN_PROGRESS:
                pending.ask_again_s, pending.asked = now_s + IN_PROGRESS_S, ASKS
            else:
                pending.refusal = REFUSALS.get(result, f"result {result}")
                pending.explain_until_s = now_s + EXPLANATION_S

    def on_parameter(self, name: str, value: float, now_s: float) -> None:
        """Take note of a PARAM_VALUE."""
        for lane in self._lanes.values():
            pending = lane[0] if lane else None
            if pending is None or pending.asked == 0:
                continue
            request = pending.request
            if isinstance(request, ParameterRequest) and request.name == name:
                if abs(value - request.value) <= PARAMETER_TOLERANCE * max(1.0, abs(request.value)):
                    self._done(lane, pending, now_s)
                else:
                    self._finish(lane, pending, False, f"the autopilot keeps {name} at {value:g}", now_s)

    def on_text(self, text: str, now_s: float) -> None:
        """Take note of a STATUSTEXT: it may explain a refusal."""
        self._last_text = (now_s, text)

    def tick(self, now_s: float) -> list[ActionResult]:
        """Ask again what is due and take the results since the last tick."""
        for lane in self._lanes.values():
            self._advance(lane, now_s)
        results, self._results = self._results, []
        return results

    def _advance(self, lane: deque[_Pending], now_s: float) -> None:
        while lane:
            pending = lane[0]
            if pending.explain_until_s is not None:
                if now_s < pending.explain_until_s:
                    return
                self._refused(lane, pending, now_s)
            elif pending.asked == 0:
                self._ask(pending, now_s)
                return
            elif now_s < pending.ask_again_s:
                return
            elif pending.superseded:
                self._finish(lane, pending, False, _superseded_text(pending.action.order), now_s)
            elif pending.asked < ASKS:
                self._ask(pending, now_s)
                return
            else:
                pending.refusal = "no answer"
                self._refused(lane, pending, now_s)

    def _ask(self, pending: _Pending, now_s: float) -> None:
        self.send(pending.request, pending.asked)
        pending.asked += 1
        pending.ask_again_s = now_s + ASK_AGAIN_S

    def _supersede(self, lane: deque[_Pending], waiting: _Pending, later: _Pending) -> None:
        """Drop an order; one that is being answered stays until its answer cannot be taken for the later one's."""
        if waiting.asked and waiting.explain_until_s is None and _same_answer(waiting.request, later.request):
            waiting.superseded = True
            return
        lane.remove(waiting)
        self._results.append(ActionResult(waiting.action.action_id, False, _superseded_text(waiting.action.order)))

    def _done(self, lane: deque[_Pending], pending: _Pending, now_s: float) -> None:
        if pending.superseded:
            self._finish(lane, pending, False, _superseded_text(pending.action.order), now_s)
        elif pending.step + 1 < len(pending.steps):
            pending.step, pending.alternative, pending.asked = pending.step + 1, 0, 0
            self._advance(lane, now_s)
        else:
            self._finish(lane, pending, True, "", now_s)

    def _refused(self, lane: deque[_Pending], pending: _Pending, now_s: float) -> None:
        alternatives = pending.steps[pending.step].alternatives
        if pending.alternative + 1 < len(alternatives) and not pending.superseded:
            pending.alternative, pending.asked, pending.explain_until_s = pending.alternative + 1, 0, None
            return
        text = f"the autopilot did not {pending.request.label}: {pending.refusal}"
        said_s, said = self._last_text
        if said and said_s >= now_s - 2 * EXPLANATION_S and pending.explain_until_s is not None:
            text += f" ({said})"
        self._finish(lane, pending, False, text, now_s)

    def _finish(self, lane: deque[_Pending], pending: _Pending, accepted: bool, text: str, now_s: float) -> None:
        lane.remove(pending)
        self._results.append(ActionResult(pending.action.action_id, accepted, text))
        self._advance(lane, now_s)


def _lane(order: Order) -> str:
    if isinstance(order, SetParameter):
        return f"parameter {order.name}"
    return "speed" if isinstance(order, SetSpeed) else "steering"


def _same_answer(request: Request, later: Request) -> bool:
    """Whether the autopilot's answers to the two requests look alike."""
    if isinstance(request, CommandRequest) and isinstance(later, CommandRequest):
        return request.command == later.command
    return isinstance(request, ParameterRequest) and isinstance(later, ParameterRequest) and request.name == later.name


def _superseded_text(order: Order) -> str:
    return f"{type(order).__name__} was superseded by a later order"
